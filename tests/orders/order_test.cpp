// Thousands of orders of requests; the first that fails is shrunk and printed with its seed.
//   QRAY_ORDERS=10000 QRAY_FIRST_ORDER=1 order_tests
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/orders/order.h"
#include "tests/support/sanitized.h"

namespace qray::server::test {
namespace {

int64_t number_of(const char* name, int64_t otherwise) {
  const char* given = std::getenv(name);
  return given ? std::atoll(given) : otherwise;
}

TEST(Orders, NoOrderOfRequestsLosesOrDoublesAnything) {
  if (qray::test::kSanitized)
    GTEST_SKIP() << "sanitizers have functions of the C library themselves";
  const int64_t first = number_of("QRAY_FIRST_ORDER", 1), count = number_of("QRAY_ORDERS", 300);
  for (int64_t seed = first; seed < first + count; ++seed) {
    const Order order = random_order(static_cast<uint64_t>(seed));
    const std::string failure = try_order(order);
    if (failure.empty()) continue;
    const Order small = shrunk(order);
    FAIL() << "order " << seed << ": " << failure << order.text() << "shrunk to: " << small.text()
           << try_order(small);
  }
}

}  // namespace
}  // namespace qray::server::test
