// The pyramid network on a picture, and back: what it makes, and how that changes with each of its
// values. The same code recovers pictures and trains. Keeps its memory from picture to picture. One
// thread calls; the pool's work. The same bits for any number of threads.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/base/task_pool.h"
#include "core/image/image.h"
#include "core/recover/pyramid_memory.h"
#include "core/recover/recovery_input.h"

namespace qray {

// Whether the processor has the instructions that the fastest loops take.
bool has_avx512();

// By which a picture is multiplied to be as bright as any other: of the geometric mean of its
// squares of 16 x 16 pixels. 1 where all is black.
float exposure_of(const Image& colour);

struct PyramidInput {
  const RecoveryInput& pictures;
  float exposure;  // exposure_of() the whole picture's colour
};

class PyramidPass {
 public:
  enum class Target { kBest, kCommon };  // of the processor
  explicit PyramidPass(Target target = Target::kBest);
  PyramidPass(PyramidPass&&) = default;

  // `values`: pyramid_size() of them. Returns linear colour over (albedo + kAlbedoFloor). With
  // `learns`, what backward() needs is kept.
  Image forward(std::span<const float> values, const PyramidInput& input, TaskPool* pool,
                bool learns);

  // The picture: forward() times albedo.
  Image recover(std::span<const float> values, const PyramidInput& input, TaskPool* pool);

  // After forward() of the same values, which learned: adds to `gradient` that of a loss whose
  // gradient by forward()'s result is `d_result`, [pixel][3].
  void backward(std::span<const float> values, std::span<const float> d_result,
                std::span<float> gradient);

 private:
  using Cells = PyramidCells;
  using Plane = PyramidPlanes;
  struct Level {
    int height = 0, width = 0;
    Plane colour, features, result;
    Plane counts;   // 1: what a cell counts for in the coarser one, of the four's sum 1
    Plane kernels;  // kPyramidTaps, where it learns
    Plane d_colour, d_result;
  };
  struct Expanded;  // rows of a coarser level, each cell twice

  void pack(const PyramidInput& input, TaskPool* pool);
  void run_layer(std::span<const float> values, PyramidPart part, const Cells& in, Cells& out,
                 TaskPool* pool) const;
  void run_network(std::span<const float> values, TaskPool* pool);
  void coarsen(int level, TaskPool* pool);
  void filter(std::span<const float> values, int level, bool learns, TaskPool* pool);
  const float* coarsen_logit(int level, int y, int x) const;
  float* d_coarsen_logit(int level, int y, int x);

  void back_filter(int level, std::span<const float> scales, std::span<double> d_scales);
  void back_coarsen(int level);
  void back_layer(std::span<const float> values, PyramidPart part, const Cells& in,
                  const Cells& out, Cells& d_out, Cells* d_in, std::span<float> gradient);

  const PyramidLoops* loops_;
  int width_ = 0, height_ = 0;  // of the picture, pixels
  Level levels_[kPyramidLevels];
  Cells input_, first_;
  // By level: what goes down, that of four cells in one, what comes up, the sum that it is made of.
  Cells down_[kPyramidLevels], pooled_[kPyramidLevels], up_[kPyramidLevels], sum_[kPyramidLevels];
  Cells head_[kPyramidLevels];
  Cells d_head_[kPyramidLevels], d_up_[kPyramidLevels], d_down_[kPyramidLevels],
      d_sum_[kPyramidLevels], d_pooled_[kPyramidLevels], d_first_;
};

}  // namespace qray
