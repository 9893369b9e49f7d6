#include "core/recover/balance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

#include "core/base/check.h"
#include "core/recover/box_mean.h"
#include "core/recover/brightness.h"
#include "core/recover/energy.h"

namespace qray {
namespace {

constexpr int kRangePx = 3;
constexpr int kReachPx = 15;          // where light may be that none of the nearest samples met
constexpr float kDoubtfulMean = 3;    // standard errors, of so many lit pixels
constexpr float kSureChance = 0.01f;  // less: that none of them met light is no accident
constexpr int kFinestPx = 64;         // smaller squares follow noise
constexpr double kDoubt = 2;          // times the variance, which few samples hide
constexpr int kBalanceRounds = 4;     // what the range cuts off goes to pixels that have room
constexpr float kTouch = 1e-4f;       // relative: less is rounding

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

EnergyGrid finest_grid(const Image& guess, const Image& samples, int step, TaskPool& pool) {
  EnergyGrid grid = empty_grid((guess.width() + kFinestPx - 1) / kFinestPx,
                               (guess.height() + kFinestPx - 1) / kFinestPx);
  pool.run(static_cast<size_t>(grid.height), [&](size_t row, int) {
    const int cy = static_cast<int>(row);
    for (int y = cy * kFinestPx; y < std::min(guess.height(), (cy + 1) * kFinestPx); y += step)
      for (int x = 0; x < guess.width(); x += step) {
        grid.at(x / kFinestPx, cy).add(samples.rgb(x, y), guess.rgb(x, y));
      }
  });
  return grid;
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
EnergyGrid factors_of(const Image& guess, const Image& samples, int step, TaskPool& pool) {
  std::vector<EnergyGrid> levels{finest_grid(guess, samples, step, pool)};
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

// Between the cells' centres: the row of pixels times their factors.
void multiply_row(const EnergyGrid& grid, int y, Image& picture) {
  const auto place = [](int pixel, int count, int& first) {
    const float at = (static_cast<float>(pixel) + 0.5f) / kFinestPx - 0.5f;
    first = std::clamp(static_cast<int>(std::floor(at)), 0, std::max(0, count - 2));
    return std::clamp(at - static_cast<float>(first), 0.0f, 1.0f);
  };
  int y0;
  const float fy = place(y, grid.height, y0);
  const int y1 = std::min(y0 + 1, grid.height - 1);
  std::vector<Rgb> factors;
  for (int x = 0; x < grid.width; ++x)
    factors.push_back(lerp(fy, grid.at(x, y0).factor, grid.at(x, y1).factor));
  for (int x = 0; x < picture.width(); ++x) {
    int x0;
    const float fx = place(x, grid.width, x0);
    const auto left = static_cast<size_t>(x0),
               right = static_cast<size_t>(std::min(x0 + 1, grid.width - 1));
    picture.set_rgb(x, y, picture.rgb(x, y) * lerp(fx, factors[left], factors[right]));
  }
}

// What the known pixels around allow, each channel by itself.
struct Range {
  Image least, largest;
};

template <class Better>
Image extreme(const Image& samples, int step, TaskPool& pool, Better better) {
  const int width = samples.width(), height = samples.height();
  Image rows = Image::unset(width, height, 3), out = Image::unset(width, height, 3);
  const auto first_known = [step](int i) { return (std::max(0, i) + step - 1) / step * step; };
  const auto over = [&](int at, int end, auto&& value) {
    Rgb best = value(first_known(at - kRangePx));
    for (int i = first_known(at - kRangePx) + step; i < std::min(end, at + kRangePx + 1); i += step)
      for (int c = 0; c < 3; ++c) best[c] = better(best[c], value(i)[c]);
    return best;
  };
  pool.run(static_cast<size_t>(height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    if (y % step != 0) return;
    for (int x = 0; x < width; ++x)
      rows.set_rgb(x, y, over(x, width, [&](int i) { return samples.rgb(i, y); }));
  });
  pool.run(static_cast<size_t>(height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x)
      out.set_rgb(x, y, over(y, height, [&](int j) { return rows.rgb(x, j); }));
  });
  return out;
}

Rgb known_mean(const Image& samples, int step) {
  Sum3 sum{};
  double count = 0;
  for (int y = 0; y < samples.height(); y += step)
    for (int x = 0; x < samples.width(); x += step, ++count)
      for (int c = 0; c < 3; ++c)
        sum[static_cast<size_t>(c)] += static_cast<double>(samples.at(x, y, c));
  return {static_cast<float>(sum[0] / count), static_cast<float>(sum[1] / count),
          static_cast<float>(sum[2] / count)};
}

Range range_of(const Image& samples, int step, TaskPool& pool) {
  Range range{extreme(samples, step, pool, [](float a, float b) { return std::min(a, b); }),
              extreme(samples, step, pool, [](float a, float b) { return std::max(a, b); })};
  if (std::ranges::find(range.largest.data(), 0.0f) == range.largest.data().end()) return range;
  Image lit(samples.width(), samples.height(), 3);
  std::ranges::transform(samples.data(), lit.data().begin(),
                         [](float light) { return light > 0 ? 1.0f : 0.0f; });
  const Image mean = box_mean(samples, kReachPx, step, pool),
              lit_share = box_mean(lit, kReachPx, step, pool);
  const auto pixels = [step](int radius) {
    return sqr(static_cast<float>(2 * radius + 1) / static_cast<float>(step));
  };
  const float near = pixels(kRangePx), far = pixels(kReachPx);
  const Rgb whole = known_mean(samples, step);
  for (size_t i = 0; i < mean.data().size(); ++i) {
    if (range.largest.data()[i] > 0) continue;
    const float lit_near = near * lit_share.data()[i], lit_far = far * lit_share.data()[i];
    const float most = lit_far > 0 ? mean.data()[i] * (1 + kDoubtfulMean / std::sqrt(lit_far))
                                   : whole[static_cast<int>(i % 3)];
    range.largest.data()[i] = most * std::min(1.0f, std::exp(-lit_near) / kSureChance);
  }
  return range;
}

// Within the range; how many were not.
uint64_t hold(Image& picture, const Range& range, TaskPool& pool) {
  std::vector<uint64_t> held(static_cast<size_t>(picture.height()));
  pool.run(held.size(), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < picture.width(); ++x) {
      bool out = false;
      for (int c = 0; c < 3; ++c) {
        const float was = picture.at(x, y, c);
        const float now = std::clamp(was, range.least.at(x, y, c), range.largest.at(x, y, c));
        out |= std::abs(now - was) > kTouch * std::max(now, was);
        picture.at(x, y, c) = now;
      }
      held[row] += out;
    }
  });
  return std::accumulate(held.begin(), held.end(), uint64_t{0});
}

}  // namespace

Recovered balanced(Image guess, const Image& samples, int step, TaskPool& pool) {
  QRAY_CHECK(step >= 1 && guess.width() % step == 0 && guess.height() % step == 0);
  const Range range = range_of(samples, step, pool);
  const uint64_t held = hold(guess, range, pool);
  balance_by_brightness(guess, samples, step, pool);
  hold(guess, range, pool);
  for (int round = 0; round < kBalanceRounds; ++round) {
    const EnergyGrid factors = factors_of(guess, samples, step, pool);
    if (std::ranges::all_of(factors.cells, &Energy::is_as_it_should_be)) break;
    pool.run(static_cast<size_t>(guess.height()),
             [&](size_t row, int) { multiply_row(factors, static_cast<int>(row), guess); });
    hold(guess, range, pool);
  }
  return {std::move(guess), held};
}

}  // namespace qray
