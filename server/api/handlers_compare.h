// How far the pictures of two jobs are apart: GET /v1/compare in numbers, /v1/compare.png as a map;
// and GET /v1/jobs/{id}/metrics, how one job's picture came nearer to a reference. Any thread.
#pragma once

#include <semaphore>

#include "server/api/picture_source.h"
#include "server/http/router.h"

namespace qray::server {

class CompareHandlers {
 public:
  // `encoders`: pictures worked on at a time.
  CompareHandlers(const PictureSource& pictures, Stores stores, std::counting_semaphore<>& encoders)
      : pictures_(pictures), stores_(stores), encoders_(encoders) {}
  void add_to(Router& router);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;

  void compare(const Request& req, Response& res);
  void map(const Request& req, Response& res);
  void metrics(const Request& req, Response& res, const std::string& id);
  // The picture of the job that the parameter names, the recovered one if it is there, or that of
  // the moment; errors name the parameter.
  Result<Image> image_named(const Request& req, const char* parameter, const char* moment);
  struct Pair {
    Image a, b;
  };
  Result<Pair> both(const Request& req);  // the pictures to compare
  // By the moments' numbers, of those whose picture is kept.
  Result<std::map<uint32_t, double>> errors(const JobRecord& job,
                                            const std::vector<proto::Moment>& moments,
                                            const Image& reference);

  const PictureSource& pictures_;
  Stores stores_;
  std::counting_semaphore<>& encoders_;
};

}  // namespace qray::server
