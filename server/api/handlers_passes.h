// The passes of an ended job's pictures: all as one EXR, each as PNG. Any thread.
#pragma once

#include <semaphore>

#include "server/api/picture_source.h"
#include "server/http/router.h"

namespace qray::server {

class PassHandlers {
 public:
  // `encoders`: pictures encoded at a time: memory, and time to render.
  PassHandlers(Stores stores, std::counting_semaphore<>& encoders)
      : stores_(stores), encoders_(encoders) {}
  void add_to(Router& router);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;

  void list(const Request& req, Response& res, const std::string& id);
  void exr(const Request& req, Response& res, const std::string& id);
  void png(const Request& req, Response& res, const std::string& id);
  // Of the frame that the request names. kNotFound: the job asks for no passes; kConflict: they are
  // not there yet.
  Result<std::filesystem::path> file(const Request& req, const JobRecord& job) const;

  Stores stores_;
  std::counting_semaphore<>& encoders_;
};

}  // namespace qray::server
