// The frames of a job: how far each is; all their pictures as one archive, or as a file that plays.
// Any thread.
#pragma once

#include <filesystem>
#include <mutex>
#include <semaphore>

#include "server/api/picture_source.h"
#include "server/http/router.h"

namespace qray::server {

class FrameHandlers {
 public:
  // Files are made in <data>/answers. `encoders`: as PictureHandlers'.
  FrameHandlers(JobRunner& runner, const PictureSource& pictures, Stores stores,
                const std::filesystem::path& data, std::counting_semaphore<>& encoders);
  void add_to(Router& router);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;
  using Frames = std::vector<proto::FrameInfo>;

  void list(const Request& req, Response& res, const std::string& id);
  // One frame is not rendered (any more), or is after all.
  void cancel(const Request& req, Response& res, const std::string& id);
  void retry(const Request& req, Response& res, const std::string& id);
  void archive(const Request& req, Response& res, const std::string& id);
  void animation(const Request& req, Response& res, const std::string& id, const char* extension,
                 const char* type);
  struct One {
    JobRecord job;
    proto::FrameInfo frame;
  };
  // The frame that the request names. kNotFound: the job has no such frame, or none at all.
  Result<One> one(const Request& req, const std::string& id) const;
  Frames frames_of_job(const JobRecord& job) const;
  Frames kept_frames(const JobRecord& job) const;  // but for what was canceled since
  // The exposed picture of a frame, its recovered one where that is there.
  Result<Image> picture(const JobRecord& job, int frame, float exposure) const;

  JobRunner& runner_;
  const PictureSource& pictures_;
  Stores stores_;
  const std::filesystem::path data_;
  std::counting_semaphore<>& encoders_;
  std::mutex canceled_mutex_;  // over reading and writing which frames are
};

}  // namespace qray::server
