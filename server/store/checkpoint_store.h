// What interrupted jobs go on from: <data>/checkpoints/<job>, one file each, replaced whole,
// and of jobs of many frames a folder <job>.frames with two files of each. Those
// of finished jobs stay, so that more can be rendered onto them, as long as there is room. Any
// thread; one job's by one at a time.
//
// Who may go on from a state that another build of qray wrote: one of the same format and revision
// (core/render/checkpoint.h), which is told so (Checkpoint::other_build). From that of the same
// build (core/base/build_identity.h) a job ends with the bits of one that was let alone.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/file.h"
#include "core/base/result.h"
#include "core/base/snapshot.h"
#include "core/render/checkpoint.h"
#include "server/model/job.h"

namespace qray::server {

// Beside the state of its render: what the job was begun with.
struct CheckpointHeader {
  std::string scene_hash;
  std::string table_in;  // a table's id; empty: none
  std::string recovery;  // the network's name; empty: none
  std::vector<std::string> warnings;
  bool mixed_builds = false;  // another build than the one that writes this has rendered a part

  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.scene_hash, self.table_in, self.recovery, self.warnings, self.mixed_builds);
  }
};

// Who wrote a state.
struct StateOrigin {
  uint32_t format = kStateFormat, revision = kStateRevision;
  std::string build;
};
StateOrigin this_build();

struct Checkpoint {
  CheckpointHeader header;
  bool other_build = false;  // wrote it
  MappedFile file;
  size_t state_begin = 0, state_end = 0;
  SnapshotReader state() const {
    return SnapshotReader(file.bytes().subspan(state_begin, state_end - state_begin));
  }
};

class CheckpointStore {
 public:
  // `max_finished_bytes`: of finished jobs' together. `here`: who writes and reads.
  CheckpointStore(std::filesystem::path data, uint64_t max_finished_bytes, StateOrigin here)
      : folder_(std::move(data) / "checkpoints"),
        max_finished_bytes_(max_finished_bytes),
        here_(std::move(here)) {}

  using Stopped = std::function<bool()>;
  // kCanceled: `stopped` said so; the state before is still there.
  Status save(
      JobId id, const CheckpointHeader& header,
      const std::function<void(SnapshotWriter&)>& write_state,
      const Stopped& stopped = [] { return false; });
  // kNotFound: there is none. kCorrupt: torn or changed. kUnsupported: of another format or
  // revision.
  Result<Checkpoint> load(JobId id) const;
  // The same of one of its frames (core/job/run_frames.h), beside that of the frame's turn before.
  Status save_frame(JobId id, int frame, int turn,
                    const std::function<void(SnapshotWriter&)>& write_state,
                    const Stopped& stopped);
  Result<Checkpoint> load_frame(JobId id, int frame, int turn) const;
  bool has(JobId id) const;
  void remove(JobId id);
  // The job has succeeded; the oldest that have make room.
  void finished(JobId id);
  // At a start: `keep` tells of which jobs there may be any, and which of them have succeeded.
  enum class Keep { kNo, kOpen, kFinished };
  // Of the others those go that were written `left` ago.
  void tidy(const std::function<Keep(JobId)>& keep, std::chrono::seconds left = {});

 private:
  std::filesystem::path file(JobId id) const { return folder_ / id.text(); }
  std::filesystem::path frames_folder(JobId id) const { return folder_ / (id.text() + kFrames); }
  std::filesystem::path frame_file(JobId id, int frame, int turn) const;
  Status write(const std::filesystem::path& path, const CheckpointHeader& header,
               const std::function<void(SnapshotWriter&)>& write_state,
               const Stopped& stopped) const;
  Result<Checkpoint> read(const std::filesystem::path& path) const;
  uint64_t bytes_of(JobId id) const;
  void remove_files(JobId id) const;
  static constexpr const char* kFrames = ".frames";

  std::filesystem::path folder_;
  uint64_t max_finished_bytes_;
  const StateOrigin here_;
  std::mutex mutex_;
  std::vector<JobId> finished_;  // the oldest first
};

}  // namespace qray::server
