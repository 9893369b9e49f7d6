// Jobs: posted, listed, seen, changed, canceled, paused, resumed, extended, deleted; their logs. A
// handler parses and enqueues; it never renders. Any thread.
#pragma once

#include <semaphore>

#include "server/http/router.h"
#include "server/jobs/job_runner.h"

namespace qray::server {

class JobHandlers {
 public:
  JobHandlers(JobRunner& runner, Stores stores, const EventLog& events,
              const proto::RequestLimits& limits);
  void add_to(Router& router);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;

  void create(const Request& req, Response& res);
  void list(const Request& req, Response& res);
  void remove_many(const Request& req, Response& res);
  void get(const Request& req, Response& res, const std::string& id);
  void update(const Request& req, Response& res, const std::string& id);
  void extend(const Request& req, Response& res, const std::string& id);
  void remove(Response& res, const std::string& id);
  void log(Response& res, const std::string& id);

  void reply_job(Response& res, int status, const Result<JobRecord>& job) const;
  proto::JobInfo info(const JobRecord& job) const;  // with a running job's progress
  std::optional<proto::Problem> check_references(JobRequest& request);

  JobRunner& runner_;
  Stores stores_;
  const EventLog& events_;
  proto::RequestLimits limits_;
  std::counting_semaphore<> waiters_;  // clients that may wait for news at a time
};

}  // namespace qray::server
