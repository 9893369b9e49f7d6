// Weights for recovery: upload what `qray recover train` made, list, look, download, delete. Any
// thread.
#pragma once

#include "server/http/router.h"
#include "server/store/weights_store.h"

namespace qray::server {

class WeightsHandlers {
 public:
  explicit WeightsHandlers(WeightsStore& weights) : weights_(weights) {}
  void add_to(Router& router);

 private:
  void add(const httplib::Request& req, httplib::Response& res);
  void file(httplib::Response& res, const std::string& id);

  WeightsStore& weights_;
};

}  // namespace qray::server
