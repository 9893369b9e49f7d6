#include "server/store/checkpoint_store.h"

#include <algorithm>

namespace qray::server {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kMagic = 0x31504b4359415251;  // "QRAYCKP1"
constexpr uint32_t kVersion = 1;                 // of what exchange() functions list
constexpr uint64_t kMaxBytes = uint64_t{1} << 36;
constexpr size_t kCrcBytes = 4;

}  // namespace

Status CheckpointStore::save(JobId id, const CheckpointHeader& header,
                             const std::function<void(SnapshotWriter&)>& write_state) {
  std::error_code ec;
  fs::create_directories(folder_, ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), folder_.string()};
  AtomicFile out(file(id));
  uint32_t crc = 0;
  SnapshotWriter writer([&](std::span<const uint8_t> bytes) {
    crc = crc32c(bytes, crc);
    out.write(bytes);
  });
  writer(kMagic, kVersion, std::string(QRAY_VERSION), header);
  write_state(writer);
  ByteWriter end;
  end.u32(crc);
  out.write(end.data());
  return out.commit();
}

Result<Checkpoint> CheckpointStore::load(JobId id) const {
  Result<MappedFile> file = MappedFile::open(this->file(id), kMaxBytes);
  if (!file.ok()) return file.error();
  Checkpoint checkpoint{{}, std::move(file).value()};
  const auto wrong = [](ErrorCode code, const char* what) {
    return Error{code, what, "checkpoint"};
  };
  const std::span<const uint8_t> all = checkpoint.file.bytes();
  if (all.size() < kCrcBytes) return wrong(ErrorCode::kCorrupt, "is cut off");
  const auto content = all.first(all.size() - kCrcBytes);
  ByteReader end(all.last(kCrcBytes));
  if (crc32c(content) != end.u32()) return wrong(ErrorCode::kCorrupt, "has a wrong checksum");
  SnapshotReader in(content);
  uint64_t magic = 0;
  uint32_t version = 0;
  std::string program;
  in(magic, version, program);
  if (!in.ok() || magic != kMagic) return wrong(ErrorCode::kCorrupt, "is none");
  if (version != kVersion || program != QRAY_VERSION)
    return wrong(ErrorCode::kUnsupported, "was written by another version of the program");
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
  std::error_code ec;
  fs::remove(file(id), ec);
}

void CheckpointStore::finished(JobId id) {
  std::lock_guard lock(mutex_);
  std::erase(finished_, id);
  finished_.push_back(id);
  std::error_code ec;
  uint64_t bytes = 0;
  size_t kept = 0;
  for (; kept < finished_.size(); ++kept) {
    const uint64_t size = fs::file_size(file(finished_[finished_.size() - 1 - kept]), ec);
    if (!ec) bytes += size;
    if (bytes > max_finished_bytes_) break;
  }
  while (finished_.size() > kept) {
    fs::remove(file(finished_.front()), ec);
    finished_.erase(finished_.begin());
  }
}

void CheckpointStore::tidy(const std::function<Keep(JobId)>& keep) {
  std::vector<fs::path> gone;
  std::vector<JobId> done;
  std::error_code ec;
  for (fs::directory_iterator it(folder_, ec), end; !ec && it != end; it.increment(ec)) {
    const std::optional<JobId> id = JobId::parse(it->path().filename().string());
    const Keep what = id ? keep(*id) : Keep::kNo;  // no job's: cut off while it was written
    if (what == Keep::kNo) gone.push_back(it->path());
    if (what == Keep::kFinished) done.push_back(*id);
  }
  for (const fs::path& path : gone) fs::remove(path, ec);
  std::sort(done.begin(), done.end());
  for (JobId id : done) finished(id);
}

}  // namespace qray::server
