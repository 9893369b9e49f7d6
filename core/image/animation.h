// Pictures one after the other as a file that plays: .gif by the image library, .mp4 by the program
// ffmpeg where this machine has it. Any thread.
#pragma once

#include <filesystem>
#include <functional>

#include "core/base/result.h"
#include "core/image/image.h"

namespace qray {

struct Animation {
  int count = 0;                              // pictures, of one size
  double per_second = 0;                      // of them
  std::function<Result<Image>(int)> picture;  // linear; asked for in order, one at a time
};

constexpr double kLeastPerSecond = 0.1, kMostPerSecond = 60;

// Whether the name ends as one that write_animation() knows.
bool is_animation_name(const std::filesystem::path& path);
// kUnsupported: another ending, or ffmpeg is not there.
Status write_animation(const std::filesystem::path& path, const Animation& animation);
bool has_ffmpeg();

}  // namespace qray
