// What interrupted jobs go on from: <data>/checkpoints/<job>, one file each, replaced whole. Those
// of finished jobs stay, so that more can be rendered onto them, as long as there is room. Any
// thread; one job's by one at a time.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/file.h"
#include "core/base/result.h"
#include "core/base/snapshot.h"
#include "server/store/job.h"

namespace qray::server {

// Beside the state of its render: what the job was begun with.
struct CheckpointHeader {
  std::string scene_hash;
  std::string table_in;  // a table's id; empty: none
  std::string recovery;  // the network's name; empty: none
  std::vector<std::string> warnings;

  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.scene_hash, self.table_in, self.recovery, self.warnings);
  }
};

struct Checkpoint {
  CheckpointHeader header;
  MappedFile file;
  size_t state_begin = 0, state_end = 0;
  SnapshotReader state() const {
    return SnapshotReader(file.bytes().subspan(state_begin, state_end - state_begin));
  }
};

class CheckpointStore {
 public:
  // `max_finished_bytes`: of finished jobs' together.
  CheckpointStore(std::filesystem::path data, uint64_t max_finished_bytes)
      : folder_(std::move(data) / "checkpoints"), max_finished_bytes_(max_finished_bytes) {}

  Status save(JobId id, const CheckpointHeader& header,
              const std::function<void(SnapshotWriter&)>& write_state);
  // kNotFound: there is none. kCorrupt, kUnsupported: not one of this program.
  Result<Checkpoint> load(JobId id) const;
  bool has(JobId id) const;
  void remove(JobId id);
  // The job has succeeded; the oldest that have make room.
  void finished(JobId id);
  // At a start: `keep` tells of which jobs there may be any, and which of them have succeeded.
  enum class Keep { kNo, kOpen, kFinished };
  void tidy(const std::function<Keep(JobId)>& keep);

 private:
  std::filesystem::path file(JobId id) const { return folder_ / id.text(); }

  std::filesystem::path folder_;
  uint64_t max_finished_bytes_;
  std::mutex mutex_;
  std::vector<JobId> finished_;  // the oldest first
};

}  // namespace qray::server
