// /v1/live: sessions that render what their camera sees, frame after frame. A handler parses and
// tells the session; only opening one loads a scene. Any thread; a reader's frames hold its
// connection's thread and go at the reader's own pace.
#pragma once

#include "server/http/router.h"
#include "server/live/live_sessions.h"

namespace qray::server {

class LiveHandlers {
 public:
  LiveHandlers(LiveSessions& sessions, Stores stores, const proto::RequestLimits& limits);
  void add_to(Router& router);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;
  void open(const Request& req, Response& res);
  void set_camera(const Request& req, Response& res, LiveSession& session);
  void set_switches(const Request& req, Response& res, LiveSession& session);
  void set_lights(const Request& req, Response& res, LiveSession& session);
  void frames(const Request& req, Response& res, std::shared_ptr<LiveSession> session);
  std::optional<proto::Problem> check_references(const proto::LiveRequest& request);

  LiveSessions& sessions_;
  Stores stores_;
  proto::RequestLimits limits_;
};

}  // namespace qray::server
