// What a network makes of pictures, whatever their energy. Keeps its memory from picture to
// picture. One thread calls; the pool's work.
#pragma once

#include "core/recover/network.h"
#include "core/recover/pyramid_pass.h"

namespace qray {

class Guess {
 public:
  // An empty one is not to be asked.
  explicit Guess(Network network) : network_(std::move(network)) {}
  bool has_network() const { return !network_.empty(); }

  Image of_all(const RecoveryInput& input, TaskPool& pool);
  // `known`: of one pixel in each 2 x 2, the first, half as wide and high as `features`. The
  // network cleans these as a picture of their own, and what features tell makes the others of
  // them.
  Image of_quarter(const RecoveryInput& known, const Image& features, TaskPool& pool);

 private:
  Network network_;
  PyramidPass all_, quarter_;
};

}  // namespace qray
