#include "core/recover/pyramid_memory.h"

#include "core/recover/lanes.h"

namespace qray {
namespace {

size_t size_of(const CellGrid& grid) {
  return static_cast<size_t>(grid.row) * static_cast<size_t>(grid.height + 2);
}

size_t size_of(const CellPlanes& planes) {
  return static_cast<size_t>(planes.pitch) * static_cast<size_t>(planes.height * planes.count) +
         2 * kLanes;
}

}  // namespace

float* PyramidMemory::room_for(size_t size) {
  if (size > capacity_) {
    memory_.reset();
    memory_ = std::make_unique_for_overwrite<float[]>(size);
    capacity_ = size;
  }
  return memory_.get();
}

void PyramidCells::resize(int h, int w, int c) {
  if (h == height && w == width && c == channels) return;
  resize_unset(h, w, c);
  std::fill_n(memory.room_for(size_of(*this)), size_of(*this), 0.0f);
}

void PyramidCells::resize_unset(int h, int w, int c) {
  height = h, width = w, channels = c;
  row = static_cast<std::ptrdiff_t>(w + 2) * c;
  first = memory.room_for(size_of(*this)) + row + c;
}

void PyramidPlanes::resize_unset(int h, int w, int n) {
  height = h, width = w, count = n;
  pitch = row_pitch(w);
  first = memory.room_for(size_of(*this)) + kLanes;
}

void PyramidPlanes::clear() { std::fill_n(memory.room_for(size_of(*this)), size_of(*this), 0.0f); }

std::ptrdiff_t row_pitch(int width) { return (width + kLanes - 1) / kLanes * kLanes + 2 * kLanes; }

void extend_row(float* row, int width) {
  row[-1] = row[0];
  std::fill(row + width, row + row_pitch(width) - 2 * kLanes + 1, row[width - 1]);
}

void ExpandedRows::resize(int width, int planes) {
  pitch = row_pitch(width);
  for (int i = 0; i < 2; ++i) {
    memory[i].resize(static_cast<size_t>(pitch * planes) + 2 * kLanes);
    row[i] = memory[i].data() + kLanes;
    held[i] = -1;
  }
}

void ExpandedRows::expand(const CellPlanes& from, int y, int slot, int plane) {
  for (int k = 0; k < from.count; ++k) {
    const float* in = from.at(k, y);
    float* out = row[slot] + (plane + k) * pitch;
    for (int x = 0; x < from.width; ++x) out[2 * x] = out[2 * x + 1] = in[x];
    extend_row(out, 2 * from.width);
  }
}

void ExpandedRows::add_back(const CellPlanes& to, int y, int slot) const {
  for (int k = 0; k < to.count; ++k) {
    const float* in = row[slot] + k * pitch;
    float* out = to.at(k, y);
    for (int x = 0; x < to.width; ++x) out[x] += in[2 * x] + in[2 * x + 1];
    out[0] += in[-1];
    out[to.width - 1] += in[2 * to.width];
  }
}

}  // namespace qray
