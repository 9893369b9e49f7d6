#include "core/recover/box_mean.h"

#include <algorithm>
#include <array>

namespace qray {
namespace {

constexpr int kLinesAtOnce = 16;  // columns, whose pixels lie beside each other in memory

}  // namespace

Image box_mean(const Image& image, int radius, int step, TaskPool& pool) {
  const int width = image.width(), height = image.height();
  Image rows = Image::unset(width, height, 3), out = Image::unset(width, height, 3);
  // Along `lines` lines of `count` pixels side by side, `get` and `set` by line and place.
  const auto slide = [step, radius](int lines, int count, auto&& get, auto&& set) {
    std::array<std::array<double, 3>, kLinesAtOnce> sums{};
    int known = 0, next = 0, last = 0;  // in the window: known pixels last .. next
    const auto add = [&](int at, double times) {
      for (int line = 0; line < lines; ++line)
        for (int c = 0; c < 3; ++c)
          sums[static_cast<size_t>(line)][static_cast<size_t>(c)] +=
              times * static_cast<double>(get(line, at)[c]);
    };
    for (int at = 0; at < count; ++at) {
      for (; next < std::min(count, at + radius + 1); next += step, ++known) add(next, 1);
      for (; last < at - radius; last += step, --known) add(last, -1);
      for (int line = 0; line < lines; ++line) {
        const auto& sum = sums[static_cast<size_t>(line)];
        Rgb mean;
        for (int c = 0; c < 3; ++c)
          mean[c] = std::max(0.0f, static_cast<float>(sum[static_cast<size_t>(c)] / known));
        set(line, at, mean);
      }
    }
  };
  pool.run(static_cast<size_t>(height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    if (y % step != 0) return;
    slide(
        1, width, [&](int, int x) { return image.rgb(x, y); },
        [&](int, int x, Rgb mean) { rows.set_rgb(x, y, mean); });
  });
  pool.run(static_cast<size_t>((width + kLinesAtOnce - 1) / kLinesAtOnce), [&](size_t band, int) {
    const int left = static_cast<int>(band) * kLinesAtOnce;
    slide(
        std::min(kLinesAtOnce, width - left), height,
        [&](int column, int y) { return rows.rgb(left + column, y); },
        [&](int column, int y, Rgb mean) { out.set_rgb(left + column, y, mean); });
  });
  return out;
}

}  // namespace qray
