// Thousands of orders of requests; the first that fails is shrunk and printed with its seed.
//   QRAY_ORDERS=10000 QRAY_ORDERS_ON_POSTGRESQL=1000 QRAY_FIRST_ORDER=1 order_tests
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "tests/orders/ground.h"
#include "tests/orders/order.h"
#include "tests/support/sanitized.h"

namespace qray::server::test {
namespace {

int64_t number_of(const char* name, int64_t otherwise) {
  const char* given = std::getenv(name);
  return given ? std::atoll(given) : otherwise;
}

void try_orders(int64_t count) {
  const int64_t first = number_of("QRAY_FIRST_ORDER", 1);
  for (int64_t seed = first; seed < first + count; ++seed) {
    const Order order = random_order(static_cast<uint64_t>(seed));
    const std::string failure = try_order(order);
    if (failure.empty()) continue;
    std::fprintf(stderr, "order %lld fails and is shrunk: %s", static_cast<long long>(seed),
                 failure.c_str());
    const Order small = shrunk(order);
    FAIL() << "order " << seed << ": " << failure << order.text() << "shrunk to: " << small.text()
           << try_order(small);
  }
}

constexpr const char* kNotHere = "sanitizers have functions of the C library themselves";

TEST(Orders, NoOrderOfRequestsLosesOrDoublesAnything) {
  if (qray::test::kSanitized) GTEST_SKIP() << kNotHere;
  try_orders(number_of("QRAY_ORDERS", 300));
}

#ifdef QRAY_POSTGRES
TEST(Orders, NorOnPostgreSql) {
  if (qray::test::kSanitized) GTEST_SKIP() << kNotHere;
  qray::test::PostgresServer* postgres = qray::test::PostgresServer::instance();
  if (!postgres) GTEST_SKIP() << qray::test::PostgresServer::why();
  Ground::instance().use(*postgres);
  try_orders(number_of("QRAY_ORDERS_ON_POSTGRESQL", 30));
}
#endif

}  // namespace
}  // namespace qray::server::test
