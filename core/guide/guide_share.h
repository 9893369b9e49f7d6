// The part of a guide whose passes are sampled by several processes. One of them has the whole
// guide and ends the passes; the others have copies that sample, and record what one unit of a pass
// learns. That is integers, which may be added in any order, so the whole guide gets the bits that
// it would have had alone. Not synchronised; between units.
#pragma once

#include <span>

#include "core/base/byte_io.h"
#include "core/base/snapshot.h"

namespace qray {

class GuideShare {
 public:
  virtual ~GuideShare() = default;

  // What sampling and recording read in a pass, without what was learned.
  virtual void save_copy(SnapshotWriter& out) const = 0;
  // Makes a fresh guide of the same setup a copy, or one that was a copy before. `in` tells what
  // does not fit by its ok().
  virtual void load_copy(SnapshotReader& in) = 0;
  // Of a copy: what was learned since it was loaded or this was called. The same units give the
  // same bytes, whatever thread sampled what.
  virtual Bytes take_learned() = 0;
  // Adds it. False: it is not of a copy of this guide as it is in this pass; nothing was added.
  virtual bool add_learned(std::span<const uint8_t> learned) = 0;
};

}  // namespace qray
