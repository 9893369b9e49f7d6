// Of a store that several processes share: passes of a job whose units they sample together. The
// process that runs the job owns them: it alone begins passes and adds up what comes back. All of
// this may be lost with the database, and only costs the units that must be sampled again. Every
// call may be made twice, which changes nothing. Any thread.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/byte_io.h"
#include "core/base/result.h"
#include "server/model/job.h"

namespace qray::server {

class SharedPasses {
 public:
  virtual ~SharedPasses() = default;

  // Which pass. The claim fences: what a run that has lost its job begins or brings is refused.
  struct Key {
    JobId job;
    uint64_t claim = 0;
    int64_t pass = 0;
    bool operator==(const Key&) const = default;
  };
  // A pass as it is cut: unit n has the tiles from first + n * tiles_a_unit on, up to `end`.
  struct Cut {
    size_t first = 0, end = 0, tiles_a_unit = 1;
    size_t units() const { return (end - first + tiles_a_unit - 1) / tiles_a_unit; }
    size_t first_of(size_t unit) const { return first + unit * tiles_a_unit; }
    size_t tiles_of(size_t unit) const { return std::min(tiles_a_unit, end - first_of(unit)); }
  };
  struct Pass {
    Key key;
    Cut cut;
    double patience = 1;  // seconds that a unit may take, before it is given to another one too
    std::string guide;    // SHA-256 of what load_guide() gives; empty: none is needed
    Bytes state;          // Renderer::save_pass()
  };

  // Of the owner. `bits`: who may take part, those that say the same (bits_of_machine.h);
  // `workers`: how many, the owner counted; 0: all. `guide`: null, it is the one that is there.
  // kCanceled: the job is not this process's any more.
  virtual Status begin(const Pass& pass, const std::string& bits, int workers,
                       const Bytes* guide) = 0;
  struct Unit {
    size_t unit = 0;
    std::string worker;
    std::string hash;  // SHA-256, without measured times
    Bytes sampled;     // UnitRenderer::sample(); empty: its owner has it
  };
  struct Collected {
    bool there = true;  // false: the pass is not known, and must begin again
    std::vector<Unit> units;
    std::vector<Unit> disputed;  // all results of units that have two which differ; no samples
  };
  // What others sampled, but for the units that are `here`; some of it.
  virtual Result<Collected> collect(const Key& key, std::span<const size_t> here) = 0;
  // What was brought of these units does not count: they are to be taken again.
  virtual Status reopen(const Key& key, std::span<const size_t> units) = 0;
  virtual Status end(JobId job, uint64_t claim) = 0;  // no more of it is to be sampled

  // Of those who take part. A job that may have more of them; none: there is none.
  struct Open {
    JobId job;
    uint64_t claim = 0;
  };
  virtual Result<std::optional<Open>> find(const std::string& bits) = 0;
  // Says that this process takes part. False: there are enough, or the job has ended.
  virtual Result<bool> join(const Open& job) = 0;
  virtual Status leave(const Open& job) = 0;
  // The job's pass, if it is another than `than`.
  virtual Result<std::optional<Pass>> next(const Open& job, const std::optional<Key>& than) = 0;
  virtual Result<Bytes> load_guide(const Open& job, const std::string& guide) = 0;
  // A unit to sample; none: there is none at the moment.
  virtual Result<std::optional<size_t>> take(const Key& key, double patience) = 0;
  enum class Put { kTaken, kTwice, kDiffers, kLate };  // kTwice: another one was first, alike
  virtual Result<Put> put(const Key& key, const Unit& unit) = 0;

  virtual const std::string& me() const = 0;  // this process's name
  // That its bits differ: it takes no more jobs, and no part in others'. The reason is shown.
  virtual Status put_aside(const std::string& worker, const std::string& why) = 0;
  // How many processes are there whose bits may differ from these.
  virtual Result<int> others_of_other_bits(const std::string& bits) = 0;
};

}  // namespace qray::server
