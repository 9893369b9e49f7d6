// A picture in memory: rows from the top, channels interleaved, floats, linear Rec.709 where it is
// colour. Plain data.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/math/vec.h"

namespace qray {

class Image {
 public:
  Image() = default;
  Image(int width, int height, int channels)  // all 0
      : width_(width), height_(height), channels_(channels), data_(count(), 0.0f) {}
  // Its values are whatever the memory has, so each must be written. It spares one thread the first
  // touch of large memory, which takes longer than most of what threads then do with it.
  static Image unset(int width, int height, int channels) {
    Image image;
    image.width_ = width, image.height_ = height, image.channels_ = channels;
    image.data_.resize(image.count());
    return image;
  }

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  bool empty() const { return data_.empty(); }
  std::span<float> data() { return data_; }
  std::span<const float> data() const { return data_; }

  float& at(int x, int y, int channel) { return data_[index(x, y) + static_cast<size_t>(channel)]; }
  float at(int x, int y, int channel) const {
    return data_[index(x, y) + static_cast<size_t>(channel)];
  }
  const float* pixel(int x, int y) const { return &data_[index(x, y)]; }  // its channels
  // The first three channels, or the only one three times.
  Rgb rgb(int x, int y) const {
    const float* p = pixel(x, y);
    return channels_ >= 3 ? Rgb{p[0], p[1], p[2]} : Rgb{p[0]};
  }
  void set_rgb(int x, int y, Rgb c) {
    float* p = &data_[index(x, y)];
    p[0] = c.r;
    p[1] = c.g;
    p[2] = c.b;
  }

 private:
  // Leaves elements that get no value as the memory is.
  template <class T>
  struct Unset : std::allocator<T> {
    void construct(T* p) { ::new (static_cast<void*>(p)) T; }
    void construct(T* p, T value) { std::construct_at(p, value); }
  };

  size_t count() const {
    return static_cast<size_t>(width_) * static_cast<size_t>(height_) *
           static_cast<size_t>(channels_);
  }
  size_t index(int x, int y) const {
    return (static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)) *
           static_cast<size_t>(channels_);
  }
  int width_ = 0, height_ = 0, channels_ = 0;
  std::vector<float, Unset<float>> data_;
};

}  // namespace qray
