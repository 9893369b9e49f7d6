// Answers in one place: JSON, bytes, and problem+json by error code. Any thread.
#pragma once

#include <httplib.h>

#include "core/base/byte_io.h"
#include "core/base/file.h"
#include "core/base/result.h"
#include "proto/messages.h"

namespace qray::server {

// Bytes that are no format of the web.
inline constexpr const char* kBytesType = "application/octet-stream";

void reply_json(httplib::Response& res, int status, std::string json);
void reply_bytes(httplib::Response& res, const Bytes& bytes, const char* content_type);
// The same for a GET, with an ETag; 304 where the client has it already.
void reply_tagged(const httplib::Request& req, httplib::Response& res, std::string json);
// Of bytes, the part that the client's Range names (206), where If-Range names no other content.
void reply_tagged(const httplib::Request& req, httplib::Response& res, const Bytes& bytes,
                  const char* content_type);
// A file to be kept under that name, as it is read; it may be removed as soon as this returns.
void reply_file(httplib::Response& res, MappedFile file, const std::string& name,
                const char* content_type);
// Whether an If-None-Match header names this content.
bool is_tag_of(const std::string& if_none_match, std::string_view content);
void reply_problem(httplib::Response& res, const proto::Problem& problem);
void reply_not_json(httplib::Response& res);  // 415
// The status follows the code; `where` becomes the pointer when it is one ("/table"). What the
// operating system refused is 503, and in the log.
void reply_error(httplib::Response& res, const Error& error);

}  // namespace qray::server
