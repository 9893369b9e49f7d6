// Answers in one place: JSON, bytes, and problem+json by error code. Any thread.
#pragma once

#include <httplib.h>

#include "core/base/byte_io.h"
#include "core/base/result.h"
#include "proto/messages.h"

namespace qray::server {

void reply_json(httplib::Response& res, int status, std::string json);
void reply_bytes(httplib::Response& res, const Bytes& bytes, const char* content_type);
void reply_problem(httplib::Response& res, const proto::Problem& problem);
void reply_not_json(httplib::Response& res);  // 415
// The status follows the code; `where` becomes the pointer when it is one ("/table").
void reply_error(httplib::Response& res, const Error& error);

}  // namespace qray::server
