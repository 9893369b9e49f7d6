#include "core/recover/pyramid_memory.h"

#include <algorithm>
#include <span>

#include "core/recover/lanes.h"

namespace qray {
namespace {

// The first touch of memory takes longer than what follows, so all threads share it.
void fill_with_zeros(std::span<float> memory, TaskPool* pool) {
  constexpr size_t kPart = 1 << 14;
  for_rows(pool, static_cast<int>((memory.size() + kPart - 1) / kPart), [&](int part) {
    const size_t first = static_cast<size_t>(part) * kPart;
    std::ranges::fill(memory.subspan(first, std::min(kPart, memory.size() - first)), 0.0f);
  });
}

}  // namespace

std::ptrdiff_t row_pitch(int width) { return (width + kLanes - 1) / kLanes * kLanes + 2 * kLanes; }

void PyramidCells::resize(int h, int w, int c, TaskPool* pool) {
  if (h == height && w == width && c == channels) return;
  height = h, width = w, channels = c;
  row = static_cast<std::ptrdiff_t>(w + 2) * c;
  const size_t size = static_cast<size_t>(row) * static_cast<size_t>(h + 2);
  memory = std::make_unique_for_overwrite<float[]>(size);
  fill_with_zeros({memory.get(), size}, pool);
  first = memory.get() + row + c;
}

void PyramidPlanes::resize(int h, int w, int n, TaskPool* pool) {
  if (h == height && w == width && n == count) return;
  height = h, width = w, count = n;
  pitch = row_pitch(w);
  memory = std::make_unique_for_overwrite<float[]>(size());
  clear(pool);
  first = memory.get() + kLanes;
}

void PyramidPlanes::clear(TaskPool* pool) { fill_with_zeros({memory.get(), size()}, pool); }

size_t PyramidPlanes::size() const {
  return static_cast<size_t>(pitch) * static_cast<size_t>(height * count) + 2 * kLanes;
}

}  // namespace qray
