// What the network learns from: small pictures of one scene, each with noisy pixels as they will be
// given and, in other random numbers, a target that may be noisy too. Plain data.
#pragma once

#include "core/image/image.h"
#include "core/recover/recovery_input.h"

namespace qray {

struct TrainingView {
  RecoveryInput input;       // of every pixel, so that any may be the known one
  Image target;              // linear colour, without what lights show of themselves
  double target_relmse = 0;  // of the target itself, about: what the truth's error against it is
};

// One of the eight ways to turn and mirror a square.
struct Flip {
  bool mirror_x = false, mirror_y = false, exchange = false;
};

// height x width pixels of a turned square picture, from pixel (y, x) on.
Image turned(const Image& image, int y, int x, int height, int width, Flip flip);

}  // namespace qray
