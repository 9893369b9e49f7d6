#include "server/http/http_head.h"

#include <algorithm>
#include <charconv>

namespace qray::server {
namespace {

proto::Problem refuse(int status, std::string title, std::string detail) {
  return {status, std::move(title), std::move(detail), {}};
}

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; }

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](char c) { return lower(c); });
  return out;
}

bool is_token_char(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos;
}

bool is_token(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), is_token_char);
}

std::string_view trim(std::string_view text) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

bool has_control(std::string_view text) {
  return std::any_of(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) < 32 && c != '\t') || c == 127;
  });
}

struct RequestLine {
  std::string_view method, target, version;
};

std::optional<RequestLine> split_request_line(std::string_view line) {
  const size_t first = line.find(' '), last = line.rfind(' ');
  if (first == std::string_view::npos || last == first) return std::nullopt;
  return RequestLine{line.substr(0, first), line.substr(first + 1, last - first - 1),
                     line.substr(last + 1)};
}

std::optional<proto::Problem> check_request_line(const std::optional<RequestLine>& line,
                                                 const HeadLimits& limits) {
  if (!line || !is_token(line->method) || line->target.empty() ||
      line->target.find(' ') != std::string_view::npos) {
    return refuse(400, "Bad request line", "expected METHOD /path HTTP/1.1");
  }
  if (line->target.size() > limits.max_target_bytes) {
    return refuse(414, "Address too long",
                  "expected at most " + std::to_string(limits.max_target_bytes) + " bytes");
  }
  if (line->target.front() != '/') {
    return refuse(400, "Bad request line", "expected an address that starts with /");
  }
  if (line->version != "HTTP/1.1" && line->version != "HTTP/1.0") {
    return refuse(505, "Version not supported", "expected HTTP/1.1");
  }
  static constexpr std::string_view kMethods[] = {"GET",    "HEAD",    "POST", "PUT",
                                                  "DELETE", "OPTIONS", "PATCH"};
  if (std::find(std::begin(kMethods), std::end(kMethods), line->method) == std::end(kMethods)) {
    return refuse(501, "Method not implemented", "");
  }
  return std::nullopt;
}

// What the fields say about the body and the connection.
struct Fields {
  size_t count = 0, hosts = 0, lengths = 0;
  std::string length, connection, content_type, codings;
  std::string kept;  // lines for the parser
};

std::optional<proto::Problem> check_field(std::string_view line, const HeadLimits& limits,
                                          Fields& fields) {
  if (++fields.count > limits.max_fields) {
    return refuse(431, "Too many header fields",
                  "expected at most " + std::to_string(limits.max_fields));
  }
  if (line.size() > limits.max_line_bytes) {
    return refuse(431, "Header field too long",
                  "expected at most " + std::to_string(limits.max_line_bytes) + " bytes a line");
  }
  const size_t colon = line.find(':');
  if (colon == std::string_view::npos || !is_token(line.substr(0, colon)) || has_control(line)) {
    return refuse(400, "Bad header field", "expected Name: value");
  }
  const std::string name = lower(line.substr(0, colon));
  const std::string_view value = trim(line.substr(colon + 1));
  if (name == "transfer-encoding") {
    return refuse(411, "Length required", "expected Content-Length; Transfer-Encoding is refused");
  }
  if (name == "content-encoding") {
    return refuse(415, "Content coding not supported", "expected a body that is not encoded");
  }
  if (name == "content-length") {
    ++fields.lengths;
    fields.length = value;
  } else if (name == "host") {
    ++fields.hosts;
  } else if (name == "connection") {
    fields.connection = lower(value);
  } else if (name == "content-type") {
    fields.content_type = lower(value);
  } else if (name == "range") {
    if (value.find(',') != std::string_view::npos) {
      return refuse(416, "Range not satisfiable", "expected at most one range");
    }
    fields.kept.append(kRangeField).append(": ").append(value).append("\r\n");
    return std::nullopt;
  } else if (name == "accept-encoding") {
    fields.codings.append(lower(value)).append(",");
    return std::nullopt;  // the library would compress every answer
  } else if (name == "remote_addr" || name == "local_addr" || name == "remote_port" ||
             name == "local_port" || name == lower(kAcceptsGzip) || name == lower(kRangeField)) {
    return std::nullopt;  // names by which the parser and this gate tell handlers what is true
  }
  fields.kept.append(line).append("\r\n");
  return std::nullopt;
}

// Of a list in small letters: whether gzip, or else "*", stands there with a weight above 0 (RFC
// 9110, section 12.5.3).
bool accepts_gzip(std::string_view codings) {
  std::optional<bool> gzip, any;
  while (!codings.empty()) {
    const size_t end = std::min(codings.find(','), codings.size());
    const std::string_view coding = codings.substr(0, end);
    codings.remove_prefix(std::min(end + 1, codings.size()));
    const size_t semicolon = std::min(coding.find(';'), coding.size());
    const std::string_view name = trim(coding.substr(0, semicolon)),
                           weight = coding.substr(semicolon);
    const bool accepted =
        weight.empty() || weight.find_first_of("123456789") != std::string_view::npos;
    if (name == "gzip" || name == "x-gzip") gzip = accepted;
    if (name == "*") any = accepted;
  }
  return gzip.value_or(any.value_or(false));
}

std::optional<proto::Problem> check_body(Fields& fields, std::string_view method,
                                         size_t max_body_bytes, size_t& body_bytes) {
  if (fields.content_type.starts_with("multipart/")) {
    return refuse(415, "Unsupported media type", "multipart is refused");
  }
  if (fields.lengths > 1) {
    return refuse(400, "Bad length", "expected one Content-Length, got several");
  }
  const bool may_have_body = method == "POST" || method == "PUT" || method == "PATCH";
  if (fields.lengths == 0) {  // no body (RFC 9112, section 6.3), and the parser is told so
    if (may_have_body) fields.kept += "Content-Length: 0\r\n";
    return std::nullopt;
  }
  const char* end = fields.length.data() + fields.length.size();
  uint64_t length = 0;
  const auto [stop, error] = std::from_chars(fields.length.data(), end, length);
  const bool digits =
      !fields.length.empty() && fields.length.find_first_not_of("0123456789") == std::string::npos;
  if (!digits || (error != std::errc{} && error != std::errc::result_out_of_range)) {
    return refuse(400, "Bad length", "expected Content-Length to be a decimal number");
  }
  if (error == std::errc::result_out_of_range || length > max_body_bytes) {
    return refuse(413, "Content too large",
                  "expected at most " + std::to_string(max_body_bytes) + " bytes");
  }
  if (length > 0 && !may_have_body) {
    return refuse(400, "Body not expected", "expected no body with " + std::string(method));
  }
  body_bytes = static_cast<size_t>(length);
  return std::nullopt;
}

}  // namespace

std::variant<AcceptedHead, proto::Problem> check_head(std::string_view head,
                                                      const HeadLimits& limits,
                                                      const BodyLimit& body_limit) {
  const auto next_line = [&]() -> std::optional<std::string_view> {
    const size_t end = head.find("\r\n");
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view line = head.substr(0, end);
    head.remove_prefix(end + 2);
    return line;
  };

  const std::optional<std::string_view> first = next_line();
  if (!first || has_control(*first)) {
    return refuse(400, "Bad request line", "expected lines that end with CR LF");
  }
  const std::optional<RequestLine> request = split_request_line(*first);
  if (auto bad = check_request_line(request, limits)) return *bad;

  Fields fields;
  for (;;) {
    const std::optional<std::string_view> line = next_line();
    if (!line) return refuse(400, "Bad header field", "expected lines that end with CR LF");
    if (line->empty()) break;
    if (auto bad = check_field(*line, limits, fields)) return *bad;
  }
  if (fields.hosts > 1 || (fields.hosts == 0 && request->version == "HTTP/1.1")) {
    return refuse(400, "Bad Host", "expected one Host field");
  }

  AcceptedHead accepted;
  const std::string_view path = request->target.substr(0, request->target.find('?'));
  const size_t max_body_bytes =
      body_limit ? body_limit(request->method, path) : limits.max_body_bytes;
  if (auto bad = check_body(fields, request->method, max_body_bytes, accepted.body_bytes))
    return *bad;
  accepted.close = fields.connection == "close" ||
                   (request->version == "HTTP/1.0" && fields.connection != "keep-alive");
  if (accepts_gzip(fields.codings)) fields.kept.append(kAcceptsGzip).append(": 1\r\n");
  accepted.text.append(*first).append("\r\n").append(fields.kept).append("\r\n");
  return accepted;
}

}  // namespace qray::server
