// The processes of a farm: which there are, and asking one to take no more jobs. Of a server alone
// there are none. Any thread.
#pragma once

#include <httplib.h>

#include "server/http/router.h"
#include "server/store/shared_jobs.h"

namespace qray::server {

class WorkerHandlers {
 public:
  explicit WorkerHandlers(SharedJobs* shared) : shared_(shared) {}  // null: no farm
  void add_to(Router& router);

 private:
  void list(httplib::Response& res) const;
  void drain(httplib::Response& res, const std::string& id) const;

  SharedJobs* shared_;
};

}  // namespace qray::server
