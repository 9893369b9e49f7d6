#include "core/recover/balance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

#include "core/base/check.h"
#include "core/recover/brightness.h"
#include "core/recover/energy.h"
#include "core/recover/sample_range.h"

namespace qray {
namespace {

constexpr int kFinestPx = 64;   // smaller squares follow noise
constexpr double kDoubt = 2;    // times the variance, which few samples hide
constexpr int kMostRounds = 4;  // what the range cuts off goes to pixels that have room

struct EnergyGrid {
  int width = 0, height = 0;
  std::vector<Energy> cells;
  Energy& at(int x, int y) {
    return cells[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
  const Energy& at(int x, int y) const { return const_cast<EnergyGrid*>(this)->at(x, y); }
};

EnergyGrid empty_grid(int width, int height) {
  return {width, height,
          std::vector<Energy>(static_cast<size_t>(width) * static_cast<size_t>(height))};
}

EnergyGrid halved(const EnergyGrid& fine) {
  EnergyGrid grid = empty_grid((fine.width + 1) / 2, (fine.height + 1) / 2);
  for (int y = 0; y < fine.height; ++y)
    for (int x = 0; x < fine.width; ++x) grid.at(x / 2, y / 2) += fine.at(x, y);
  return grid;
}

// The factors of a parent's cells: together they keep its energy.
void share_out(const Energy& parent, std::span<Energy*> children) {
  const auto given_to = [&](const Energy& cell) {
    Sum3 v;
    for (size_t c = 0; c < 3; ++c)
      v[c] = cell.guess[c] * static_cast<double>(parent.factor[static_cast<int>(c)]);
    return v;
  };
  const Sum3 total = given_to(parent);
  std::array<Sum3, 4> energy;
  Sum3 sum{};
  for (size_t i = 0; i < children.size(); ++i) {
    const Sum3 given = given_to(*children[i]);
    // Where no sample met the light that others beside it met, it may only be rare.
    const double part = Energy::luminance_of(given) / std::max(Energy::luminance_of(total), 1e-300);
    energy[i] =
        children[i]->wanted(given, kDoubt * std::max(children[i]->square, part * parent.square));
    for (size_t c = 0; c < 3; ++c) sum[c] += energy[i][c];
  }
  for (size_t i = 0; i < children.size(); ++i) {
    for (size_t c = 0; c < 3; ++c)
      if (sum[c] > 0) energy[i][c] *= total[c] / sum[c];
    children[i]->set_factor(energy[i], parent.factor);
  }
}

// The finest grid with its factors.
EnergyGrid with_factors(EnergyGrid finest) {
  std::vector<EnergyGrid> levels{std::move(finest)};
  while (levels.back().cells.size() > 1) levels.push_back(halved(levels.back()));
  Energy& whole = levels.back().cells[0];
  whole.set_factor(whole.wanted(whole.guess, whole.square), Rgb{1});
  for (size_t level = levels.size() - 1; level-- > 0;) {
    const EnergyGrid& parents = levels[level + 1];
    EnergyGrid& cells = levels[level];
    for (int y = 0; y < parents.height; ++y)
      for (int x = 0; x < parents.width; ++x) {
        std::array<Energy*, 4> children;
        size_t count = 0;
        for (int j = 2 * y; j < std::min(cells.height, 2 * y + 2); ++j)
          for (int i = 2 * x; i < std::min(cells.width, 2 * x + 2); ++i)
            children[count++] = &cells.at(i, j);
        share_out(parents.at(x, y), std::span(children).first(count));
      }
  }
  return std::move(levels.front());
}

// A grid's factors between the centres of its cells.
class SmoothFactors {
 public:
  SmoothFactors(const EnergyGrid& grid, int width) : height_(grid.height), width_(width) {
    for (int cy = 0; cy < grid.height; ++cy)
      for (int x = 0; x < width; ++x) {
        const Place at = place(x, grid.width);
        const Rgb factor = lerp(at.between, grid.at(at.first, cy).factor,
                                grid.at(std::min(at.first + 1, grid.width - 1), cy).factor);
        rows_.insert(rows_.end(), {factor.r, factor.g, factor.b});
      }
  }
  void multiply_row(float* picture, int y) const {
    const Place at = place(y, height_);
    const size_t count = 3 * static_cast<size_t>(width_);
    const float* above = &rows_[count * static_cast<size_t>(at.first)];
    const float* below = height_ > 1 ? above + count : above;
    for (size_t i = 0; i < count; ++i) picture[i] *= lerp(at.between, above[i], below[i]);
  }

 private:
  struct Place {
    int first;
    float between;
  };
  static Place place(int pixel, int cells) {
    const float at = (static_cast<float>(pixel) + 0.5f) / kFinestPx - 0.5f;
    const int first = std::clamp(static_cast<int>(std::floor(at)), 0, std::max(0, cells - 2));
    return {first, std::clamp(at - static_cast<float>(first), 0.0f, 1.0f)};
  }
  int height_, width_;
  std::vector<float> rows_;  // [cell's row][pixel][3]
};

// A picture and its samples, a row of cells after another.
class Bands {
 public:
  Bands(Image& picture, const Image& samples, TaskPool& pool)
      : picture_(picture),
        samples_(samples),
        step_(picture.width() / samples.width()),
        pool_(pool) {
    QRAY_CHECK(picture.width() == step_ * samples.width() &&
               picture.height() == step_ * samples.height());
  }
  int step() const { return step_; }
  int count() const { return (picture_.height() + kFinestPx - 1) / kFinestPx; }

  // change(row of the picture, y); then add(band, samples, guess) rows of pixels with samples.
  template <class Change, class Add>
  void run(Change&& change, Add&& add) {
    pool_.run(static_cast<size_t>(count()), [&](size_t band, int) {
      const int top = static_cast<int>(band) * kFinestPx;
      std::vector<float> gathered;
      for (int y = top; y < std::min(top + kFinestPx, picture_.height()); ++y) {
        float* row = &picture_.at(0, y, 0);
        change(band, row, y);
        if (y % step_ == 0)
          add(band, &samples_.data()[row_of_samples(y)], with_samples(row, gathered));
      }
    });
  }

 private:
  size_t row_of_samples(int y) const {
    return 3 * static_cast<size_t>(samples_.width()) * static_cast<size_t>(y / step_);
  }
  const float* with_samples(const float* row, std::vector<float>& gathered) const {
    if (step_ == 1) return row;
    gathered.clear();
    for (int x = 0; x < picture_.width(); x += step_)
      gathered.insert(gathered.end(), row + 3 * x, row + 3 * x + 3);
    return gathered.data();
  }
  Image& picture_;
  const Image& samples_;
  int step_;
  TaskPool& pool_;
};

}  // namespace

Recovered balanced(Image guess, const Image& samples, const Image& own_error, TaskPool& pool) {
  Bands bands(guess, samples, pool);
  const int width = guess.width(), step = bands.step(), cell = kFinestPx / step;
  const SampleRange range(samples, own_error, step, pool);
  const auto hold = [&](int y) { return range.hold_row(guess, y); };

  BrightnessClasses classes(guess, step);
  std::vector<BrightnessClasses::Sums> sums(static_cast<size_t>(bands.count()));
  std::vector<uint64_t> held(sums.size());
  bands.run([&](size_t band, float*, int y) { held[band] += hold(y); },
            [&](size_t band, const float* s, const float* g) {
              classes.add_row(s, g, samples.width(), sums[band]);
            });
  const bool differs = classes.set_factors(sums);

  const auto in_cells = [&](auto&& multiply_row) {
    EnergyGrid grid = empty_grid((width + kFinestPx - 1) / kFinestPx, bands.count());
    bands.run(
        [&](size_t, float* row, int y) {
          multiply_row(row, y);
          hold(y);
        },
        [&](size_t band, const float* s, const float* g) {
          for (int x = 0; x < samples.width(); x += cell)
            grid.at(x / cell, static_cast<int>(band))
                .add_row(s + 3 * x, g + 3 * x, std::min(cell, samples.width() - x));
        });
    return with_factors(std::move(grid));
  };
  EnergyGrid grid = in_cells([&](float* row, int) {
    if (differs) classes.multiply_row(row, width);
  });
  for (int round = 0; round < kMostRounds; ++round) {
    if (std::ranges::all_of(grid.cells, &Energy::is_as_it_should_be)) break;
    const SmoothFactors factors(grid, width);
    grid = in_cells([&](float* row, int y) { factors.multiply_row(row, y); });
  }
  return {std::move(guess), std::accumulate(held.begin(), held.end(), uint64_t{0})};
}

}  // namespace qray
