#include "core/recover/fast_recovery.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/recover/lanes.h"

namespace qray {
namespace {

bool has_avx512() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq");
#else
  return false;
#endif
}

}  // namespace

FastRecovery::FastRecovery(const Network& net, int width, int height, Target target)
    : values_(net.values),
      loops_(target == Target::kBest && has_avx512() ? &avx512_loops() : &common_loops()) {
  QRAY_CHECK(width > 0 && height > 0 && width % 2 == 0 && height % 2 == 0);
  const Network::Parts at = net.parts();
  for (size_t i = at.scales; i < at.size; ++i) values_[i] = std::exp(values_[i]);
  const float* v = values_.data();
  rows_.width = width / 2, rows_.height = height / 2;
  rows_.hidden = net.hidden;
  rows_.weights1 = v + at.weights1, rows_.bias1 = v + at.bias1;
  rows_.weights2 = v + at.weights2, rows_.bias2 = v + at.bias2;
  rows_.weights3 = v + at.weights3, rows_.bias3 = v + at.bias3;
  rows_.scales = v + at.scales;
  rows_.features = planes(kBlock * kFeatures);
  rows_.colour = planes(kColour);
  rows_.noise = planes(1);
  rows_.known = planes(kColour);
  rows_.layer1 = planes(net.hidden);
  rows_.layer2 = planes(net.hidden);
  for (int f = 0; f < kFilters; ++f) {
    rows_.kernels[f] = f > 0 ? planes(kTaps) : Planes{};
    rows_.filtered[f] = planes(kColour);
  }
}

// A row's border on the left takes the room that the row above has on the right. Blocks beyond the
// borders, up to a whole register, are worked on too, whatever is there.
Planes FastRecovery::planes(int count) {
  const std::ptrdiff_t pitch = (rows_.width + kLanes - 1) / kLanes * kLanes + 2 * kLanes;
  const std::ptrdiff_t row = pitch * count;
  memory_.push_back(std::make_unique_for_overwrite<float[]>(
      static_cast<size_t>(row * (rows_.height + 2 * kBorder) + 2 * kLanes)));
  return {memory_.back().get() + kLanes + kBorder * row, pitch, count};
}

void FastRecovery::pack_row(const Image& features, const Image& input, const Image& noise, int y) {
  const auto pixel = [](const Image& image, int x, int row) {
    return &image.data()[(static_cast<size_t>(row) * static_cast<size_t>(image.width()) +
                          static_cast<size_t>(x)) *
                         static_cast<size_t>(image.channels())];
  };
  // A few blocks at a time, whose pixels stay near.
  for (int begin = 0; begin < rows_.width; begin += kLanes) {
    const int count = std::min(kLanes, rows_.width - begin);
    for (int s = 0; s < kBlock; ++s) {
      const float* from = pixel(features, 2 * begin + s % 2, 2 * y + s / 2);
      for (int f = 0; f < kFeatures; ++f) {
        float* to = rows_.features.at(s * kFeatures + f, y, begin);
        for (int b = 0; b < count; ++b) to[b] = from[2 * kFeatures * b + f];
      }
    }
  }
  const float* light = pixel(input, 0, 2 * y);
  for (int c = 0; c < kColour; ++c) {
    float *known = rows_.known.at(c, y, 0), *colour = rows_.colour.at(c, y, 0);
    const float* a = rows_.features.at(c, y, 0);
    for (int x = 0; x < rows_.width; ++x) {
      known[x] = light[2 * kColour * x + c] / (a[x] + kAlbedoFloor);
      colour[x] = known[x] / (1 + known[x]);
    }
  }
  const float* noises = pixel(noise, 0, 2 * y);
  for (int x = 0; x < rows_.width; ++x) *rows_.noise.at(0, y, x) = noises[2 * x];
  const auto extend = [&](const Planes& planes, int count) {
    for (int k = 0; k < count; ++k)
      for (int b = 1; b <= kBorder; ++b) {
        *planes.at(k, y, -b) = *planes.at(k, y, 0);
        *planes.at(k, y, rows_.width - 1 + b) = *planes.at(k, y, rows_.width - 1);
      }
  };
  extend(rows_.features, kFeatures);  // taps reach known pixels alone
  extend(rows_.known, kColour);
}

void FastRecovery::copy_border(const Planes& planes) {
  for (int k = 0; k < planes.count; ++k)
    for (int b = 1; b <= kBorder; ++b) {
      const int size = rows_.width + 2 * kBorder;
      std::copy_n(planes.at(k, 0, -kBorder), size, planes.at(k, -b, -kBorder));
      std::copy_n(planes.at(k, rows_.height - 1, -kBorder), size,
                  planes.at(k, rows_.height - 1 + b, -kBorder));
    }
}

Image FastRecovery::run(const Image& features, const Image& input, const Image& noise,
                        TaskPool& pool) {
  const int width = 2 * rows_.width, height = 2 * rows_.height;
  for (const auto& [image, channels] : {std::pair{&features, kFeatures}, {&input, 3}, {&noise, 1}})
    QRAY_CHECK(image->width() == width && image->height() == height &&
               image->channels() == channels);
  Image out(width, height, 3);
  rows_.out = out.data().data();
  constexpr int kRows = 8;  // at once
  const auto each_row = [&](auto&& row) {
    pool.run(static_cast<size_t>((rows_.height + kRows - 1) / kRows), [&](size_t part, int) {
      const int first = static_cast<int>(part) * kRows;
      for (int y = first; y < std::min(first + kRows, rows_.height); ++y) row(y);
    });
  };
  each_row([&](int y) {
    pack_row(features, input, noise, y);
    loops_->layer1_row(rows_, y);
  });
  copy_border(rows_.features);
  copy_border(rows_.known);
  copy_border(rows_.layer1);
  each_row([&](int y) { loops_->first_filter_row(rows_, y); });
  copy_border(rows_.filtered[0]);
  for (int f = 1; f < kFilters; ++f) {
    each_row([&](int y) { loops_->later_filter_row(rows_, y, f); });
    copy_border(rows_.filtered[f]);
  }
  each_row([&](int y) { loops_->pixels_row(rows_, y); });
  return out;
}

}  // namespace qray
