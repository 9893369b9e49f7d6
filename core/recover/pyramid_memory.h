// Memory for the grids and planes of the pyramid, and loops over rows. One thread calls; the pool's
// work, or this thread's where there is no pool.
#pragma once

#include <algorithm>
#include <memory>

#include "core/base/task_pool.h"
#include "core/recover/pyramid_rows.h"

namespace qray {

// Made anew for another size, and zero at first.
struct PyramidCells : CellGrid {
  std::unique_ptr<float[]> memory;
  void resize(int h, int w, int c, TaskPool* pool = nullptr);
};

struct PyramidPlanes : CellPlanes {
  std::unique_ptr<float[]> memory;
  void resize(int h, int w, int n, TaskPool* pool = nullptr);
  void clear(TaskPool* pool = nullptr);

 private:
  size_t size() const;
};

std::ptrdiff_t row_pitch(int width);  // floats from plane to plane of rows of so many cells

// Calls body(y) for rows [0, height), some after another by the same thread.
template <typename Body>
void for_rows(TaskPool* pool, int height, Body&& body) {
  constexpr int kRowsAtOnce = 4;
  if (!pool) {
    for (int y = 0; y < height; ++y) body(y);
    return;
  }
  pool->run(static_cast<size_t>((height + kRowsAtOnce - 1) / kRowsAtOnce), [&](size_t i, int) {
    const int begin = static_cast<int>(i) * kRowsAtOnce;
    for (int y = begin; y < std::min(begin + kRowsAtOnce, height); ++y) body(y);
  });
}

}  // namespace qray
