// Memory for the grids and planes of the pyramid, and loops over rows. One thread calls; the pool's
// work, or this thread's where there is no pool.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "core/base/task_pool.h"
#include "core/recover/pyramid_rows.h"

namespace qray {

// Numbers, unset, and fewer asked for later are in the same memory: its first touch takes longer
// than what follows.
class PyramidMemory {
 public:
  float* room_for(size_t size);

 private:
  std::unique_ptr<float[]> memory_;
  size_t capacity_ = 0;
};

struct PyramidCells : CellGrid {
  PyramidMemory memory;
  void resize(int h, int w, int c);        // zero wherever the size is another than it was
  void resize_unset(int h, int w, int c);  // whatever the memory has
};

struct PyramidPlanes : CellPlanes {
  PyramidMemory memory;
  void resize_unset(int h, int w, int n);
  void clear();
};

std::ptrdiff_t row_pitch(int width);  // floats from plane to plane of rows of so many cells

// A row goes on beyond its edges, as far as vectors of it are read.
void extend_row(float* row, int width);

// Two rows of a coarser level, each cell twice.
struct ExpandedRows {
  std::ptrdiff_t pitch = 0;
  std::vector<float> memory[2];
  float* row[2] = {};
  int held[2] = {-1, -1};  // which rows these are

  void resize(int width, int planes);
  void expand(const CellPlanes& from, int y, int slot, int plane);
  // Gradients of the first planes, back to the cells.
  void add_back(const CellPlanes& to, int y, int slot) const;
  // The two nearest rows of the coarser level, of `height`.
  static int nearest(int y, int i, int height) {
    return std::clamp((y + 2 * i - 1) >> 1, 0, height - 1);
  }
};

// Calls body(begin, end, worker) for bands of so many rows of [0, height).
template <typename Body>
void for_bands(TaskPool* pool, int height, int rows, Body&& body) {
  const size_t count = static_cast<size_t>((height + rows - 1) / rows);
  const auto band = [&](size_t i, int worker) {
    const int begin = static_cast<int>(i) * rows;
    body(begin, std::min(begin + rows, height), worker);
  };
  if (pool) return pool->run(count, band);
  for (size_t i = 0; i < count; ++i) band(i, 0);
}

// Calls body(y) for rows [0, height), some after another by the same thread.
template <typename Body>
void for_rows(TaskPool* pool, int height, Body&& body) {
  for_bands(pool, height, 4, [&](int begin, int end, int) {
    for (int y = begin; y < end; ++y) body(y);
  });
}

}  // namespace qray
