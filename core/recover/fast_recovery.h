// A picture recovered by the network, fast: what TilePass makes, within rounding. For one network
// and size; keeps its memory from picture to picture. One thread calls; the pool's work.
#pragma once

#include <memory>
#include <vector>

#include "core/base/task_pool.h"
#include "core/image/image.h"
#include "core/recover/infer_rows.h"

namespace qray {

class FastRecovery {
 public:
  enum class Target { kBest, kCommon };  // of the processor

  // Pixels; even.
  FastRecovery(const Network& net, int width, int height, Target target = Target::kBest);

  // features: kFeatures channels; input: linear colour, of which the first pixel of each block is
  // read; noise: as tile_of() takes it. Returns linear colour.
  Image run(const Image& features, const Image& input, const Image& noise, TaskPool& pool);

 private:
  Planes planes(int count);
  void pack_row(const Image& features, const Image& input, const Image& noise, int y);
  void copy_border(const Planes& planes);

  std::vector<float> values_;  // of the network; scales as factors
  InferRows rows_;
  const InferLoops* loops_;
  std::vector<std::unique_ptr<float[]>> memory_;
};

}  // namespace qray
