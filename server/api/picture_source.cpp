#include "server/api/picture_source.h"

#include <spdlog/spdlog.h>

#include "server/http/query.h"
#include "server/jobs/tile_stream.h"

namespace qray::server {
namespace {

Error nothing_yet() { return {ErrorCode::kConflict, "nothing of this job has been rendered", ""}; }

}  // namespace

Result<PictureSource::Which> PictureSource::which(const httplib::Request& req, const JobRecord& job,
                                                  bool best, const char* moment) const {
  using enum Which::Kind;
  const Result<uint32_t> number = query_number<uint32_t>(req, moment, 1, UINT32_MAX, 0);
  if (!number.ok()) return number.error();
  const std::string wanted = req.get_param_value("picture");
  if (req.has_param("picture") && wanted != "sampled" && wanted != "recovered")
    return Error{ErrorCode::kInvalid, "expected sampled or recovered, got '" + wanted + "'",
                 "/picture"};
  if (number.value() > 0) {
    if (wanted == "recovered")
      return Error{ErrorCode::kInvalid, "moments are not recovered", "/picture"};
    return Which{kMoment, number.value()};
  }
  const bool there = stores_.results.has_recovered(job.id);
  if (wanted.empty()) return Which{best && there ? kRecovered : kSampled, 0};
  if (wanted == "sampled") return Which{};
  if (there) return Which{kRecovered, 0};
  if (job.request.get(field::kRecover) == "none")
    return Error{ErrorCode::kNotFound, "this job's picture is not recovered", ""};
  return Error{ErrorCode::kConflict, "this job's picture has not been recovered yet", ""};
}

Result<std::shared_ptr<const Picture>> PictureSource::sampled(const JobRecord& job) const {
  auto picture = stores_.results.load(job.id);
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

Result<Image> PictureSource::image(const JobRecord& job, Which which) const {
  using enum Which::Kind;
  if (which.kind == kRecovered) return stores_.results.load_recovered(job.id);
  if (which.kind == kMoment) {
    Result<Picture> picture = moment(job, which.moment);
    if (!picture.ok()) return picture.error();
    return std::move(picture).value().image;
  }
  if (const auto running = runner_.running(job.id)) {
    if (running->film().version() == 0) return nothing_yet();
    return running->film().develop();
  }
  const auto picture = sampled(job);
  if (!picture.ok()) return picture.error();
  return picture.value()->image;
}

Result<std::shared_ptr<const Image>> PictureSource::noise(const JobRecord& job) const {
  std::shared_ptr<const Image> noise;
  if (const auto running = runner_.running(job.id)) {
    noise = running->film().noise();
  } else if (Result<Image> kept = stores_.results.load_noise(job.id); kept.ok()) {
    noise = std::make_shared<const Image>(std::move(kept).value());
  }
  if (!noise || noise->channels() != kFilmNoiseChannels)
    return Error{ErrorCode::kConflict, "how noisy this picture is, is not known", ""};
  return noise;
}

std::optional<PictureSource::PixelNoise> PictureSource::noise_at(const JobRecord& job, int x,
                                                                 int y) const {
  const auto running = runner_.running(job.id);
  std::shared_ptr<const Image> noise;  // of an ended job the row of the pixel
  if (running) {
    noise = running->film().noise();
  } else if (Result<Image> row = stores_.results.load_noise_row(job.id, y); row.ok()) {
    noise = std::make_shared<const Image>(std::move(row).value());
  }
  if (!noise || noise->channels() != kFilmNoiseChannels) return std::nullopt;
  PixelNoise values;
  for (int c = 0; c < kFilmNoiseChannels; ++c)
    values[static_cast<size_t>(c)] = noise->at(x, running ? y : 0, c);
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
  if (const auto running = runner_.running(job.id)) {
    const Film& film = running->film();
    if (film.version() == 0) return nothing_yet();
    const Film::TileView tile = film.tile_view(static_cast<int>(tile_at(film.width(), x, y)));
    const TileRect rect = film.tile(tile.index);
    pixel.samples = tile.samples;
    if (!tile.mean.empty())
      pixel.radiance = tile.mean[static_cast<size_t>((y - rect.y) * rect.width + x - rect.x)];
  } else {
    const auto picture = sampled(job);
    if (!picture.ok()) return picture.error();
    pixel = of(*picture.value());
  }
  if (which.kind == kRecovered) {
    const Result<Image> row = stores_.results.load_recovered_row(job.id, y);
    if (!row.ok()) return row.error();
    pixel.radiance = row.value().rgb(x, 0);
  }
  return pixel;
}

}  // namespace qray::server
