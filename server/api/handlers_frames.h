// The frames of a job: how far each is; all their pictures as one archive, or as a file that plays.
// Any thread.
#pragma once

#include <filesystem>
#include <semaphore>

#include "server/api/picture_source.h"
#include "server/http/router.h"

namespace qray::server {

class FrameHandlers {
 public:
  // Files are made in <data>/answers. `encoders`: as PictureHandlers'.
  FrameHandlers(const PictureSource& pictures, Stores stores, const std::filesystem::path& data,
                std::counting_semaphore<>& encoders);
  void add_to(Router& router);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;
  using Frames = std::vector<proto::FrameInfo>;

  void list(const Request& req, Response& res, const std::string& id);
  void archive(const Request& req, Response& res, const std::string& id);
  void animation(const Request& req, Response& res, const std::string& id, const char* extension,
                 const char* type);
  Frames frames_of_job(const JobRecord& job) const;
  // The exposed picture of a frame, its recovered one where that is there.
  Result<Image> picture(const JobRecord& job, int frame, float exposure) const;

  const PictureSource& pictures_;
  Stores stores_;
  const std::filesystem::path data_;
  std::counting_semaphore<>& encoders_;
};

}  // namespace qray::server
