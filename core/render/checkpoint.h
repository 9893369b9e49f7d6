// Going on after an interruption: a render writes its whole state now and then, between tiles, and
// another one that reads it ends with the same bits as if it had never been cut off. Passes that
// are bounded by time end where the time that both took is over.
#pragma once

#include <functional>

#include "core/base/result.h"
#include "core/base/snapshot.h"

namespace qray {

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
