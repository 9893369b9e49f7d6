// The head of an HTTP request. What goes on to the parser would be accepted again, as it is but for
// the gate's own fields, which nobody else may send.
#include "server/http/http_head.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace qray::server;
  const auto judge = [](std::string_view head, size_t max_fields) {
    HeadLimits limits;
    limits.max_fields = max_fields;
    return check_head(head, limits);
  };
  const auto verdict = judge(qray::fuzz::as_text({data, size}), 64);
  if (const auto* problem = std::get_if<qray::proto::Problem>(&verdict)) {
    QRAY_CHECK(problem->status >= 400 && problem->status < 600);
    QRAY_CHECK(!problem->title.empty());
    return 0;
  }
  const auto& accepted = std::get<AcceptedHead>(verdict);
  const auto again = judge(accepted.text, 65);  // a length may have been added
  QRAY_CHECK(std::holds_alternative<AcceptedHead>(again));
  std::string expected = accepted.text;
  for (const char* field : {kAcceptsGzip, kRangeField}) {
    const std::string own = std::string("\r\n") + field + ": ";
    for (size_t at; (at = expected.find(own)) != std::string::npos;)
      expected.erase(at, expected.find("\r\n", at + own.size()) - at);
  }
  QRAY_CHECK(std::get<AcceptedHead>(again).text == expected);
  QRAY_CHECK(std::get<AcceptedHead>(again).body_bytes == accepted.body_bytes);
  QRAY_CHECK(std::get<AcceptedHead>(again).close == accepted.close);
  return 0;
}
