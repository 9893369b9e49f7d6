#include "server/http/reply.h"

#include <spdlog/spdlog.h>

#include "core/base/sha256.h"
#include "server/http/byte_range.h"
#include "server/http/http_head.h"

namespace qray::server {
namespace {

struct StatusText {
  int status;
  const char* title;
};

StatusText status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalid:
      return {422, "Wrong request"};
    case ErrorCode::kUnsupported:
      return {422, "Not supported"};
    case ErrorCode::kNotFound:
      return {404, "Not found"};
    case ErrorCode::kTooLarge:
      return {413, "Too large"};
    case ErrorCode::kConflict:
      return {409, "Not possible now"};
    case ErrorCode::kCanceled:
      return {409, "Canceled"};
    case ErrorCode::kBusy:
      return {429, "Too many jobs"};
    case ErrorCode::kIo:
      return {503, "Not now"};  // such as a full disk
    case ErrorCode::kCorrupt:
      break;
  }
  return {500, "Internal error"};
}

std::string tag_of(const Digest& content) { return '"' + content.hex().substr(0, 32) + '"'; }

// Sets the ETag; true: the client has this content, and is told so.
bool known_to(const httplib::Request& req, httplib::Response& res, const Digest& content) {
  const std::string tag = tag_of(content);
  res.set_header("ETag", tag);
  if (req.get_header_value("If-None-Match").find(tag) == std::string::npos) return false;
  res.status = 304;
  res.set_header("Cache-Control", "no-cache");
  return true;
}

// The part that is asked for; none: the whole. The fields that speak of parts are set.
std::optional<ByteRange> asked_part(const httplib::Request& req, httplib::Response& res,
                                    size_t whole) {
  res.headers.erase("Accept-Ranges");  // the server's usual "none"
  res.set_header("Accept-Ranges", "bytes");
  if (req.method != "GET" || !req.has_header(kRangeField)) return {};
  if (req.has_header("If-Range") &&
      req.get_header_value("If-Range") != res.get_header_value("ETag"))
    return {};
  const auto part = parse_range(req.get_header_value(kRangeField), whole);
  if (!part) return {};
  const std::string bytes = std::to_string(part->begin) + "-" +
                            std::to_string(part->begin + std::max<size_t>(part->size, 1) - 1);
  res.set_header("Content-Range",
                 "bytes " + (part->size > 0 ? bytes : "*") + "/" + std::to_string(whole));
  return part;
}

}  // namespace

void reply_json(httplib::Response& res, int status, std::string json) {
  res.status = status;
  res.set_header("Cache-Control", "no-store");
  res.set_content(std::move(json), "application/json");
}

void reply_bytes(httplib::Response& res, const Bytes& bytes, const char* content_type) {
  res.status = 200;
  res.set_header("Cache-Control", "no-store");
  res.set_content(reinterpret_cast<const char*>(bytes.data()), bytes.size(), content_type);
}

bool is_tag_of(const std::string& if_none_match, std::string_view content) {
  return if_none_match.find(tag_of(sha256(content))) != std::string::npos;
}

void reply_tagged(const httplib::Request& req, httplib::Response& res, std::string json) {
  if (!known_to(req, res, sha256(std::string_view(json)))) reply_json(res, 200, std::move(json));
}

void reply_tagged(const httplib::Request& req, httplib::Response& res, const Bytes& bytes,
                  const char* content_type) {
  if (known_to(req, res, sha256(bytes))) return;
  const std::optional<ByteRange> part = asked_part(req, res, bytes.size());
  if (!part) return reply_bytes(res, bytes, content_type);
  if (part->size == 0)
    return reply_problem(
        res,
        {416, "Range not satisfiable", "it has " + std::to_string(bytes.size()) + " bytes", {}});
  res.status = 206;
  res.set_header("Cache-Control", "no-store");
  res.set_content(reinterpret_cast<const char*>(bytes.data()) + part->begin, part->size,
                  content_type);
}

void reply_file(httplib::Response& res, MappedFile file, const std::string& name,
                const char* content_type) {
  static constexpr size_t kAtOnceBytes = 1 << 18;
  const auto shared = std::make_shared<const MappedFile>(std::move(file));
  res.set_header("Content-Disposition", "attachment; filename=\"" + name + "\"");
  res.set_content_provider(shared->bytes().size(), content_type,
                           [shared](size_t offset, size_t size, httplib::DataSink& sink) {
                             const auto* bytes =
                                 reinterpret_cast<const char*>(shared->bytes().data());
                             return sink.write(bytes + offset, std::min(size, kAtOnceBytes));
                           });
}

void reply_problem(httplib::Response& res, const proto::Problem& problem) {
  res.status = problem.status;
  res.set_header("Cache-Control", "no-store");
  if (problem.status == 401) res.set_header("WWW-Authenticate", "Bearer realm=\"qray\"");
  if (problem.status == 429 || problem.status == 503) res.set_header("Retry-After", "5");
  res.set_content(proto::problem_to_json(problem), "application/problem+json");
}

void reply_not_json(httplib::Response& res) {
  reply_problem(res,
                {415, "Unsupported media type", "expected Content-Type: application/json", {}});
}

void reply_error(httplib::Response& res, const Error& error) {
  const auto [status, title] = status_of(error.code);
  proto::Problem problem{status, title, error.text(), {}};
  if (status >= 500) {
    spdlog::error("answered {}: {}", status, error.text());
    // Paths are not for clients.
    problem.detail = status == 503 ? "the server's disk or system refused; try again later" : "";
    return reply_problem(res, problem);
  }
  if (error.where.starts_with('/')) problem.errors.push_back({error.where, error.message});
  reply_problem(res, problem);
}

}  // namespace qray::server
