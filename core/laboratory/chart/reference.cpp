#include "core/laboratory/chart/reference.h"

#include <charconv>
#include <cmath>

#include "core/base/byte_io.h"
#include "core/base/check.h"
#include "core/base/sha256.h"
#include "core/image/image_io.h"
#include "core/image/metrics.h"
#include "core/job/run_job.h"
#include "core/laboratory/chart/names.h"

namespace qray {
namespace {

constexpr uint64_t kFirstHalfSeed = uint64_t{2} << 32, kSecondHalfSeed = uint64_t{3} << 32;

std::string number_text(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

ImageMetadata metadata_of(const ChartReference& r, double asked_seconds) {
  return {{"scene_hash", r.scene_hash},
          {"reference_method", r.method},
          {"reference_samples", std::to_string(r.samples_per_pixel)},
          {"reference_seconds", number_text(r.seconds)},
          {"reference_asked_seconds", number_text(asked_seconds)},
          {"reference_floor_relmse", number_text(r.floor_relmse)},
          {"reference_floor_trimmed", number_text(r.floor_trimmed)},
          {"reference_mean_standard_error", number_text(r.mean_standard_error)}};
}

// Reads attributes of a file; remembers whether all were there.
class Attributes {
 public:
  explicit Attributes(ImageMetadata metadata) : metadata_(std::move(metadata)) {}
  std::string text(const char* name) {
    const auto it = metadata_.find(name);
    ok_ = ok_ && it != metadata_.end();
    return ok_ ? it->second : "";
  }
  double number(const char* name) {
    const std::string value = text(name);
    double out = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), out);
    ok_ = ok_ && error == std::errc() && end == value.data() + value.size();
    return out;
  }
  bool ok() const { return ok_; }

 private:
  ImageMetadata metadata_;
  bool ok_ = true;
};

Image mean_of(const Image& a, const Image& b) {
  Image out = a;
  for (size_t i = 0; i < out.data().size(); ++i) out.data()[i] = (a.data()[i] + b.data()[i]) / 2;
  return out;
}

struct Half {
  Image picture;
  RenderStats stats;
};
Result<Half> render_half(const PreparedScene& scene, const RenderSettings& settings, TaskPool& pool,
                         RenderObserver& observer, std::stop_token stop, const Clock& clock) {
  Film film(settings.width, settings.height);
  Result<JobResult> job =
      run_job(scene, settings, std::nullopt, film, pool, observer, std::move(stop), clock);
  if (!job) return job.error();
  return Half{film.develop(), std::move(job).value().stats};
}

}  // namespace

Result<HalvesError> halves_error(const Image& a, const Image& b) {
  QRAY_CHECK(a.width() == b.width() && a.height() == b.height());
  const Image middle = mean_of(a, b);
  // a differs from the mean by (a-b)/2, whose square's mean is the variance of the mean.
  const Result<ImageDifference> difference = image_difference(a, middle);
  if (!difference) return difference.error();
  HalvesError error{difference.value().relmse, difference.value().relmse_trimmed, 0};
  double light = 0, squares = 0;
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x) {
      const double la = luminance(a.rgb(x, y)), lb = luminance(b.rgb(x, y));
      light += (la + lb) / 2;
      squares += (la - lb) * (la - lb) / 4;
    }
  if (light > 0) error.mean_standard_error = std::sqrt(squares) / light;
  return error;
}

std::filesystem::path reference_path(const std::filesystem::path& cache, std::string_view name,
                                     const PreparedScene& scene, const RenderSettings& s) {
  ByteWriter key;
  const Camera& c = scene.scene.camera;
  for (float v : {c.position.x, c.position.y, c.position.z, c.target.x, c.target.y, c.target.z,
                  c.up.x, c.up.y, c.up.z, c.vertical_fov_deg, c.aperture_radius, c.focus_distance})
    key.f32(v);
  if (c.projection != Projection::kPerspective) {  // the others keep their names
    key.u32(static_cast<uint32_t>(c.projection));
    key.f32(c.height);
  }
  for (int v : {s.width, s.height, s.max_depth, static_cast<int>(s.nee)})
    key.u32(static_cast<uint32_t>(v));
  key.string(scene.hash.whole().hex() + s.method);
  return cache / (chart_file_name(name) + "-" + sha256(key.data()).hex().substr(0, 16) + ".exr");
}

Result<std::optional<Reference>> find_reference(const std::filesystem::path& path, double seconds) {
  if (std::error_code ignored; !std::filesystem::exists(path, ignored))
    return std::optional<Reference>();
  Result<ImageMetadata> metadata = read_image_metadata(path);
  if (!metadata) return metadata.error();
  Attributes attributes(std::move(metadata).value());
  Reference reference;
  ChartReference& r = reference.about;
  r.scene_hash = attributes.text("scene_hash");
  r.method = attributes.text("reference_method");
  r.samples_per_pixel = static_cast<uint64_t>(attributes.number("reference_samples"));
  r.seconds = attributes.number("reference_seconds");
  r.floor_relmse = attributes.number("reference_floor_relmse");
  r.floor_trimmed = attributes.number("reference_floor_trimmed");
  r.mean_standard_error = attributes.number("reference_mean_standard_error");
  const double asked_seconds = attributes.number("reference_asked_seconds");
  r.path = path.string();
  if (!attributes.ok())
    return Error{ErrorCode::kCorrupt, "expected a reference as qray chart writes it",
                 path.string()};
  if (asked_seconds < seconds) return std::optional<Reference>();
  Result<Image> picture = read_image(path);
  if (!picture) return picture.error();
  reference.picture = std::move(picture).value();
  r.width = reference.picture.width();
  r.height = reference.picture.height();
  return std::optional(std::move(reference));
}

Result<Reference> make_reference(const std::filesystem::path& path, const PreparedScene& scene,
                                 RenderSettings settings, TaskPool& pool, RenderObserver& observer,
                                 std::stop_token stop, const Clock& clock) {
  const double asked_seconds = settings.seconds;
  settings.seconds = asked_seconds / 2;
  settings.samples = 0;
  settings.seed = kFirstHalfSeed;
  const Result<Half> first = render_half(scene, settings, pool, observer, stop, clock);
  if (!first) return first.error();
  settings.passes = first.value().stats.passes;
  settings.seed = kSecondHalfSeed;
  const Result<Half> second = render_half(scene, settings, pool, observer, stop, clock);
  if (!second) return second.error();

  const Image &a = first.value().picture, &b = second.value().picture;
  const Result<HalvesError> error = halves_error(a, b);
  if (!error) return error.error();
  Reference reference;
  reference.picture = mean_of(a, b);
  ChartReference& r = reference.about;
  r.scene_hash = scene.hash.whole().hex();
  r.width = settings.width;
  r.height = settings.height;
  r.method = settings.method;
  r.samples_per_pixel = 2 * first.value().stats.samples_per_pixel;
  r.seconds = first.value().stats.seconds + second.value().stats.seconds;
  r.path = path.string();
  r.floor_relmse = error.value().relmse;
  r.floor_trimmed = error.value().relmse_trimmed;
  r.mean_standard_error = error.value().mean_standard_error;
  std::error_code failed;
  std::filesystem::create_directories(path.parent_path(), failed);
  if (failed) return Error{ErrorCode::kIo, failed.message(), path.parent_path().string()};
  if (Status s = write_image(path, reference.picture, metadata_of(r, asked_seconds)); !s)
    return s.error();
  return reference;
}

}  // namespace qray
