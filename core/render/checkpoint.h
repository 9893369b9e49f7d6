// Going on after an interruption: a render writes its whole state now and then, between tiles, and
// another one of the same build that reads it ends with the same bits as if it had never been cut
// off. Passes that are bounded by time end where the time that both took is over: how many those
// are is another matter each time.
#pragma once

#include <cstdint>
#include <functional>

#include "core/base/result.h"
#include "core/base/snapshot.h"

namespace qray {

// A state is the work of all exchange() functions of film, render and guide. Raise the format when
// one of them lists other members than before, or the same ones in another order: what was written
// until then is refused. Raise the revision when members of the same kind mean something else (a
// unit, a count's scale), or when samples must not be added up with those of before.
constexpr uint32_t kStateFormat = 15;
constexpr uint32_t kStateRevision = 11;

// Who keeps states. due() is asked by worker threads before each tile, one at a time, and must
// return at once; save() is called by the thread that renders, while no tile is worked on.
class Checkpointer {
 public:
  virtual ~Checkpointer() = default;
  virtual bool due() = 0;
  // `write` writes the state. False: the render shall end here; it then fails with kCanceled.
  virtual bool save(const std::function<void(SnapshotWriter&)>& write) = 0;
};

struct Checkpoints {
  Checkpointer* keeper = nullptr;         // null: none are kept
  SnapshotReader* resume_from = nullptr;  // null: from the start
};

}  // namespace qray
