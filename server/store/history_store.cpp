#include "server/store/history_store.h"

#include <algorithm>
#include <utility>

#include "core/base/snapshot.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

// A file: the magic, then records of kind, number and CRC-32C (u32), size (u64) and that many
// bytes.
constexpr uint64_t kMagic = 0x3154534948594152;  // "RAYHIST1"
constexpr size_t kMagicBytes = 8, kHeadBytes = 20;
constexpr uint64_t kMaxRecordBytes = uint64_t{1} << 30;

Bytes encode(const proto::Moment& moment) {
  Bytes bytes;
  SnapshotWriter out([&](std::span<const uint8_t> more) {
    std::copy(more.begin(), more.end(), std::back_inserter(bytes));
  });
  out(moment);
  return bytes;
}

void append_record(ByteWriter& out, uint32_t kind, uint32_t number, const Bytes& payload) {
  if (payload.empty()) return;
  out.u32(kind);
  out.u32(number);
  out.u32(crc32c(payload));
  out.u64(payload.size());
  out.bytes(payload);
}

Error no_moment() { return {ErrorCode::kNotFound, "this moment is not kept", ""}; }

Bytes read_some(std::istream& in, size_t size) {
  Bytes bytes(size);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<size_t>(in.gcount()));
  return bytes;
}

}  // namespace

HistoryStore::HistoryStore(const fs::path& data, uint64_t max_bytes)
    : folder_(data / "history"), max_bytes_(max_bytes) {
  std::error_code ec;
  for (fs::directory_iterator it(folder_, ec), end; !ec && it != end; it.increment(ec))
    if (const std::optional<JobId> id = JobId::parse(it->path().filename().string()))
      bytes_[*id] = it->file_size(ec);
}

Result<HistoryStore::Index> HistoryStore::index(JobId id) const {
  Index index;
  std::ifstream& in = index.in;
  in.open(file(id), std::ios::binary | std::ios::ate);
  if (!in) return no_moment();
  const uint64_t size = static_cast<uint64_t>(in.tellg());
  in.seekg(0);
  const Bytes magic = read_some(in, kMagicBytes);
  if (magic.size() < kMagicBytes || ByteReader(magic).u64() != kMagic) return index;
  index.end = kMagicBytes;
  while (size - index.end >= kHeadBytes) {
    in.seekg(static_cast<std::streamoff>(index.end));
    const Bytes head = read_some(in, kHeadBytes);
    if (head.size() < kHeadBytes) break;
    ByteReader reader(head);
    Record record;
    record.kind = static_cast<Kind>(reader.u32());
    record.number = reader.u32();
    record.crc = reader.u32();
    record.bytes = reader.u64();
    record.begin = index.end + kHeadBytes;
    if (record.bytes > std::min(kMaxRecordBytes, size - record.begin)) break;  // cut off
    index.records.push_back(record);
    index.end = record.begin + record.bytes;
  }
  return index;
}

Result<Bytes> HistoryStore::payload(Index& index, const Record& record) {
  index.in.clear();  // the end may have been reached
  index.in.seekg(static_cast<std::streamoff>(record.begin));
  Bytes bytes = read_some(index.in, record.bytes);
  if (bytes.size() != record.bytes || crc32c(bytes) != record.crc)
    return Error{ErrorCode::kNotFound, "this moment cannot be read any more", ""};
  return bytes;
}

Result<Bytes> HistoryStore::find(JobId id, Kind kind, uint32_t number) const {
  Result<Index> index = this->index(id);
  if (!index.ok()) return index.error();
  const auto& records = index.value().records;
  const auto found = std::find_if(records.rbegin(), records.rend(), [&](const Record& r) {
    return r.kind == kind && r.number == number;
  });
  if (found == records.rend()) return no_moment();
  return payload(index.value(), *found);
}

Result<Bytes> HistoryStore::picture(JobId id, uint32_t moment) const {
  return find(id, Kind::kPicture, moment);
}

Result<Bytes> HistoryStore::table(JobId id, uint32_t moment) const {
  return find(id, Kind::kTable, moment);
}

std::vector<proto::Moment> HistoryStore::moments(JobId id) const {
  Result<Index> index = this->index(id);
  if (!index.ok()) return {};
  std::map<uint32_t, proto::Moment> moments;
  for (const Record& record : index.value().records) {
    if (record.kind != Kind::kMoment) continue;
    const Result<Bytes> bytes = payload(index.value(), record);
    if (!bytes.ok()) continue;
    SnapshotReader in(bytes.value());
    proto::Moment moment;
    in(moment);
    if (!in.whole()) continue;  // another version's
    // What came after it was of a run that was cut off.
    moments.erase(moments.lower_bound(moment.number), moments.end());
    moments[moment.number] = std::move(moment);
  }
  std::vector<proto::Moment> sorted;
  for (auto& [number, moment] : moments) sorted.push_back(std::move(moment));
  return sorted;
}

// What comes next must not stand behind a record that a crash or a full disk cut off.
bool HistoryStore::cut_to_whole_records(JobId id) const {
  std::error_code ec;
  const Result<Index> index = this->index(id);
  if (!index.ok()) return true;  // there is no file
  if (index.value().end == 0) return fs::remove(file(id), ec);
  fs::resize_file(file(id), index.value().end, ec);
  return !ec;
}

Status HistoryStore::add(JobId id, const proto::Moment& moment, const Bytes& picture,
                         const Bytes& table) {
  const Error failed{ErrorCode::kIo, "cannot write the job's history", file(id).string()};
  std::error_code ec;
  fs::create_directories(folder_, ec);
  if (!is_whole(id) && !cut_to_whole_records(id)) return failed;
  ByteWriter out;
  if (!fs::exists(file(id), ec)) out.u64(kMagic);
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

bool HistoryStore::is_whole(JobId id) const {
  std::lock_guard lock(mutex_);
  return whole_.contains(id);
}

void HistoryStore::make_room(JobId for_job, uint64_t bytes) {
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

void HistoryStore::remove(JobId id) {
  std::lock_guard lock(mutex_);
  bytes_.erase(id);
  whole_.erase(id);
  std::error_code ec;
  fs::remove(file(id), ec);
}

}  // namespace qray::server
