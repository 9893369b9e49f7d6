// GET /v1/jobs/{id}/view.png and lobe.png: what an ended job's table knows, as pictures. Unlike the
// other handlers these work: they load the table and trace first hits, on one thread, one answer at
// a time, and hold no lock meanwhile. Any thread.
#pragma once

#include <semaphore>
#include <stop_token>

#include "server/jobs/job_runner.h"
#include "server/router.h"

namespace qray::server {

class ViewHandlers {
 public:
  explicit ViewHandlers(Stores stores) : stores_(stores) {}
  void add_to(Router& router);
  void stop() { stop_.request_stop(); }  // pictures that are being made are given up

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;
  struct Shown;

  void view(const Request& req, Response& res, const std::string& id);
  void lobe(const Request& req, Response& res, const std::string& id);
  // kNotFound; kConflict: it has not succeeded, or left no table.
  Result<JobRecord> find(const std::string& id) const;
  Result<Shown> load(const JobRecord& job);

  Stores stores_;
  std::stop_source stop_;
  std::counting_semaphore<> turns_{1};  // a table may take a quarter of a GiB
};

}  // namespace qray::server
