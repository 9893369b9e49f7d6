// Training views on disk: taking them costs most of a training's time, and several trainings may
// learn from the same. A working file for the program that wrote it, not a format to keep. Any
// thread.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/recover/training_view.h"

namespace qray {

Status write_views(const std::filesystem::path& path, const std::vector<TrainingView>& views);
// kNotFound where there is no file; kCorrupt where this program did not write it whole.
Result<std::vector<TrainingView>> read_views(const std::filesystem::path& path);

}  // namespace qray
