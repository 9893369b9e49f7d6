#include "core/render/environment_light.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/math/distribution.h"
#include "core/math/warp.h"

namespace qray {
namespace {

// Tiles along either side of the picture, at most: their tables then take a quarter of a megabyte.
constexpr int kTiles = 256;
// No node of an even tile is farther from their mean than by this factor.
constexpr float kEvenWithin = 1.5f;
// The relative variance of luminance over directions from which on rays towards the brighter ones
// pay (docs/measurements/lights.md).
constexpr double kLeastVariance = 0.6;
constexpr size_t kTilesAPart = 4;  // of what a guide leaves to be searched, about

size_t guide_size(size_t tiles) {
  return std::bit_ceil(std::max<size_t>(1, tiles / kTilesAPart)) + 1;
}

}  // namespace

EnvironmentLight::EnvironmentLight(const Environment& environment)
    : environment_(environment),
      width_(environment.image.width()),
      height_(environment.image.height()) {
  if (environment.image.empty()) {
    mean_luminance_ = luminance(environment.radiance);
    return;
  }
  const size_t h = static_cast<size_t>(height_);
  row_sine_.assign(h + 2, 0);
  for (size_t j = 1; j <= h; ++j)
    row_sine_[j] = std::sin(kPi * (static_cast<float>(j) - 0.5f) / static_cast<float>(h));
  double sines = 0, sum = 0, squares = 0;
  for (int y = 0; y < height_; ++y) {
    const double sine = double{row_sine_[static_cast<size_t>(y) + 1]};
    for (int x = 0; x < width_; ++x) {
      const double l = double{luminance(environment.image.rgb(x, y))};
      sines += sine, sum += sine * l, squares += sine * l * l;
    }
  }
  left_out_ = static_cast<float>(sum / sines);
  mean_luminance_ = luminance(environment.radiance) * left_out_;
  if (!(sines * squares >= (1 + kLeastVariance) * sum * sum) || !(sum > 0)) return;
  while (std::max(width_, height_ + 1) >> shift_ > kTiles) ++shift_;
  const int side = 1 << shift_;
  tile_columns_ = (width_ + side - 1) >> shift_;
  tile_rows_ = (height_ + side) >> shift_;
  const size_t columns = static_cast<size_t>(tile_columns_),
               tile_rows = static_cast<size_t>(tile_rows_);
  tile_cdf_.resize(tile_rows * (columns + 1));
  guide_size_ = guide_size(columns);
  tile_guide_.resize(tile_rows * guide_size_);
  block_of_tile_.assign(tile_rows * columns, kEven);
  std::vector<float> weights(columns), rows(tile_rows);
  for (int j = 0; j < tile_rows_; ++j) {
    for (int i = 0; i < tile_columns_; ++i) weights[static_cast<size_t>(i)] = add_tile(tile(i, j));
    const size_t row = static_cast<size_t>(j);
    const auto cdf = std::span(tile_cdf_).subspan(row * (columns + 1), columns + 1);
    rows[row] = static_cast<float>(fill_cdf(weights, cdf));
    fill_guide(cdf, std::span(tile_guide_).subspan(row * guide_size_, guide_size_));
  }
  row_cdf_.resize(tile_rows + 1);
  fill_cdf(rows, row_cdf_);
  row_guide_.resize(guide_size(tile_rows));
  fill_guide(row_cdf_, row_guide_);
  fill_cells();
  fill_centers();
  blocks_.shrink_to_fit();
}

inline EnvironmentLight::Corners EnvironmentLight::corners(int column, int row) const {
  const Image& image = environment_.image;
  const int x0 = column, x1 = x0 + 1 == width_ ? 0 : x0 + 1;
  const int y0 = std::max(row - 1, 0),
            y1 = std::min(row, height_ - 1);  // at the poles the sine is 0
  Corners c{image.rgb(x0, y0), image.rgb(x1, y0), image.rgb(x0, y1), image.rgb(x1, y1), 0, 0, 0, 0};
  c.n00 = node(c.c00, row), c.n10 = node(c.c10, row);
  c.n01 = node(c.c01, row + 1), c.n11 = node(c.c11, row + 1);
  return c;
}

inline EnvironmentLight::Tile EnvironmentLight::tile(int tile_column, int tile_row) const {
  const int column = tile_column << shift_, row = tile_row << shift_, side = 1 << shift_;
  const size_t index = static_cast<size_t>(tile_row) * static_cast<size_t>(tile_columns_) +
                       static_cast<size_t>(tile_column);
  return {column, std::min(column + side, width_),      row, std::min(row + side, height_ + 1),
          index,  index + static_cast<size_t>(tile_row)};
}

float EnvironmentLight::add_tile(const Tile& t) {
  const size_t side = size_t{1} << shift_;
  std::vector<float> sums(side * side);
  double sum = 0;
  float least = std::numeric_limits<float>::infinity(), most = 0;
  for (int row = t.row; row < t.row_end; ++row) {
    float* out = &sums[static_cast<size_t>(row - t.row) * side];
    const double height = row == 0 || row == height_ ? 0.5 : 1;
    for (int column = t.column; column < t.column_end; ++column) {
      const Corners c = corners(column, row);
      sum += height * 0.25 * double{(c.n00 + c.n10) + (c.n01 + c.n11)};
      least = std::min({least, c.n00, c.n10, c.n01, c.n11});
      most = std::max({most, c.n00, c.n10, c.n01, c.n11});
      *out++ = static_cast<float>(sum);
    }
    while (out < &sums[static_cast<size_t>(row - t.row) * side] + side)
      *out++ = static_cast<float>(sum);
  }
  const float weight = static_cast<float>(sum), mean = weight / static_cast<float>(t.cells());
  const bool even = t.row > 0 && t.row_end <= height_ && most <= kEvenWithin * mean &&
                    least * kEvenWithin >= mean;
  if (even || !(weight > 0)) return weight;
  block_of_tile_[t.index] = static_cast<uint32_t>(blocks_.size() / sums.size());
  for (const float s : sums) blocks_.push_back(s / weight);
  return weight;
}

EnvironmentLight::Place EnvironmentLight::place(Vec3 wi) const {
  const Vec3 d = environment_.to_world.transposed() * wi;
  const float sin_theta = std::sqrt(d.x * d.x + d.z * d.z);
  const float u = 0.5f + angle_of(d.x, -d.z) * (0.5f * kInvPi);
  const float x = u * static_cast<float>(width_) - 0.5f;
  const float column = std::floor(x);
  Place at{(static_cast<int>(column) + width_) % width_, 0, {x - column, 0}, sin_theta};
  // From the nearer pole, or rounding would take what is close to the other one.
  const float from_pole = angle_of(sin_theta, std::abs(d.y)) * kInvPi * static_cast<float>(height_);
  if (from_pole < 0.5f) {  // half as high as other cells
    at.row = d.y > 0 ? 0 : height_;
    at.offset.y = d.y > 0 ? 2 * from_pole : 1 - 2 * from_pole;
    return at;
  }
  const float rows = (d.y > 0 ? from_pole : static_cast<float>(height_) - from_pole) + 0.5f;
  at.row = std::clamp(static_cast<int>(rows), 0, height_);
  at.offset.y = std::min(rows - static_cast<float>(at.row), 1.0f);
  return at;
}

// `offset`: in the tile, of its weight above and to the left.
inline EnvironmentLight::Place EnvironmentLight::place_in(const Tile& t, Vec2 offset) const {
  const auto whole = [](float x, int end) { return std::min(static_cast<int>(x), end - 1); };
  const int columns = t.column_end - t.column, rows = t.row_end - t.row;
  const uint32_t block = block_of_tile_[t.index];
  if (block == kEven) {
    const float x = offset.x * static_cast<float>(columns), y = offset.y * static_cast<float>(rows);
    const int column = whole(x, columns), row = whole(y, rows);
    return {t.column + column,
            t.row + row,
            {x - static_cast<float>(column), y - static_cast<float>(row)},
            0};
  }
  // The row, then the cell in it.
  const size_t side = size_t{1} << shift_;
  const float* sums = &blocks_[block * side * side];
  size_t row = 0;
  for (size_t r = 0; r + 1 < static_cast<size_t>(rows); ++r)
    row += sums[r * side + side - 1] <= offset.y ? 1 : 0;
  const float* in_row = sums + row * side;
  const float begin = row > 0 ? in_row[-1] : 0, end = in_row[side - 1];
  const float at = begin + offset.x * (end - begin);
  size_t column = 0;
  for (size_t c = 0; c + 1 < static_cast<size_t>(columns); ++c) column += in_row[c] <= at ? 1 : 0;
  const float left = column > 0 ? in_row[column - 1] : begin, right = in_row[column];
  const auto share = [](float x, float lo, float hi) {
    return hi > lo ? std::clamp((x - lo) / (hi - lo), 0.0f, kOneMinusEpsilon) : 0.5f;
  };
  return {t.column + static_cast<int>(column),
          t.row + static_cast<int>(row),
          {share(at, left, right), share(offset.y, begin, end)},
          0};
}

EnvironmentLight::Drawn EnvironmentLight::draw(Vec2 u, Vec3 normal) const {
  const CdfPick row = pick_by_cdf(row_cdf_, row_guide_, u.y);
  const size_t columns = static_cast<size_t>(tile_columns_) + 1, r = static_cast<size_t>(row.index);
  const CdfPick column =
      pick_by_cdf(std::span(tile_cdf_).subspan(r * columns, columns),
                  std::span(tile_guide_).subspan(r * guide_size_, guide_size_), u.x);
  return draw_in_tile(row, column, normal);
}

EnvironmentLight::Drawn EnvironmentLight::draw_in_tile(CdfPick row, CdfPick column,
                                                       Vec3 normal) const {
  if (is_behind(column.index, row.index, normal)) return {};
  const Drawn drawn{column.index, row.index, {column.offset, row.offset}};
  __builtin_prefetch(&block_of_tile_[tile(drawn.column, drawn.row).index]);
  return drawn;
}

void EnvironmentLight::prefetch_tile(const Drawn& drawn) const {
  const uint32_t block = block_of_tile_[tile(drawn.column, drawn.row).index];
  if (block == kEven) return;
  constexpr size_t kLine = 64 / sizeof(float);
  const size_t count = size_t{1} << 2 * shift_;
  for (size_t i = 0; i < count; i += kLine) __builtin_prefetch(&blocks_[block * count + i]);
}

void EnvironmentLight::prefetch_picture(const Drawn& drawn) const {
  const Place at = place_in(tile(drawn.column, drawn.row), drawn.offset);
  const Image& image = environment_.image;
  for (const int y : {std::max(at.row - 1, 0), std::min(at.row, height_ - 1)})
    __builtin_prefetch(image.pixel(at.column, y));
}

EnvironmentLight::Sample EnvironmentLight::sample_of(const Drawn& drawn) const {
  if (!drawn.exists()) return {};
  const Tile t = tile(drawn.column, drawn.row);
  Place at = place_in(t, drawn.offset);
  const Corners c = corners(at.column, at.row);
  if (block_of_tile_[t.index] != kEven) {
    const float y = sample_linear(at.offset.y, c.n00 + c.n10, c.n01 + c.n11);
    at.offset = {sample_linear(at.offset.x, lerp(y, c.n00, c.n01), lerp(y, c.n10, c.n11)), y};
  }
  const float y = at.offset.y;

  const bool south = at.row == height_;
  const float from_pole = south         ? 0.5f * (1 - y)
                          : at.row == 0 ? 0.5f * y
                                        : static_cast<float>(at.row) - 0.5f + y;
  const float theta = kPi * from_pole / static_cast<float>(height_);
  const float phi =
      2 * kPi *
      ((static_cast<float>(at.column) + 0.5f + at.offset.x) / static_cast<float>(width_) - 0.5f);
  at.sin_theta = std::sin(theta);
  const Vec3 d{at.sin_theta * std::sin(phi), (south ? -1 : 1) * std::cos(theta),
               -at.sin_theta * std::cos(phi)};
  return {environment_.to_world * d, pdf_w(at, t, c) / drawn.of_cell, radiance(at, c)};
}

void EnvironmentLight::fill_centers() {
  const float side = static_cast<float>(1 << shift_);
  const float theta = kPi / static_cast<float>(height_), phi = 2 * kPi / static_cast<float>(width_);
  const auto centers = [&](int count, float step, float first) {
    std::vector<Vec2> out;
    for (int i = 0; i < count; ++i) {
      const float angle = first + step * side * (static_cast<float>(i) + 0.5f);
      out.push_back({std::sin(angle), std::cos(angle)});
    }
    return out;
  };
  row_centers_ = centers(tile_rows_, theta, -0.5f * theta);
  column_centers_ = centers(tile_columns_, phi, 0.5f * phi - kPi);
  const float reach = 0.5f * side * (theta + phi);
  if (reach < kPi / 2) tile_reach_ = std::sin(reach) + 1e-4f;
}

// Half of what is drawn lies behind a surface that is lit by half of the sky. It is left before the
// picture is read, which waits for memory.
inline bool EnvironmentLight::is_behind(int tile_column, int tile_row, Vec3 normal) const {
  const Vec2 theta = row_centers_[static_cast<size_t>(tile_row)],
             phi = column_centers_[static_cast<size_t>(tile_column)];
  const Vec3 center{theta.x * phi.x, theta.y, -theta.x * phi.y};
  return dot(environment_.to_world * center, normal) < -tile_reach_;
}

EnvironmentLight::Arriving EnvironmentLight::at(Vec3 wi) const {
  if (even()) return {radiance(wi), 0};
  const Place at = place(wi);
  const Corners c = corners(at.column, at.row);
  return {radiance(at, c), pdf_w(at, tile(at.column >> shift_, at.row >> shift_), c)};
}

Rgb EnvironmentLight::radiance(Vec3 wi) const {
  if (width_ == 0) return environment_.radiance;
  const Place at = place(wi);
  return radiance(at, corners(at.column, at.row));
}

inline float EnvironmentLight::cell_probability(const Tile& t, const Place& at) const {
  const size_t side = size_t{1} << shift_;
  const float* sums = &blocks_[block_of_tile_[t.index] * side * side];
  const size_t i =
      static_cast<size_t>(at.row - t.row) * side + static_cast<size_t>(at.column - t.column);
  return sums[i] - (i > 0 ? sums[i - 1] : 0);
}

// Probabilities are read from the tables that sample() walks: what rounding does to the one it does
// to the other.
inline float EnvironmentLight::pdf_w(const Place& at, const Tile& t, const Corners& c) const {
  if (!(at.sin_theta > 0)) return 0;
  const size_t row = t.index / static_cast<size_t>(tile_columns_);
  float probability =
      (row_cdf_[row + 1] - row_cdf_[row]) * (tile_cdf_[t.in_cdf + 1] - tile_cdf_[t.in_cdf]);
  float cells = static_cast<float>(t.cells());
  if (block_of_tile_[t.index] != kEven) {
    const float mean = 0.25f * (c.n00 + c.n10 + c.n01 + c.n11);
    if (!(mean > 0)) return 0;
    const float value =
        lerp(at.offset.y, lerp(at.offset.x, c.n00, c.n10), lerp(at.offset.x, c.n01, c.n11));
    probability *= cell_probability(t, at) * (value / mean);
    cells = at.row == 0 || at.row == height_ ? 0.5f : 1.0f;
  }
  const float area = cells / (static_cast<float>(width_) * static_cast<float>(height_));
  return probability / area / (2 * kPi * kPi * at.sin_theta);
}

inline Rgb EnvironmentLight::radiance(const Place& at, const Corners& c) const {
  return environment_.radiance *
         lerp(at.offset.y, lerp(at.offset.x, c.c00, c.c10), lerp(at.offset.x, c.c01, c.c11));
}

EnvironmentLight::CellTiles EnvironmentLight::tiles_of(uint32_t cell) const {
  const auto part = [](uint32_t i, uint32_t of, int whole) {
    return static_cast<int>(i * static_cast<uint32_t>(whole) / of);
  };
  const uint32_t row = cell / kCellColumns, column = cell % kCellColumns;
  return {part(row, kCellRows, tile_rows_), part(row + 1, kCellRows, tile_rows_),
          part(column, kCellColumns, tile_columns_), part(column + 1, kCellColumns, tile_columns_)};
}

uint32_t EnvironmentLight::cell_of(int tile_column, int tile_row) const {
  // The last whose first tile is not behind it.
  const auto part = [](int i, uint32_t of, int whole) {
    return ((static_cast<uint32_t>(i) + 1) * of - 1) / static_cast<uint32_t>(whole);
  };
  return part(tile_row, kCellRows, tile_rows_) * kCellColumns +
         part(tile_column, kCellColumns, tile_columns_);
}

// The chances of each cell's rows of tiles, summed up.
void EnvironmentLight::fill_cells() {
  const size_t columns = static_cast<size_t>(tile_columns_) + 1;
  for (uint32_t i = 0; i < kCells; ++i) {
    const CellTiles cell = tiles_of(i);
    double sum = 0;
    for (int j = cell.row; j < cell.row_end; ++j) {
      const size_t row = static_cast<size_t>(j);
      sum += double{row_cdf_[row + 1] - row_cdf_[row]} *
             double{tile_cdf_[row * columns + static_cast<size_t>(cell.column_end)] -
                    tile_cdf_[row * columns + static_cast<size_t>(cell.column)]};
      cell_rows_.push_back(static_cast<float>(sum));
    }
    cell_begin_.push_back(static_cast<uint32_t>(cell_rows_.size()));
  }
}

float EnvironmentLight::cell_chance(uint32_t cell) const {
  return cell_begin_[cell] < cell_begin_[cell + 1] ? cell_rows_[cell_begin_[cell + 1] - 1] : 0;
}

EnvironmentLight::Drawn EnvironmentLight::draw_in(uint32_t index, Vec2 u, Vec3 normal) const {
  const float chance = cell_chance(index);
  if (!(chance > 0)) return {};
  const CellTiles cell = tiles_of(index);
  const auto rows = std::span(cell_rows_)
                        .subspan(cell_begin_[index], static_cast<size_t>(cell.row_end - cell.row));
  const float at = std::min(u.y * chance, std::nextafter(chance, 0.0f));
  const auto found = std::ranges::upper_bound(rows, at);
  const float below = found == rows.begin() ? 0 : found[-1];
  const CdfPick row{cell.row + static_cast<int>(found - rows.begin()),
                    std::clamp((at - below) / (*found - below), 0.0f, kOneMinusEpsilon)};
  const size_t columns = static_cast<size_t>(tile_columns_) + 1, r = static_cast<size_t>(row.index);
  const auto cdf = std::span(tile_cdf_).subspan(r * columns, columns);
  const float from = cdf[static_cast<size_t>(cell.column)],
              to = cdf[static_cast<size_t>(cell.column_end)];
  const CdfPick column =
      pick_by_cdf(cdf, std::span(tile_guide_).subspan(r * guide_size_, guide_size_),
                  std::clamp(from + u.x * (to - from), from, std::nextafter(to, from)));
  Drawn drawn = draw_in_tile(row, column, normal);
  drawn.of_cell = chance;
  return drawn;
}

EnvironmentLight::InCell EnvironmentLight::in_cell(Vec3 wi) const {
  const Place at = place(wi);
  const Corners c = corners(at.column, at.row);
  const int column = at.column >> shift_, row = at.row >> shift_;
  const uint32_t cell = cell_of(column, row);
  const float chance = cell_chance(cell);
  return {radiance(at, c), chance > 0 ? pdf_w(at, tile(column, row), c) / chance : 0, cell};
}

float EnvironmentLight::brightest() const {
  float texel = width_ == 0 ? 1.0f : 0.0f;
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x)
      texel = std::max(texel, luminance(environment_.image.rgb(x, y)));
  return texel * luminance(environment_.radiance);
}

}  // namespace qray
