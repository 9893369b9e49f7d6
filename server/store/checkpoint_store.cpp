#include "server/store/checkpoint_store.h"

#include <algorithm>

#include "core/base/build_identity.h"
#include "core/base/byte_io.h"
#include "server/store/folder_watch.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

// A file: the magic, format and revision (u32), the build (a string of byte_io.h), the header and
// the state as snapshot.h has them, CRC-32C of all that (u32). Format 1 was memory as it lay.
constexpr uint64_t kCheckpointMagic = 0x31504b4359415251;  // "QRAYCKP1"
constexpr uint64_t kMaxBytes = uint64_t{1} << 36;
constexpr size_t kCrcBytes = 4, kMaxBuildBytes = 256;

}  // namespace

StateOrigin this_build() { return {kStateFormat, kStateRevision, build_identity()}; }

fs::path CheckpointStore::frame_file(JobId id, int frame, int turn) const {
  return frames_folder(id) / (std::to_string(frame) + (turn % 2 == 0 ? "-even" : "-odd"));
}

Status CheckpointStore::save(JobId id, const CheckpointHeader& header,
                             const std::function<void(SnapshotWriter&)>& write_state,
                             const Stopped& stopped) {
  return write(file(id), header, write_state, stopped);
}

Status CheckpointStore::save_frame(JobId id, int frame, int turn,
                                   const std::function<void(SnapshotWriter&)>& write_state,
                                   const Stopped& stopped) {
  return write(frame_file(id, frame, turn), {}, write_state, stopped);
}

Result<Checkpoint> CheckpointStore::load(JobId id) const { return read(file(id)); }

Result<Checkpoint> CheckpointStore::load_frame(JobId id, int frame, int turn) const {
  return read(frame_file(id, frame, turn));
}

Status CheckpointStore::write(const fs::path& path, const CheckpointHeader& header,
                              const std::function<void(SnapshotWriter&)>& write_state,
                              const Stopped& stopped) const {
  std::error_code ec;
  fs::create_directories(path.parent_path(), ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), path.parent_path().string()};
  AtomicFile out(path);
  uint32_t crc = 0;
  const auto write = [&](std::span<const uint8_t> bytes) {
    if (stopped && stopped()) return;
    crc = crc32c(bytes, crc);
    out.write(bytes);
  };
  ByteWriter begin;
  begin.u64(kCheckpointMagic);
  begin.u32(here_.format);
  begin.u32(here_.revision);
  begin.string(here_.build);
  write(begin.data());
  SnapshotWriter writer(write);
  writer(header);
  write_state(writer);
  ByteWriter end;
  end.u32(crc);
  out.write(end.data());
  if (stopped && stopped()) return Error{ErrorCode::kCanceled, "stopped", path.string()};
  return out.commit();
}

Result<Checkpoint> CheckpointStore::read(const fs::path& path) const {
  Result<MappedFile> file = MappedFile::open(path, kMaxBytes);
  if (!file.ok()) return file.error();
  Checkpoint checkpoint{{}, false, std::move(file).value()};
  const auto wrong = [](ErrorCode code, std::string what) {
    return Error{code, std::move(what), "checkpoint"};
  };
  const std::span<const uint8_t> all = checkpoint.file.bytes();
  if (all.size() < kCrcBytes) return wrong(ErrorCode::kCorrupt, "is cut off");
  const auto content = all.first(all.size() - kCrcBytes);
  ByteReader end(all.last(kCrcBytes));
  if (crc32c(content) != end.u32()) return wrong(ErrorCode::kCorrupt, "has a wrong checksum");
  ByteReader begin(content);
  if (begin.u64() != kCheckpointMagic) return wrong(ErrorCode::kCorrupt, "is none");
  if (const uint32_t format = begin.u32(); format != here_.format)
    return wrong(ErrorCode::kUnsupported, "is of format " + std::to_string(format) +
                                              ", this build of qray reads format " +
                                              std::to_string(here_.format));
  if (const uint32_t revision = begin.u32(); revision != here_.revision)
    return wrong(ErrorCode::kUnsupported,
                 "is what another build of qray rendered, whose samples do not go with this one's "
                 "(revision " +
                     std::to_string(revision) + ", here " + std::to_string(here_.revision) + ")");
  checkpoint.other_build = begin.string(kMaxBuildBytes) != here_.build;
  if (!begin.ok()) return wrong(ErrorCode::kCorrupt, "has a wrong header");
  SnapshotReader in(content.subspan(begin.offset()));
  in(checkpoint.header);
  if (!in.ok()) return wrong(ErrorCode::kCorrupt, "has a wrong header");
  checkpoint.state_begin = content.size() - in.remaining();
  checkpoint.state_end = content.size();
  return checkpoint;
}

bool CheckpointStore::has(JobId id) const {
  std::error_code ec;
  return fs::exists(file(id), ec);
}

void CheckpointStore::remove(JobId id) {
  std::lock_guard lock(mutex_);
  std::erase(finished_, id);
  remove_files(id);
}

void CheckpointStore::remove_files(JobId id) const {
  std::error_code ec;
  fs::remove(file(id), ec);
  fs::remove_all(frames_folder(id), ec);
}

uint64_t CheckpointStore::bytes_of(JobId id) const {
  std::error_code ec;
  const auto size = [](const fs::path& path) {
    std::error_code failed;
    const uint64_t bytes = fs::file_size(path, failed);
    return failed ? 0 : bytes;
  };
  uint64_t bytes = size(file(id));
  for (fs::directory_iterator it(frames_folder(id), ec), end; !ec && it != end; it.increment(ec))
    bytes += size(it->path());
  return bytes;
}

void CheckpointStore::finished(JobId id) {
  std::lock_guard lock(mutex_);
  std::erase(finished_, id);
  finished_.push_back(id);
  uint64_t bytes = 0;
  size_t kept = 0;
  for (; kept < finished_.size(); ++kept) {
    bytes += bytes_of(finished_[finished_.size() - 1 - kept]);
    if (bytes > max_finished_bytes_) break;
  }
  while (finished_.size() > kept) {
    remove_files(finished_.front());
    finished_.erase(finished_.begin());
  }
}

void CheckpointStore::tidy(const std::function<Keep(JobId)>& keep, std::chrono::seconds left) {
  std::vector<fs::path> gone;
  std::vector<JobId> done;
  std::error_code ec;
  for (fs::directory_iterator it(folder_, ec), end; !ec && it != end; it.increment(ec)) {
    const fs::path name = it->path().filename();
    const bool frames = name.extension() == kFrames;
    const std::optional<JobId> id = JobId::parse((frames ? name.stem() : name).string());
    const Keep what = id ? keep(*id) : Keep::kNo;  // no job's: cut off while it was written
    if (what == Keep::kNo && is_older(it->path(), left)) gone.push_back(it->path());
    if (what == Keep::kFinished && !frames) done.push_back(*id);
  }
  for (const fs::path& path : gone) fs::remove_all(path, ec);
  std::sort(done.begin(), done.end());
  for (JobId id : done) finished(id);
}

}  // namespace qray::server
