#include "server/store/moment_store.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

namespace qray::server {
namespace fs = std::filesystem;
namespace {

// A file: the magic and the version (u32), then records: kind and number (u32), size of the payload
// (u64), CRC-32C of these sixteen bytes and the payload (u32), payload. Raise the version when
// encode() changes, or what encode_tiles() makes.
constexpr uint64_t kMomentMagic = 0x53544d4f4d594152;  // "RAYMOMTS"
constexpr uint32_t kVersion = 1;
constexpr size_t kBeginBytes = 12, kHeadBytes = 20;
constexpr uint64_t kMaxRecordBytes = uint64_t{1} << 30;
constexpr size_t kMaxGateBytes = 1000;

Bytes begin_of_file() {
  ByteWriter out;
  out.u64(kMomentMagic);
  out.u32(kVersion);
  return out.take();
}

Bytes encode(const proto::Moment& moment) {
  ByteWriter out;
  out.u32(moment.number);
  out.u64(moment.samples);
  out.f64(moment.seconds);
  out.f64(moment.noise);
  out.f64(moment.efficiency_gain);
  for (bool flag : {moment.learning, moment.guided, moment.picture, moment.table}) out.u8(flag);
  out.u64(moment.states);
  out.u64(moment.direction_nodes);
  out.u64(moment.table_bytes);
  out.string(moment.gate);
  return out.take();
}

std::optional<proto::Moment> decode(std::span<const uint8_t> bytes) {
  ByteReader in(bytes);
  proto::Moment moment;
  moment.number = in.u32();
  moment.samples = in.u64();
  moment.seconds = in.f64();
  moment.noise = in.f64();
  moment.efficiency_gain = in.f64();
  for (bool* flag : {&moment.learning, &moment.guided, &moment.picture, &moment.table})
    *flag = in.u8() != 0;
  moment.states = in.u64();
  moment.direction_nodes = in.u64();
  moment.table_bytes = in.u64();
  moment.gate = in.string(kMaxGateBytes);
  if (!in.ok() || in.remaining() > 0) return {};
  return moment;
}

Bytes head_of(uint32_t kind, uint32_t number, uint64_t size) {
  ByteWriter out;
  out.u32(kind);
  out.u32(number);
  out.u64(size);
  return out.take();
}

void append_record(ByteWriter& out, uint32_t kind, uint32_t number, const Bytes& payload) {
  if (payload.empty()) return;
  const Bytes head = head_of(kind, number, payload.size());
  out.bytes(head);
  out.u32(crc32c(payload, crc32c(head)));
  out.bytes(payload);
}

Error no_moment() { return {ErrorCode::kNotFound, "this moment is not kept", ""}; }

Bytes read_some(std::istream& in, size_t size) {
  Bytes bytes(size);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<size_t>(in.gcount()));
  return bytes;
}

std::vector<std::pair<JobId, fs::path>> files_in(const fs::path& folder) {
  std::vector<std::pair<JobId, fs::path>> files;
  std::error_code ec;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec))
    if (const std::optional<JobId> id = JobId::parse(it->path().filename().string()))
      files.emplace_back(*id, it->path());
  return files;
}

}  // namespace

MomentStore::MomentStore(const fs::path& data, uint64_t max_bytes)
    : folder_(data / "moments"), old_folder_(data / "history"), max_bytes_(max_bytes) {
  for (const auto& [id, file] : files_in(folder_)) {
    std::error_code ec;
    bytes_[id] = fs::file_size(file, ec);
  }
}

std::vector<JobId> MomentStore::remove_others() {
  std::vector<JobId> jobs;
  std::error_code ec;
  for (const auto& [id, path] : files_in(folder_)) {
    const Result<Index> index = this->index(id);
    if (!index.ok() || index.value().end > 0) continue;
    remove(id);
    jobs.push_back(id);
  }
  const auto old = files_in(old_folder_);
  for (const auto& [id, path] : old) jobs.push_back(id);
  if (fs::remove_all(old_folder_, ec) > 0 && !ec)
    spdlog::info("removed {}: moments of {} jobs, of a format that is not read any more",
                 old_folder_.string(), old.size());
  return jobs;
}

Result<MomentStore::Index> MomentStore::index(JobId id) const {
  Index index;
  std::ifstream& in = index.in;
  in.open(file(id), std::ios::binary | std::ios::ate);
  if (!in) return no_moment();
  const uint64_t size = static_cast<uint64_t>(in.tellg());
  in.seekg(0);
  if (read_some(in, kBeginBytes) != begin_of_file()) return index;
  index.end = kBeginBytes;
  while (size - index.end >= kHeadBytes) {
    in.seekg(static_cast<std::streamoff>(index.end));
    const Bytes head = read_some(in, kHeadBytes);
    if (head.size() < kHeadBytes) break;
    ByteReader reader(head);
    Record record;
    record.kind = static_cast<Kind>(reader.u32());
    record.number = reader.u32();
    record.bytes = reader.u64();
    record.crc = reader.u32();
    record.begin = index.end + kHeadBytes;
    if (record.bytes > std::min(kMaxRecordBytes, size - record.begin)) break;  // cut off
    index.records.push_back(record);
    index.end = record.begin + record.bytes;
  }
  return index;
}

Result<Bytes> MomentStore::payload(Index& index, const Record& record) {
  index.in.clear();  // the end may have been reached
  index.in.seekg(static_cast<std::streamoff>(record.begin));
  Bytes bytes = read_some(index.in, record.bytes);
  const Bytes head = head_of(static_cast<uint32_t>(record.kind), record.number, record.bytes);
  if (bytes.size() != record.bytes || crc32c(bytes, crc32c(head)) != record.crc)
    return Error{ErrorCode::kNotFound, "this moment cannot be read any more", ""};
  return bytes;
}

Result<Bytes> MomentStore::find(JobId id, Kind kind, uint32_t number) const {
  Result<Index> index = this->index(id);
  if (!index.ok()) return index.error();
  const auto& records = index.value().records;
  const auto found = std::find_if(records.rbegin(), records.rend(), [&](const Record& r) {
    return r.kind == kind && r.number == number;
  });
  if (found == records.rend()) return no_moment();
  return payload(index.value(), *found);
}

Result<Bytes> MomentStore::picture(JobId id, uint32_t moment) const {
  return find(id, Kind::kPicture, moment);
}

Result<Bytes> MomentStore::table(JobId id, uint32_t moment) const {
  return find(id, Kind::kTable, moment);
}

std::vector<proto::Moment> MomentStore::moments(JobId id) const {
  Result<Index> index = this->index(id);
  if (!index.ok()) return {};
  std::map<uint32_t, proto::Moment> moments;
  for (const Record& record : index.value().records) {
    if (record.kind != Kind::kMoment) continue;
    const Result<Bytes> bytes = payload(index.value(), record);
    if (!bytes.ok()) continue;
    std::optional<proto::Moment> moment = decode(bytes.value());
    if (!moment) continue;
    // What came after it was of a run that was cut off.
    moments.erase(moments.lower_bound(moment->number), moments.end());
    moments[moment->number] = std::move(*moment);
  }
  std::vector<proto::Moment> sorted;
  for (auto& [number, moment] : moments) sorted.push_back(std::move(moment));
  return sorted;
}

// What comes next must not stand behind a record that a crash or a full disk cut off.
bool MomentStore::cut_to_whole_records(JobId id) const {
  std::error_code ec;
  const Result<Index> index = this->index(id);
  if (!index.ok()) return true;  // there is no file
  if (index.value().end == 0) return fs::remove(file(id), ec);
  fs::resize_file(file(id), index.value().end, ec);
  return !ec;
}

Status MomentStore::add(JobId id, const proto::Moment& moment, const Bytes& picture,
                        const Bytes& table) {
  const Error failed{ErrorCode::kIo, "cannot write the job's moments", file(id).string()};
  std::error_code ec;
  fs::create_directories(folder_, ec);
  if (!is_whole(id) && !cut_to_whole_records(id)) return failed;
  ByteWriter out;
  if (!fs::exists(file(id), ec)) out.bytes(begin_of_file());
  append_record(out, static_cast<uint32_t>(Kind::kPicture), moment.number, picture);
  append_record(out, static_cast<uint32_t>(Kind::kTable), moment.number, table);
  append_record(out, static_cast<uint32_t>(Kind::kMoment), moment.number, encode(moment));
  make_room(id, out.data().size());
  std::ofstream file(this->file(id), std::ios::binary | std::ios::app);
  file.write(reinterpret_cast<const char*>(out.data().data()),
             static_cast<std::streamsize>(out.data().size()));
  file.close();
  std::lock_guard lock(mutex_);
  if (file) {
    whole_.insert(id);
    return {};
  }
  whole_.erase(id);
  return failed;
}

bool MomentStore::is_whole(JobId id) const {
  std::lock_guard lock(mutex_);
  return whole_.contains(id);
}

void MomentStore::make_room(JobId for_job, uint64_t bytes) {
  std::lock_guard lock(mutex_);
  bytes_[for_job] += bytes;
  uint64_t all = 0;
  for (const auto& [id, size] : bytes_) all += size;
  std::error_code ec;
  for (auto it = bytes_.begin(); it != bytes_.end() && all > max_bytes_;) {
    if (it->first == for_job) {
      ++it;
      continue;
    }
    fs::remove(file(it->first), ec);
    all -= it->second;
    it = bytes_.erase(it);
  }
}

void MomentStore::remove(JobId id) {
  std::lock_guard lock(mutex_);
  bytes_.erase(id);
  whole_.erase(id);
  std::error_code ec;
  fs::remove(file(id), ec);
}

}  // namespace qray::server
