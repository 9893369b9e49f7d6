#include "server/store/weights_store.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <numeric>

#include "core/base/file.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

int64_t written_ms(const fs::path& file) {
  std::error_code ec;
  const fs::file_time_type at = fs::last_write_time(file, ec);
  if (ec) return 0;
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::file_clock::to_sys(at).time_since_epoch())
      .count();
}

proto::WeightsInfo info_of(const WeightsFile& w, uint64_t bytes, int64_t created_ms) {
  proto::WeightsInfo info;
  info.id = w.id;
  info.scene = w.scene;
  info.program = w.program;
  info.created_ms = created_ms;
  info.bytes = bytes;
  info.steps = w.steps;
  info.views = w.held_out.size();
  if (!w.held_out.empty())
    info.held_out = std::accumulate(w.held_out.begin(), w.held_out.end(), 0.0) /
                    static_cast<double>(w.held_out.size());
  return info;
}

}  // namespace

Result<std::unique_ptr<WeightsStore>> WeightsStore::open(fs::path data) {
  for (const char* folder : {"weights", "quarantine"}) {
    std::error_code ec;
    fs::create_directories(data / folder, ec);
    if (ec) return Error{ErrorCode::kIo, ec.message(), (data / folder).string()};
  }
  std::unique_ptr<WeightsStore> store(new WeightsStore(std::move(data)));
  store->watch_.changed(store->data_ / "weights");
  if (Status s = store->look_again(); !s.ok()) return s.error();
  return store;
}

Status WeightsStore::look_again() const {
  std::vector<std::pair<int64_t, std::string>> found;
  std::error_code ec;
  for (const fs::directory_entry& entry : fs::directory_iterator(data_ / "weights", ec))
    if (entry.path().extension() == ".qrw")
      found.emplace_back(written_ms(entry.path()), entry.path().stem().string());
  if (ec) return Error{ErrorCode::kIo, ec.message(), (data_ / "weights").string()};
  std::sort(found.begin(), found.end());
  std::vector<Entry> before = std::exchange(entries_, {});
  for (const auto& [created_ms, id] : found) {
    const auto known = std::find_if(before.begin(), before.end(),
                                    [&](const Entry& entry) { return entry.info.id == id; });
    if (known != before.end()) {
      entries_.push_back(std::move(*known));
      continue;
    }
    const Result<WeightsFile> weights = read(id);
    if (weights.ok()) {
      note(weights.value(), created_ms);
    } else {
      spdlog::warn("weights {}: {}", id, weights.error().text());
    }
  }
  return {};
}

void WeightsStore::look_again_if_changed() const {
  if (!watch_.changed(data_ / "weights")) return;
  if (Status s = look_again(); !s.ok()) spdlog::warn("weights: {}", s.error().text());
}

fs::path WeightsStore::file_of(const std::string& id) const {
  return data_ / "weights" / (id + ".qrw");
}

void WeightsStore::note(const WeightsFile& weights, int64_t created_ms) const {
  entries_.push_back({info_of(weights, encode_weights(weights).size(), created_ms),
                      {weights.geometry, weights.materials, weights.lights}});
}

Status WeightsStore::add(const WeightsFile& weights) {
  std::lock_guard lock(mutex_);
  look_again_if_changed();
  for (const Entry& entry : entries_)
    if (entry.info.id == weights.id) return {};
  if (entries_.size() >= kMost)
    return Error{ErrorCode::kConflict, "there are " + std::to_string(kMost) + " already", ""};
  const fs::path file = file_of(weights.id);
  if (Status s = write_file_atomic(file, encode_weights(weights)); !s.ok()) return s;
  note(weights, written_ms(file));
  return {};
}

std::vector<proto::WeightsInfo> WeightsStore::list() const {
  std::lock_guard lock(mutex_);
  look_again_if_changed();
  std::vector<proto::WeightsInfo> infos;
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry)
    infos.push_back(entry->info);
  return infos;
}

Result<proto::WeightsInfo> WeightsStore::find(const std::string& id) const {
  std::lock_guard lock(mutex_);
  look_again_if_changed();
  for (const Entry& entry : entries_)
    if (entry.info.id == id) return entry.info;
  return Error{ErrorCode::kNotFound, "no weights " + id, ""};
}

Result<WeightsFile> WeightsStore::read(const std::string& id) const {
  const Result<Bytes> bytes = read_file(file_of(id), kMaxWeightsBytes);
  if (!bytes.ok()) return bytes.error();
  Result<WeightsFile> weights = decode_weights(bytes.value());
  if (weights.ok() && weights.value().id != id)
    weights = Error{ErrorCode::kCorrupt, "holds the id " + weights.value().id, id + ".qrw"};
  if (!weights.ok()) {
    std::error_code ec;
    fs::rename(file_of(id), data_ / "quarantine" / (id + ".qrw"), ec);
    if (ec) return Error{ErrorCode::kIo, ec.message(), file_of(id).string()};
  }
  return weights;
}

Result<WeightsFile> WeightsStore::load(const std::string& id) {
  if (const Result<proto::WeightsInfo> known = find(id); !known.ok()) return known.error();
  Result<WeightsFile> weights = read(id);
  if (weights.ok() || weights.error().code == ErrorCode::kIo) return weights;
  std::lock_guard lock(mutex_);
  std::erase_if(entries_, [&](const Entry& entry) { return entry.info.id == id; });
  return weights;
}

std::optional<std::string> WeightsStore::fitting(const SceneHash& scene) const {
  std::lock_guard lock(mutex_);
  look_again_if_changed();
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry)
    if (entry->scene == scene) return entry->info.id;
  return {};
}

Status WeightsStore::remove(const std::string& id) {
  std::lock_guard lock(mutex_);
  look_again_if_changed();
  if (std::erase_if(entries_, [&](const Entry& entry) { return entry.info.id == id; }) == 0)
    return Error{ErrorCode::kNotFound, "no weights " + id, ""};
  std::error_code ec;
  fs::remove(file_of(id), ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), file_of(id).string()};
  return {};
}

}  // namespace qray::server
