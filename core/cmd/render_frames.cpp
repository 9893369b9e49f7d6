#include "core/cmd/render_frames.h"

#include <fstream>
#include <numeric>

#include "core/base/file.h"
#include "core/cmd/files.h"
#include "core/image/animation.h"
#include "core/settings/frames.h"

namespace qray::cmd {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kMaxStateBytes = uint64_t{1} << 36;

fs::path system_folder() {
  std::error_code ec;
  return fs::temp_directory_path(ec);
}

Error io_error(const fs::path& path) {
  return {ErrorCode::kIo, "cannot keep what a frame is so far", path.string()};
}

}  // namespace

FrameFiles::FrameFiles(int count, ProgressLine& line, WritePicture write)
    : folder_(system_folder(), "qray-frames-"),
      progress_(line, static_cast<size_t>(count)),
      write_(std::move(write)),
      stats_(static_cast<size_t>(count)) {}

fs::path FrameFiles::file(int frame, int turn) const {
  return folder_ / (std::to_string(frame) + (turn % 2 == 0 ? "-even" : "-odd"));
}

RenderObserver& FrameFiles::begin_turn(int frame, std::shared_ptr<Film>) {
  progress_.begin(frame);
  return progress_;
}

Status FrameFiles::end_turn(int frame, const FrameProgress&, const Film& film,
                            const JobResult& result) {
  stats_[static_cast<size_t>(frame)] = result.stats;
  progress_.done();
  return result.recovered
             ? write_(frame, *result.recovered, result.recovered_metadata, result.passes)
             : write_(frame, film.develop(), result.metadata, result.passes);
}

Status FrameFiles::save(int frame, int turn, const WriteState& write) {
  const fs::path path = file(frame, turn);
  if (!folder_.ok()) return io_error(path);
  std::ofstream out(path, std::ios::binary);
  SnapshotWriter writer([&out](std::span<const uint8_t> bytes) {
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  });
  write(writer);
  out.close();
  return out.good() ? Status() : Status(io_error(path));
}

Status FrameFiles::load(int frame, int turn, const std::function<bool(SnapshotReader&)>& read) {
  const Result<MappedFile> state = MappedFile::open(file(frame, turn), kMaxStateBytes);
  if (!state.ok()) return state.error();
  SnapshotReader in(state.value().bytes());
  return read(in) ? Status() : Status(io_error(file(frame, turn)));
}

void FrameFiles::Progress::on_tile(const RenderProgress& progress) {
  fractions_[frame_] = progress.fraction;
  const double sum = std::accumulate(fractions_.begin(), fractions_.end(), 0.0);
  line_.show("frame " + std::to_string(frame_), sum / static_cast<double>(fractions_.size()),
             samples_words(progress.samples_per_pixel), clock_.seconds() - start_);
}

bool FramesOut::plays() const { return is_animation_name(path); }

fs::path FramesOut::picture(int frame) const { return path / frame_file_name(frame, format); }

Status prepare_output(const FramesOut& out) {
  if (out.plays()) {
    if (out.path.extension() == ".mp4" && !has_ffmpeg())
      return Error{ErrorCode::kUnsupported,
                   "needs the program ffmpeg, which is not on this machine", out.path.string()};
    return check_writable(out.path);
  }
  if (out.path.has_extension())
    return Error{ErrorCode::kInvalid,
                 "expected a folder for the frames, or a name ending in .gif or .mp4",
                 out.path.string()};
  std::error_code ec;
  fs::create_directories(out.path, ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), out.path.string()};
  return check_writable(out.picture(0));
}

}  // namespace qray::cmd
