// Webhooks: who is told of jobs' ends. Any thread.
#pragma once

#include "proto/messages.h"
#include "server/http/router.h"
#include "server/store/webhook_store.h"

namespace qray::server {

class WebhookHandlers {
 public:
  WebhookHandlers(WebhookStore& webhooks, const proto::RequestLimits& limits)
      : webhooks_(webhooks), limits_(limits) {}
  void add_to(Router& router);

 private:
  void add(const httplib::Request& req, httplib::Response& res);
  void list(httplib::Response& res) const;
  void remove(httplib::Response& res, const std::string& id);

  WebhookStore& webhooks_;
  const proto::RequestLimits limits_;
};

}  // namespace qray::server
