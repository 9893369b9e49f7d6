#include "server/api/picture_source.h"

#include <spdlog/spdlog.h>

#include "core/render/light_mix.h"
#include "core/settings/frames.h"
#include "server/http/query.h"
#include "server/jobs/tile_stream.h"

namespace qray::server {
namespace {

Error nothing_yet() { return {ErrorCode::kConflict, "nothing of this job has been rendered", ""}; }

}  // namespace

Result<int> PictureSource::frame(const httplib::Request& req, const JobRecord& job) {
  const int last = frame_count(job.request).value_or(kMaxFrames) - 1;
  const Result<int> frame = query_number(req, "frame", 0, kMaxFrames - 1, 0);
  if (!frame.ok() || frame.value() <= last) return frame;
  return Error{ErrorCode::kNotFound,
               "this job has no such frame: its last one is " + std::to_string(last), ""};
}

std::optional<int> PictureSource::frame_under_way(const JobRecord& job) const {
  const auto running = runner_.running(job.id);
  if (!running || !running->shown().film) return std::nullopt;
  return running->shown().frame;
}

std::shared_ptr<Film> PictureSource::forming(const JobRecord& job, int frame) const {
  const auto running = runner_.running(job.id);
  return running ? running->film(frame) : nullptr;
}

Result<PictureSource::Which> PictureSource::which(const httplib::Request& req, const JobRecord& job,
                                                  bool best, const char* moment) const {
  using enum Which::Kind;
  const Result<uint32_t> number = query_number<uint32_t>(req, moment, 1, UINT32_MAX, 0);
  if (!number.ok()) return number.error();
  const Result<int> frame = PictureSource::frame(req, job);
  if (!frame.ok()) return frame.error();
  const std::string wanted = req.get_param_value("picture");
  if (req.has_param("picture") && wanted != "sampled" && wanted != "recovered")
    return Error{ErrorCode::kInvalid, "expected sampled or recovered, got '" + wanted + "'",
                 "/picture"};
  if (number.value() > 0) {
    if (wanted == "recovered")
      return Error{ErrorCode::kInvalid, "moments are not recovered", "/picture"};
    return Which{kMoment, number.value()};
  }
  if (req.has_param("mix")) {
    if (wanted == "recovered")
      return Error{ErrorCode::kInvalid, "mixes are of samples, and not recovered", "/picture"};
    const std::vector<std::string> groups = light_groups(job);
    if (groups.empty())
      return Error{ErrorCode::kNotFound, "this job keeps no groups of lights apart", ""};
    Result<std::vector<Rgb>> factors = parse_mix(req.get_param_value("mix"), groups.size());
    if (!factors.ok()) return factors.error();
    return Which{kSampled, 0, frame.value(), std::move(factors).value()};
  }
  const bool there = stores_.results.has_recovered({job.id, frame.value()});
  if (wanted.empty()) return Which{best && there ? kRecovered : kSampled, 0, frame.value()};
  if (wanted == "sampled") return Which{kSampled, 0, frame.value()};
  if (there) return Which{kRecovered, 0, frame.value()};
  if (job.request.get(field::kRecover) == "none")
    return Error{ErrorCode::kNotFound, "this job's picture is not recovered", ""};
  return Error{ErrorCode::kConflict, "this job's picture has not been recovered yet", ""};
}

Result<std::shared_ptr<const Picture>> PictureSource::sampled(const JobRecord& job,
                                                              int frame) const {
  if (stores_.shared && frame == 0 && is_running(job.state)) {
    const std::vector<proto::Moment> moments = stores_.moments.moments(job.id);
    for (auto last = moments.rbegin(); last != moments.rend(); ++last) {
      if (!last->picture) continue;
      Result<Picture> picture = moment(job, last->number);
      if (picture.ok()) return std::make_shared<const Picture>(std::move(picture).value());
    }
  }
  auto picture = stores_.results.load({job.id, frame});
  if (picture.ok()) return picture;
  if (picture.error().code == ErrorCode::kNotFound) {
    // The files of a job that is deleted go after its row.
    const Result<JobRecord> now = stores_.jobs.get(job.id);
    return now.ok() ? nothing_yet() : now.error();
  }
  spdlog::error("job={} {}", job.id.text(), picture.error().text());
  return picture.error();
}

Result<Picture> PictureSource::moment(const JobRecord& job, uint32_t number) const {
  const Result<Bytes> answer = stores_.moments.picture(job.id, number);
  if (!answer.ok()) return answer.error();
  return decode_tiles(answer.value());
}

std::vector<std::string> PictureSource::light_groups(const JobRecord& job) const {
  if (const auto running = runner_.running(job.id)) return running->light_groups();
  return proto::light_groups_of_stats(job.stats_json);
}

Result<Image> PictureSource::light_group(const JobRecord& job, int frame, size_t group) const {
  if (const auto film = forming(job, frame); film && film->version() > 0)
    return film->layer(film->layers().group(static_cast<int>(group)));
  Result<Image> kept = stores_.results.load_light_group({job.id, frame}, group);
  if (!kept.ok() && kept.error().code == ErrorCode::kNotFound) return nothing_yet();
  return kept;
}

Result<Image> PictureSource::image(const JobRecord& job, Which which) const {
  using enum Which::Kind;
  if (!which.mix.empty()) {
    std::vector<Image> groups;
    for (size_t g = 0; g < which.mix.size(); ++g) {
      Result<Image> group = light_group(job, which.frame, g);
      if (!group.ok()) return group.error();
      groups.push_back(std::move(group).value());
    }
    return mixed(groups, which.mix);
  }
  if (which.kind == kRecovered) return stores_.results.load_recovered({job.id, which.frame});
  if (which.kind == kMoment) {
    Result<Picture> picture = moment(job, which.moment);
    if (!picture.ok()) return picture.error();
    return std::move(picture).value().image;
  }
  if (const auto film = forming(job, which.frame); film && film->version() > 0)
    return film->develop();
  const auto picture = sampled(job, which.frame);
  if (!picture.ok()) return picture.error();
  return picture.value()->image;
}

Result<std::shared_ptr<const Image>> PictureSource::noise(const JobRecord& job, int frame) const {
  std::shared_ptr<const Image> noise;
  if (const auto film = forming(job, frame)) {
    noise = film->noise();
  } else if (Result<Image> kept = stores_.results.load_noise({job.id, frame}); kept.ok()) {
    noise = std::make_shared<const Image>(std::move(kept).value());
  }
  if (!noise || noise->channels() != kFilmNoiseChannels)
    return Error{ErrorCode::kConflict, "how noisy this picture is, is not known", ""};
  return noise;
}

std::optional<PictureSource::PixelNoise> PictureSource::noise_at(const JobRecord& job, int frame,
                                                                 int x, int y) const {
  const auto film = forming(job, frame);
  std::shared_ptr<const Image> noise;  // of an ended job the row of the pixel
  if (film) {
    noise = film->noise();
  } else if (Result<Image> row = stores_.results.load_noise_row({job.id, frame}, y); row.ok()) {
    noise = std::make_shared<const Image>(std::move(row).value());
  }
  if (!noise || noise->channels() != kFilmNoiseChannels) return std::nullopt;
  PixelNoise values;
  for (int c = 0; c < kFilmNoiseChannels; ++c)
    values[static_cast<size_t>(c)] = noise->at(x, film ? y : 0, c);
  return values;
}

Result<PictureSource::Pixel> PictureSource::pixel(const JobRecord& job, Which which, int x,
                                                  int y) const {
  using enum Which::Kind;
  const auto of = [&](const Picture& picture) {
    const Image& image = picture.image;
    return Pixel{image.rgb(x, y), picture.tiles[tile_at(image.width(), x, y)].samples};
  };
  if (which.kind == kMoment) {
    const Result<Picture> picture = moment(job, which.moment);
    if (!picture.ok()) return picture.error();
    return of(picture.value());
  }
  Pixel pixel;
  if (const auto film = forming(job, which.frame); film && film->version() > 0) {
    const Film::TileView tile = film->tile_view(static_cast<int>(tile_at(film->width(), x, y)));
    const TileRect rect = film->tile(tile.index);
    pixel.samples = tile.samples;
    if (!tile.mean.empty())
      pixel.radiance = tile.mean[static_cast<size_t>((y - rect.y) * rect.width + x - rect.x)];
  } else {
    const auto picture = sampled(job, which.frame);
    if (!picture.ok()) return picture.error();
    pixel = of(*picture.value());
  }
  if (which.kind == kRecovered) {
    const Result<Image> row = stores_.results.load_recovered_row({job.id, which.frame}, y);
    if (!row.ok()) return row.error();
    pixel.radiance = row.value().rgb(x, 0);
  }
  return pixel;
}

}  // namespace qray::server
