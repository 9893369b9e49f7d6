// The network on a tile, and back: what it makes, and how that changes with each of its values. The
// reference for infer.h, and what training runs. One thread an object.
#pragma once

#include <span>
#include <vector>

#include "core/recover/block_tile.h"

namespace qray {

class TilePass {
 public:
  // colour / albedo: [block][pixel][3]. Valid until the next call.
  std::span<const float> forward(const Network& net, const BlockTile& tile);

  // After forward() of the same: adds to `gradient` (as Network::values) that of a loss whose
  // gradient by forward()'s result is `d_result`. `back2`, `back3`: the layers' weights,
  // transposed.
  void backward(const Network& net, const BlockTile& tile, std::span<const float> d_result,
                std::span<const float> back2, std::span<const float> back3,
                std::span<float> gradient);

 private:
  void measure_distances(const BlockTile& tile);
  void make_kernels(const Network& net);
  void filter(const BlockTile& tile);

  // Back through a softmax of n kernel weights that begins at `first` of a block's.
  void back_kernel(size_t block, int first, int n, const float* d_kernel);
  void back_filters(const BlockTile& tile, std::span<const float> d_result);
  void back_scales(const Network& net, std::span<float> gradient);

  int height_ = 0, width_ = 0;
  Grid layer1_, layer2_, logits_;
  std::vector<float> distances_;               // [block][group][tap][kDistances]
  Grid kernels_;                               // as logits_
  std::vector<float> filtered_[kFilters + 1];  // planes; the first: what is known
  std::vector<float> result_;
  Grid d_logits_, d_layer2_, d_layer1_, padded_;
  std::vector<float> d_filtered_[kFilters + 1];
};

}  // namespace qray
