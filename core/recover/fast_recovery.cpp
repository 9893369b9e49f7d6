#include "core/recover/fast_recovery.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/recover/lanes.h"

namespace qray {
bool has_avx512() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq");
#else
  return false;
#endif
}

FastRecovery::FastRecovery(const Network& net, int width, int height, Target target)
    : values_(net.values),
      hidden_(net.hidden),
      width_(width / 2),
      height_(height / 2),
      loops_(target == Target::kBest && has_avx512() ? &avx512_loops() : &common_loops()) {
  QRAY_CHECK(width > 0 && height > 0 && width % 2 == 0 && height % 2 == 0);
  const Network::Parts at = net.parts();
  for (size_t i = at.scales; i < at.size; ++i) values_[i] = std::exp(values_[i]);
}

FastRecovery::Band FastRecovery::make_band() const {
  Band band;
  InferRows& r = band.rows;
  const Network::Parts at = Network{hidden_, {}}.parts();
  const float* v = values_.data();
  r.width = width_, r.height = height_, r.hidden = hidden_;
  r.weights1 = v + at.weights1, r.bias1 = v + at.bias1;
  r.weights2 = v + at.weights2, r.bias2 = v + at.bias2;
  r.weights3 = v + at.weights3, r.bias3 = v + at.bias3;
  r.scales = v + at.scales;
  // `lines`: from the oldest row that is read when the newest is made. A row's border on the left
  // takes the room that the row above has on the right.
  const auto planes = [&](int count, int lines) {
    const int rows = static_cast<int>(std::bit_ceil(static_cast<unsigned>(lines)));
    const std::ptrdiff_t pitch = (width_ + kLanes - 1) / kLanes * kLanes + 2 * kLanes;
    band.memory.push_back(std::make_unique_for_overwrite<float[]>(
        static_cast<size_t>(pitch * count * rows + 2 * kLanes)));
    return Planes{band.memory.back().get() + kLanes, pitch, count, rows};
  };
  r.features = planes(kBlock * kFeatures, kPixelsLag + 2);
  r.colour = planes(kColour, 1);
  r.noise = planes(1, 1);
  r.known = planes(kColour, kPixelsLag + 1);
  r.layer1 = planes(hidden_, kLags[0] + 2);
  r.layer2 = planes(hidden_, kPixelsLag - kLags[0] + 1);
  for (size_t f = 0; f < kFilters; ++f) {
    if (f > 0) r.kernels[f] = planes(kTaps, kLags[f] - kLags[0] + 1);
    const int next = f + 1 < kFilters ? kDilations[f + 1] : 1;
    r.filtered[f] = planes(kColour, 2 * next + 1);
  }
  return band;
}

// Rows of pixels begin .. end of blocks, and of each earlier stage as many more as they need.
void FastRecovery::run_band(const InferRows& rows, int begin, int end) const {
  for (int newest = begin - kPixelsLag; newest < end + kPixelsLag; ++newest) {
    const auto has_row = [&](int lag) {
      const int y = newest - lag, more = kPixelsLag - lag;
      return y >= std::max(0, begin - more) && y < std::min(height_, end + more);
    };
    if (has_row(0)) loops_->pack_row(rows, newest);
    if (has_row(kLags[0])) loops_->first_filter_row(rows, newest - kLags[0]);
    for (int f = 1; f < kFilters; ++f) {
      const int lag = kLags[static_cast<size_t>(f)];
      if (has_row(lag)) loops_->later_filter_row(rows, newest - lag, f);
    }
    if (has_row(kPixelsLag)) loops_->pixels_row(rows, newest - kPixelsLag);
  }
}

Image FastRecovery::run(const Image& features, const Image& input, const Image& noise,
                        TaskPool& pool) {
  for (const auto& [image, channels] : {std::pair{&features, kFeatures}, {&input, 3}, {&noise, 1}})
    QRAY_CHECK(image->width() == 2 * width_ && image->height() == 2 * height_ &&
               image->channels() == channels);
  Image out(2 * width_, 2 * height_, 3);
  // A band makes kPixelsLag rows twice on either side, so there are no more than threads.
  const int count = std::clamp(height_ / (4 * kPixelsLag), 1, pool.threads());
  while (bands_.size() < static_cast<size_t>(count)) bands_.push_back(make_band());
  pool.run(static_cast<size_t>(count), [&](size_t i, int) {
    InferRows& rows = bands_[i].rows;
    rows.pixel_features = features.data().data();
    rows.pixel_colour = input.data().data();
    rows.pixel_noise = noise.data().data();
    rows.out = out.data().data();
    const int band = static_cast<int>(i);
    run_band(rows, height_ * band / count, height_ * (band + 1) / count);
  });
  return out;
}

}  // namespace qray
