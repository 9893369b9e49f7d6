// A job's picture: its tiles as they form, the whole as EXR and PNG. Any thread.
#pragma once

#include <semaphore>

#include "server/api/picture_source.h"
#include "server/http/router.h"

namespace qray::server {

class PictureHandlers {
 public:
  // `encoders`: pictures encoded at a time: memory, and time to render.
  PictureHandlers(const JobRunner& runner, const PictureSource& pictures, Stores stores,
                  std::counting_semaphore<>& encoders)
      : runner_(runner), pictures_(pictures), stores_(stores), encoders_(encoders) {}
  void add_to(Router& router);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;
  using Which = PictureSource::Which;

  void tiles(const Request& req, Response& res, const std::string& id);
  void light_groups(const Request& req, Response& res, const std::string& id);
  Result<std::optional<int>> group_of(const Request& req, const JobRecord& job) const;
  void exr(const Request& req, Response& res, const std::string& id);
  void png(const Request& req, Response& res, const std::string& id);

  const JobRunner& runner_;
  const PictureSource& pictures_;
  Stores stores_;
  std::counting_semaphore<>& encoders_;
};

}  // namespace qray::server
