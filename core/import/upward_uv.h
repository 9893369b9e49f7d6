// Maps of uv in formats whose v runs down a picture, as ours, whose v runs up. Pure function.
#pragma once

#include "core/image/texture_cache.h"

namespace qray {

// u' = a u + b v + tx, v' = c u + d v + ty with v downward: v = 1 - v before and after.
inline UvTransform upward(double a, double b, double tx, double c, double d, double ty) {
  const auto f = [](double v) { return static_cast<float>(v); };
  return {{f(a), f(-b), f(b + tx)}, {f(-c), f(d), f(1 - d - ty)}};
}

}  // namespace qray
