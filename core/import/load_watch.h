// How far loading a scene is, for whoever waits, and whether he still does.
#pragma once

#include <functional>

#include "core/import/import_failure.h"

namespace qray {

enum class LoadStep { kReading, kBuilding };  // the files; the tree for rays

// Called now and then with how much of a step is done, [0, 1], by the loading thread or, while the
// tree is built, by several at once. False: loading ends with kCanceled.
using LoadWatch = std::function<bool(LoadStep step, double fraction)>;

// For readers: throws when loading is to end.
inline void told_read(const LoadWatch& watch, double fraction) {
  if (watch && !watch(LoadStep::kReading, fraction))
    fail_import(ErrorCode::kCanceled, "canceled", "");
}

}  // namespace qray
