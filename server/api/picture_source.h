// Which of a job's pictures a request asks for, and that picture: while it forms, ended, recovered,
// or of a moment that is kept of it. Any thread.
#pragma once

#include <httplib.h>

#include <array>

#include "server/jobs/job_runner.h"

namespace qray::server {

inline const proto::Problem kTooManyPictures{503, "Busy", "too many pictures at once", {}};

class PictureSource {
 public:
  PictureSource(const JobRunner& runner, Stores stores) : runner_(runner), stores_(stores) {}

  struct Which {
    enum class Kind { kSampled, kRecovered, kMoment } kind = Kind::kSampled;
    uint32_t moment = 0;
    int frame = 0;
    std::vector<Rgb> mix = {};  // factors of the groups of lights; empty: the picture as it is
  };
  // Which of the job's frames the parameter `frame` names; the first without it. kInvalid.
  static Result<int> frame(const httplib::Request& req, const JobRecord& job);
  // The one that a running job of frames works on.
  std::optional<int> frame_under_way(const JobRecord& job) const;
  // The groups of lights whose pictures the job keeps apart; none, where it keeps none.
  std::vector<std::string> light_groups(const JobRecord& job) const;
  // One of their pictures. kConflict: before the first tile, or the job did not come to its end.
  Result<Image> light_group(const JobRecord& job, int frame, size_t group) const;
  // By the parameters `frame`, `mix`, `picture` ("sampled" or "recovered"; absent: the recovered
  // one if it is there and `best` is wanted, else the sampled one) and `moment`, or of another
  // name. kNotFound, kConflict: there is none, or not yet; kInvalid names the parameter.
  Result<Which> which(const httplib::Request& req, const JobRecord& job, bool best,
                      const char* moment = "moment") const;
  // kConflict: before the first tile; kNotFound: the moment is not kept.
  Result<Image> image(const JobRecord& job, Which which) const;
  // Film::noise(), the newest. kConflict: not known.
  Result<std::shared_ptr<const Image>> noise(const JobRecord& job, int frame) const;
  // As it was sampled, of a frame that does not form in this process. Of a job that runs in
  // another: as the last moment that is kept of it has it. kConflict: nothing yet.
  Result<std::shared_ptr<const Picture>> sampled(const JobRecord& job, int frame) const;
  // What it says of one pixel, by FilmNoise; none: not known.
  using PixelNoise = std::array<float, kFilmNoiseChannels>;
  std::optional<PixelNoise> noise_at(const JobRecord& job, int frame, int x, int y) const;
  // A pixel's colour; and how many samples a pixel of its tile has had, by the passes.
  struct Pixel {
    Rgb radiance;
    uint32_t samples = 0;
  };
  Result<Pixel> pixel(const JobRecord& job, Which which, int x, int y) const;

 private:
  Result<Picture> moment(const JobRecord& job, uint32_t number) const;

  // Null: the frame is not under way.
  std::shared_ptr<Film> forming(const JobRecord& job, int frame) const;

  const JobRunner& runner_;
  Stores stores_;
};

}  // namespace qray::server
