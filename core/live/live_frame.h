// A frame of a walk through a scene, and what it is asked to be. Plain data.
#pragma once

#include <cstdint>
#include <string_view>

#include "core/image/image.h"
#include "core/settings/render_settings.h"

namespace qray {

struct LiveSwitches {
  bool learning = true, recovery = true, reprojection = true;
  bool operator==(const LiveSwitches&) const = default;
};

struct LiveSettings {
  // Method, size (even), seed, depth, gate; how many samples is not asked. `pixels` is of a camera
  // that moves: kAll, each as often as any other; kQuarter, each block of 2 x 2, whose pixels take
  // turns; kByNoise, blocks of which little is known more often.
  RenderSettings render;
  double frame_seconds = 0.1;
  // > 0: in each moving frame, and of as many of a resting frame's pixels, whatever time that
  // takes: the same frames for any number of threads.
  double paths_per_block = 0;
};

// What a frame shows.
enum class LiveStage {
  kMoving,    // history and recovery
  kSettling,  // the same, of a camera that rests: its samples displace what was seen before
  kStill,     // its samples, and recovery where they are not sure
};
std::string_view live_stage_name(LiveStage stage);  // moving, settling, still

struct LiveTimes {  // seconds
  double features = 0, reprojection = 0, samples = 0, learning = 0, recovery = 0, whole = 0;
};

struct LiveFrame {
  uint64_t number = 0;  // from 1 on
  LiveStage stage = LiveStage::kMoving;
  Image picture;     // linear
  double scale = 1;  // sides of what was rendered over the picture's: less where time is short
  LiveTimes times;
  uint64_t paths = 0, rays = 0;
  bool guided = false;
  double samples_per_pixel = 0;  // in the picture, on average
  double noise = 0;              // of the samples in it, relative, before recovery; 0: not known
};

}  // namespace qray
