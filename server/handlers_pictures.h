// A job's picture: its tiles as they form, the whole as EXR and PNG, and how far two are apart. Any
// thread.
#pragma once

#include <semaphore>

#include "server/jobs/job_runner.h"
#include "server/router.h"

namespace qray::server {

class PictureHandlers {
 public:
  PictureHandlers(JobRunner& runner, Stores stores) : runner_(runner), stores_(stores) {}
  void add_to(Router& router);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;

  void tiles(const Request& req, Response& res, const std::string& id);
  void exr(const Request& req, Response& res, const std::string& id);
  void png(const Request& req, Response& res, const std::string& id);
  void compare(const Request& req, Response& res);

  enum class Which { kSampled, kRecovered };
  // `picture` of a request: "sampled", "recovered", or absent: the recovered one if it is there and
  // `best` is wanted, else the sampled one. kNotFound, kConflict: there is none, or not yet.
  Result<Which> which_picture(const Request& req, const JobRecord& job, bool best) const;
  // The picture so far; kConflict before the first tile.
  Result<Image> image_of(const JobRecord& job);
  // That, or what was recovered of it.
  Result<Image> image_of(const JobRecord& job, Which which);
  // The best picture so far of the job that the parameter names; errors name the parameter.
  Result<Image> image_named(const Request& req, const char* parameter);

  JobRunner& runner_;
  Stores stores_;
  std::counting_semaphore<> encoders_{2};  // pictures encoded at a time: memory, and time to render
};

}  // namespace qray::server
