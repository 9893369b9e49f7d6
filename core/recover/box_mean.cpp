#include "core/recover/box_mean.h"

#include <algorithm>
#include <array>

namespace qray {

Image box_mean(const Image& image, int radius, int step, TaskPool& pool) {
  const int width = image.width(), height = image.height();
  Image rows(width, height, 3), out(width, height, 3);
  // Along a line of `count` pixels, `get` and `set` by place.
  const auto slide = [step, radius](int count, auto&& get, auto&& set) {
    std::array<double, 3> sum{};
    int known = 0, next = 0, last = 0;  // in the window: known pixels last .. next
    for (int at = 0; at < count; ++at) {
      for (; next < std::min(count, at + radius + 1); next += step, ++known)
        for (int c = 0; c < 3; ++c)
          sum[static_cast<size_t>(c)] += static_cast<double>(get(next)[c]);
      for (; last < at - radius; last += step, --known)
        for (int c = 0; c < 3; ++c)
          sum[static_cast<size_t>(c)] -= static_cast<double>(get(last)[c]);
      Rgb mean;
      for (int c = 0; c < 3; ++c)
        mean[c] = std::max(0.0f, static_cast<float>(sum[static_cast<size_t>(c)] / known));
      set(at, mean);
    }
  };
  pool.run(static_cast<size_t>(height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    if (y % step != 0) return;
    slide(
        width, [&](int x) { return image.rgb(x, y); },
        [&](int x, Rgb mean) { rows.set_rgb(x, y, mean); });
  });
  pool.run(static_cast<size_t>(width), [&](size_t column, int) {
    const int x = static_cast<int>(column);
    slide(
        height, [&](int y) { return rows.rgb(x, y); },
        [&](int y, Rgb mean) { out.set_rgb(x, y, mean); });
  });
  return out;
}

}  // namespace qray
