// How jobs came to be: a moment for each finished pass, of some the picture, of some the table too.
// <data>/moments/<job>, one file each, only ever appended to; the oldest jobs' make room. Lost
// without harm: nothing else rests on it. A file of another version is not read. Any thread; one
// job's is written by one at a time.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <vector>

#include "core/base/byte_io.h"
#include "core/base/result.h"
#include "server/model/job.h"

namespace qray::server {

class MomentStore {
 public:
  // `max_bytes`: of all jobs' together.
  MomentStore(const std::filesystem::path& data, uint64_t max_bytes);

  // At a start: removes what was kept in another format than this one's. Of which jobs it was.
  std::vector<JobId> remove_others();

  // `picture`: as encode_tiles() makes it; `table`: as encode_table() does. Either may be empty. A
  // moment of a number that is there takes its place: the job went on from before it.
  Status add(JobId id, const proto::Moment& moment, const Bytes& picture, const Bytes& table);
  // By number; empty: none are kept.
  std::vector<proto::Moment> moments(JobId id) const;
  // kNotFound: not kept.
  Result<Bytes> picture(JobId id, uint32_t moment) const;
  Result<Bytes> table(JobId id, uint32_t moment) const;
  void remove(JobId id);

 private:
  enum class Kind : uint32_t { kMoment = 1, kPicture = 2, kTable = 3 };
  struct Record {
    Kind kind;
    uint32_t number = 0, crc = 0;
    uint64_t begin = 0, bytes = 0;  // in the file
  };
  struct Index {
    std::ifstream in;
    std::vector<Record> records;
    uint64_t end = 0;  // of the last whole one
  };
  std::filesystem::path file(JobId id) const { return folder_ / id.text(); }
  Result<Index> index(JobId id) const;  // kNotFound: no file
  static Result<Bytes> payload(Index& index, const Record& record);
  Result<Bytes> find(JobId id, Kind kind, uint32_t number) const;
  bool is_whole(JobId id) const;
  bool cut_to_whole_records(JobId id) const;
  void make_room(JobId for_job, uint64_t bytes);

  std::filesystem::path folder_;
  std::filesystem::path old_folder_;  // of qray before moments had a format of their own
  uint64_t max_bytes_;
  mutable std::mutex mutex_;
  std::map<JobId, uint64_t> bytes_;  // of the files, about
  std::set<JobId> whole_;            // that end with a whole record
};

}  // namespace qray::server
