// Convolutions over grids with interleaved channels, and their gradients. Any thread.
#pragma once

#include <cstddef>
#include <vector>

namespace qray {

struct Grid {
  int height = 0, width = 0, channels = 0;
  std::vector<float> data;

  Grid() = default;
  Grid(int h, int w, int c) { resize(h, w, c); }
  void resize(int h, int w, int c) {
    height = h, width = w, channels = c;
    data.resize(static_cast<size_t>(h) * static_cast<size_t>(w) * static_cast<size_t>(c));
  }
  float* at(int y, int x) { return data.data() + index(y, x); }
  const float* at(int y, int x) const { return data.data() + index(y, x); }

 private:
  size_t index(int y, int x) const {
    return (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) *
           static_cast<size_t>(channels);
  }
};

// out = leaky(bias + in * weights), where the whole kernel of side x side lies inside `in`: out is
// side - 1 smaller each way. Weights [tap][input][output]; outputs are a multiple of 16; bias may
// be null.
void convolve(const Grid& in, int side, const float* weights, const float* bias, float slope,
              int outputs, Grid& out);

// Adds to d_weights and d_bias what d_out, the gradient before the leaky unit, makes of them.
// Inputs are a multiple of 4.
void add_weight_gradient(const Grid& in, int side, const Grid& d_out, float* d_weights,
                         float* d_bias);

// Weights [tap][input][output] -> those that take d_out back to the input: [tap reversed]
// [output][input]; for convolve() over d_out with side - 1 zeros around.
std::vector<float> transposed(const float* weights, int taps, int inputs, int outputs);

}  // namespace qray
