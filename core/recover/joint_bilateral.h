// What recovery by a network is measured against: a cross-bilateral filter (Petschnigg et al. 2004,
// Eisemann and Durand 2004) of one step over known pixels, its widths fitted to a scene's views.
// Any thread.
#pragma once

#include <array>
#include <span>

#include "core/base/task_pool.h"
#include "core/recover/network.h"
#include "core/recover/training_view.h"

namespace qray {

struct JointBilateral {
  float sigma = 1.5f;                                          // blocks
  std::array<float, kDistances> scales{5.6f, 1250, 0.5f, 50};  // of feature_distances()
};

// From the first pixel of each 2 x 2 block. Even sides.
Image joint_bilateral(const JointBilateral& filter, const Image& features, const Image& input,
                      TaskPool& pool);

// The widths with the least mean relMSE over the views, of those that a search by halves and
// doubles, one after the other, comes by.
JointBilateral fitted_joint_bilateral(std::span<const TrainingView> views, TaskPool& pool);

}  // namespace qray
