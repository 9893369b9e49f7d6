// POST, GET, list and cancel of jobs; their tiles and pictures. A handler parses and enqueues; it
// never renders. Any thread.
#pragma once

#include <semaphore>

#include "server/jobs/job_runner.h"
#include "server/router.h"

namespace qray::server {

class JobHandlers {
 public:
  JobHandlers(JobRunner& runner, Stores stores, const proto::RequestLimits& limits);
  void add_to(Router& router);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;

  void create(const Request& req, Response& res);
  void list(const Request& req, Response& res);
  void get(Response& res, const std::string& id);
  void cancel(Response& res, const std::string& id);
  void tiles(const Request& req, Response& res, const std::string& id);
  void exr(const Request& req, Response& res, const std::string& id);
  void png(const Request& req, Response& res, const std::string& id);

  proto::JobInfo info(const JobRecord& job) const;  // with the running job's progress
  Result<JobRecord> find(const std::string& id) const;
  std::optional<proto::Problem> check_references(proto::JobRequest& request);
  enum class Which { kSampled, kRecovered };
  // `picture` of a request: "sampled", "recovered", or absent: the recovered one if it is there and
  // `best` is wanted, else the sampled one. kNotFound, kConflict: there is none, or not yet.
  Result<Which> which_picture(const Request& req, const JobRecord& job, bool best) const;
  // The picture so far; kConflict before the first tile.
  Result<Image> image_of(const JobRecord& job);

  JobRunner& runner_;
  Stores stores_;
  proto::RequestLimits limits_;
  std::counting_semaphore<> encoders_{2};  // pictures encoded at a time: memory, and time to render
};

}  // namespace qray::server
