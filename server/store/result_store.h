// Pictures of ended jobs under <data>/results/<job>/, the last few kept in memory. Any thread.
#pragma once

#include <list>
#include <memory>
#include <mutex>

#include "server/model/job.h"
#include "server/store/picture.h"

namespace qray::server {

class ResultStore {
 public:
  // Keeps pictures of at most `cache_bytes` in memory (the newest one in any case).
  explicit ResultStore(std::filesystem::path data, size_t cache_bytes = 256u << 20)
      : folder_(std::move(data) / "results"), cache_bytes_(cache_bytes) {}

  // Writes the files; the picture is then on disk and in memory.
  Status save(JobId id, const Film& film, const ImageMetadata& metadata);
  // Beside it, before it: what recovery made of the film.
  Status save_recovered(JobId id, const Image& recovered, const ImageMetadata& metadata);
  Result<Image> load_recovered(JobId id) const;  // kNotFound: there is none
  void remove(JobId id);
  // Film::noise() at the end; kNotFound: there is none.
  Result<Image> load_noise(JobId id) const;
  // The row y alone of these: of a large picture a hundredth of the time.
  Result<Image> load_recovered_row(JobId id, int y) const;
  Result<Image> load_noise_row(JobId id, int y) const;
  // kNotFound: the job rendered nothing.
  Result<std::shared_ptr<const Picture>> load(JobId id);
  bool has_recovered(JobId id) const;
  // The file of the picture, or of what was recovered of it; `height`: of the picture. kNotFound;
  // kCorrupt: it is cut off, as of what the others load.
  Result<Bytes> load_file(JobId id, bool recovered, int height) const;

 private:
  std::filesystem::path image_file(JobId id) const { return folder_ / id.text() / "image.exr"; }
  std::filesystem::path recovered_file(JobId id) const {
    return folder_ / id.text() / "recovered.exr";
  }
  std::filesystem::path noise_file(JobId id) const { return folder_ / id.text() / "noise.exr"; }
  void remember(JobId id, std::shared_ptr<const Picture> picture);

  std::filesystem::path folder_;
  size_t cache_bytes_;
  std::mutex mutex_;
  std::list<std::pair<JobId, std::shared_ptr<const Picture>>> recent_;  // newest use first
};

}  // namespace qray::server
