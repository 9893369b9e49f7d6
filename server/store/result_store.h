// Pictures of ended jobs under <data>/results/<job>/, frames after the first
// in frame-<number>/ there, the last few kept in memory. Any thread.
#pragma once

#include <list>
#include <memory>
#include <mutex>
#include <set>

#include "core/job/picture_passes.h"
#include "server/model/job.h"
#include "server/store/picture.h"

namespace qray::server {

// Whose picture: a job's, or one of its frames'. The first frame is the job's own picture.
struct PictureKey {
  PictureKey(JobId of_job, int of_frame = 0) : job(of_job), frame(of_frame) {}
  JobId job;
  int frame = 0;
  bool operator==(const PictureKey&) const = default;
};

class ResultStore {
 public:
  // Keeps pictures of at most `cache_bytes` in memory (the newest one in any case).
  explicit ResultStore(std::filesystem::path data, size_t cache_bytes = 256u << 20)
      : folder_(std::move(data) / "results"), cache_bytes_(cache_bytes) {}

  // Writes the files; the picture is then on disk and in memory.
  Status save(const PictureKey& key, const Film& film, const ImageMetadata& metadata);
  // Beside it, before it: what recovery made of the film.
  Status save_recovered(const PictureKey& key, const Image& recovered,
                        const ImageMetadata& metadata);
  // The pictures of groups of lights are files of their own too: a mix needs no others.
  Status save_passes(const PictureKey& key, const LayeredPicture& passes);
  Result<Image> load_light_group(const PictureKey& key, size_t group) const;
  // The file of the passes: layers of one EXR. kNotFound: the job has none, or not yet.
  std::filesystem::path passes_file(const PictureKey& key) const {
    return folder(key) / "passes.exr";
  }
  Result<Image> load_recovered(const PictureKey& key) const;  // kNotFound: there is none
  void remove(JobId id);                                      // all its frames'
  void remove_half_written(JobId id);                         // pre: nobody renders it
  // What is known of a job's frames, as it was last kept. kNotFound: nothing is.
  Status save_frames(JobId id, std::string_view json);
  Result<std::string> load_frames(JobId id) const;
  // Which of a job's frames are not to be rendered; of a job that is not there none.
  Status save_canceled_frames(JobId id, const std::set<int>& frames);
  std::set<int> canceled_frames(JobId id) const;
  // Changes whenever that does.
  std::filesystem::file_time_type canceled_frames_at(JobId id) const;
  // Film::noise() at the end; kNotFound: there is none.
  Result<Image> load_noise(const PictureKey& key) const;
  // The row y alone of these: of a large picture a hundredth of the time.
  Result<Image> load_recovered_row(const PictureKey& key, int y) const;
  Result<Image> load_noise_row(const PictureKey& key, int y) const;
  // kNotFound: the job rendered nothing.
  Result<std::shared_ptr<const Picture>> load(const PictureKey& key);
  bool has_recovered(const PictureKey& key) const;
  // The file of the picture, or of what was recovered of it; `height`: of the picture. kNotFound;
  // kCorrupt: it is cut off, as of what the others load.
  Result<Bytes> load_file(const PictureKey& key, bool recovered, int height) const;

 private:
  std::filesystem::path folder(const PictureKey& key) const {
    const std::filesystem::path job = folder_ / key.job.text();
    return key.frame == 0 ? job : job / ("frame-" + std::to_string(key.frame));
  }
  std::filesystem::path image_file(const PictureKey& key) const {
    return folder(key) / "image.exr";
  }
  std::filesystem::path recovered_file(const PictureKey& key) const {
    return folder(key) / "recovered.exr";
  }
  std::filesystem::path group_file(const PictureKey& key, size_t group) const {
    return folder(key) / ("light-group-" + std::to_string(group) + ".exr");
  }
  std::filesystem::path noise_file(const PictureKey& key) const {
    return folder(key) / "noise.exr";
  }
  void remember(const PictureKey& key, std::shared_ptr<const Picture> picture);

  std::filesystem::path folder_;
  size_t cache_bytes_;
  std::mutex mutex_;
  struct Recent {
    PictureKey key;
    std::shared_ptr<const Picture> picture;
    std::filesystem::file_time_type written;  // its file: another server may have written it anew
  };
  std::list<Recent> recent_;  // newest use first
};

}  // namespace qray::server
