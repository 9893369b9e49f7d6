// A picture recovered by the network, fast: what TilePass makes, within rounding. For one network
// and size; keeps its memory from picture to picture, a few MiB for each thread. One thread calls;
// the pool's work.
#pragma once

#include <memory>
#include <vector>

#include "core/base/task_pool.h"
#include "core/image/image.h"
#include "core/recover/infer_rows.h"

namespace qray {

// Whether the processor has the instructions that the fastest loops take.
bool has_avx512();

class FastRecovery {
 public:
  enum class Target { kBest, kCommon };  // of the processor

  // Pixels; even.
  FastRecovery(const Network& net, int width, int height, Target target = Target::kBest);

  // features: kFeatures channels; input: linear colour, of which the first pixel of each block is
  // read; noise: as tile_of() takes it. Returns linear colour.
  Image run(const Image& features, const Image& input, const Image& noise, TaskPool& pool);

 private:
  // Some rows of the picture, made from start to end by one thread.
  struct Band {
    InferRows rows;
    std::vector<std::unique_ptr<float[]>> memory;
  };
  Band make_band() const;
  void run_band(const InferRows& rows, int begin, int end) const;

  std::vector<float> values_;    // of the network; scales as factors
  int hidden_, width_, height_;  // blocks
  const InferLoops* loops_;
  std::vector<Band> bands_;
};

}  // namespace qray
