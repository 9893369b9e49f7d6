// The gate before cpp-httplib 0.11.4's parser: the head of a request is read whole and judged here,
// and what the parser mishandles (chunked and coded bodies, double lengths, ranges, long lines)
// never reaches it. Pure functions; any thread.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "proto/messages.h"

namespace qray::server {

struct HeadLimits {
  size_t max_head_bytes = 16 * 1024;
  size_t max_target_bytes = 1024;
  size_t max_line_bytes = 4 * 1024;
  size_t max_fields = 64;
  size_t max_body_bytes = 4u << 20;
};

// The field by which a handler knows that the client takes gzip; from a client it is dropped.
inline constexpr const char* kAcceptsGzip = "Qray-Accepts-Gzip";
// Likewise the client's Range, which the library would apply to every answer.
inline constexpr const char* kRangeField = "Qray-Range";

struct AcceptedHead {
  std::string text;       // for the parser: Range and Accept-Encoding by the names above
  size_t body_bytes = 0;  // that follow the head
  bool close = false;     // the client asks for the connection to end
};

// The most bytes that a body may have by its request's method and path (without a query).
using BodyLimit = std::function<size_t(std::string_view method, std::string_view path)>;

// `head` ends with the empty line. RFC 9112 sections 3, 5 and 6; a refused head ends the
// connection. Without `body_limit`, any body may have `max_body_bytes`.
std::variant<AcceptedHead, proto::Problem> check_head(std::string_view head,
                                                      const HeadLimits& limits,
                                                      const BodyLimit& body_limit = {});

}  // namespace qray::server
