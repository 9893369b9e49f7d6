// Parameters of the thesis' method (section 4.2), which `huang` and `huang-published` share. The
// thesis prints no values: these made the least noise of those tried in docs/guiding.md.
#pragma once

namespace qray {

struct HuangParams {
  float alpha = 0.02f;  // learning rate, [0, 1]
  float gamma = 0.2f;   // discount, [0, 1]
  // Cells along the scene's longest side, about: rounded to a power-of-two size. `dahm-keller` has
  // its states on the same grid.
  int grid = 24;
  bool operator==(const HuangParams&) const = default;
};

}  // namespace qray
