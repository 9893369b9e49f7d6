#include "core/laboratory/views_file.h"

#include "core/base/file.h"
#include "core/base/snapshot.h"

namespace qray {
namespace {

constexpr uint32_t kViewsFormat = 1;
constexpr uint64_t kMaxViewsBytes = uint64_t{1} << 34;

// Each picture of a view, once.
template <class View, class F>
void for_each_picture(View& view, const F& f) {
  f(view.input.features);
  f(view.input.colour);
  f(view.input.noise);
  f(view.input.own_error);
  f(view.input.shown);
  f(view.target);
}

}  // namespace

Status write_views(const std::filesystem::path& path, const std::vector<TrainingView>& views) {
  AtomicFile file(path);
  SnapshotWriter out([&](std::span<const uint8_t> bytes) { file.write(bytes); });
  out(kViewsFormat, static_cast<uint64_t>(views.size()));
  for (const TrainingView& view : views) {
    out(view.target_relmse);
    for_each_picture(view, [&](const Image& image) {
      out(image.width(), image.height(), image.channels(),
          std::vector<float>(image.data().begin(), image.data().end()));
    });
  }
  return file.commit();
}

Result<std::vector<TrainingView>> read_views(const std::filesystem::path& path) {
  const Result<MappedFile> file = MappedFile::open(path, kMaxViewsBytes);
  if (!file) return file.error();
  SnapshotReader in(file.value().bytes());
  uint32_t format = 0;
  uint64_t count = 0;
  in(format, count);
  std::vector<TrainingView> views;
  while (format == kViewsFormat && in.ok() && views.size() < count) {
    TrainingView& view = views.emplace_back();
    in(view.target_relmse);
    for_each_picture(view, [&](Image& image) {
      int width = 0, height = 0, channels = 0;
      std::vector<float> values;
      in(width, height, channels, values);
      if (width < 0 || height < 0 || channels < 0 ||
          values.size() != static_cast<size_t>(width) * static_cast<size_t>(height) *
                               static_cast<size_t>(channels))
        in.fail();
      if (!in.ok()) return;
      image = Image(width, height, channels);
      std::copy(values.begin(), values.end(), image.data().begin());
    });
  }
  if (format != kViewsFormat || !in.whole())
    return Error{ErrorCode::kCorrupt, "expected training views that this program kept",
                 path.string()};
  return views;
}

}  // namespace qray
