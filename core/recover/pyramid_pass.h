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
  static constexpr int kLast = kPyramidLevels - 1;
  static constexpr PyramidPart kDownParts[] = {kFirstLayer, kDown1, kDown2, kDown3, kDown4, kDown5};
  static constexpr PyramidPart kUpParts[] = {kFirstLayer, kUp1, kUp2, kUp3, kUp4};
  static constexpr PyramidPart kHeadParts[] = {kHead0, kHead1, kHead2, kHead3, kHead4, kHead5};
  struct Level {
    int height = 0, width = 0;
    Plane colour, features;  // of level 0 only where it learns
    Plane result;            // not of level 0, where it goes to the picture
    Plane counts;            // 1: at first a logit, then what a cell counts for in the coarser one
    Plane kernels;           // kPyramidTaps, where it learns
    Plane d_colour, d_result;
  };
  struct Run {
    std::span<const float> values;
    const PyramidInput& input;
    TaskPool* pool;
    bool learns, times_albedo;
  };
  struct Scratch {           // of a worker
    Cells band;              // what a layer is run on
    Plane colour, features;  // of a band of the picture
    ExpandedRows coarse;
    std::vector<float> inputs, logits, planes, result;  // rows
  };

  Image run(const Run& run);
  void pack(const Run& run);
  void unpack(const RecoveryInput& pictures, int y, const CellPlanes& colour,
              const CellPlanes& features, int to) const;
  void pack_inputs(const Run& run, int row, float* out) const;
  void run_row(std::span<const float> values, const PyramidLayer& layer, float slope, float* in,
               int width, float* out) const;
  template <typename MakeRow>
  void run_layer(const Run& run, PyramidPart part, int level, Cells& kept, Cells& out,
                 const MakeRow& make);
  void run_network(const Run& run);
  void keep_coarsen_logits(const Run& run, int level, int y, int worker);
  void coarsen(const Run& run, int level);
  FilterRow filter_row(int level, int y, ExpandedRows& coarse) const;
  void filter(const Run& run, int level, Image& picture);
  const Cells& unit_of(int level) const;
  float* d_coarsen_logit(int level, int y, int x);

  void back_filter(int level, std::span<const float> scales, std::span<double> d_scales);
  void back_coarsen(int level);
  void back_layer(std::span<const float> values, PyramidPart part, const Cells& in,
                  const Cells* out, Cells& d_out, Cells* d_in, std::span<float> gradient);

  const PyramidLoops* loops_;
  int width_ = 0, height_ = 0;  // of the picture, pixels
  Level levels_[kPyramidLevels];
  std::vector<Scratch> scratch_;
  // By level: what goes down, and what comes up.
  Cells down_[kPyramidLevels], up_[kPyramidLevels];
  // What these layers were run on, where it learns: of four cells in one, and sums.
  Cells input_, first_, pooled_[kPyramidLevels], sum_[kPyramidLevels];
  Cells d_head_[kPyramidLevels], d_up_[kPyramidLevels], d_down_[kPyramidLevels],
      d_sum_[kPyramidLevels], d_pooled_[kPyramidLevels], d_first_;
};

}  // namespace qray
