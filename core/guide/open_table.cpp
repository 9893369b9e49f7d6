#include "core/guide/open_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/warp.h"

namespace qray {
namespace {

constexpr size_t kDensitiesChecked = 32;
constexpr double kDensityTolerance = 0.01;

Error at_table(const Error& error, const std::string& id) {
  const size_t rest = error.where.find_first_of(":,");  // behind "table"
  return {error.code, error.message,
          "table " + id + (rest == std::string::npos ? "" : error.where.substr(rest))};
}

Status check_same(const TableHeader& a, const TableHeader& b) {
  std::string differs;
  const auto compare = [&](const char* what, bool same) {
    if (!same) differs += (differs.empty() ? "" : ", ") + std::string(what);
  };
  compare("method", a.method == b.method);
  compare("geometry", a.geometry == b.geometry);
  compare("materials", a.materials == b.materials);
  compare("lights", a.lights == b.lights);
  if (differs.empty()) return {};
  return Error{ErrorCode::kConflict,
               "expected tables of one method and one scene; this one's differs from table " +
                   a.id + "'s in " + differs,
               "table " + b.id};
}

}  // namespace

Result<std::unique_ptr<Guide>> open_table(const TableFile& table, size_t max_bytes) {
  Result<GuideSetup> setup = setup_of_table(table.header.method, table.sections);
  if (!setup.ok()) return setup.error();
  setup.value().max_bytes = max_bytes;
  Result<std::unique_ptr<Guide>> guide = make_guide(table.header.method, setup.value());
  if (!guide.ok()) return guide.error();
  if (Status loaded = guide.value()->load(table.sections); !loaded.ok()) return loaded.error();
  return guide;
}

double density_integral(const GuideSampler& guide, const GuidePoint& point) {
  constexpr int kPoints = 1 << 15;  // of a rank-1 lattice by the golden ratio, twice
  double sum = 0;
  const auto add = [&](Vec3 wi) {
    if (!point.covers(wi)) return;
    const float pdf_w = guide.pdf_w(point, wi);
    sum += static_cast<double>(pdf_w / (pdf_w + kUniformSpherePdfW)) / kPoints;
  };
  for (int i = 0; i < kPoints; ++i) {
    const double y = (i + 0.5) * (std::numbers::phi - 1);
    const Vec2 u{(static_cast<float>(i) + 0.5f) / kPoints,
                 std::min(static_cast<float>(y - std::floor(y)), kOneMinusEpsilon)};
    add(guide.sample(point, u).wi);
    add(square_to_uniform_sphere(u));
  }
  return sum;
}

Result<TableCheck> check_table(const TableFile& table) {
  if (const std::string id = table_id(table); id != table.header.id)
    return Error{ErrorCode::kCorrupt,
                 "the id is " + table.header.id + ", but that of what it holds is " + id,
                 "table, header"};
  Result<std::unique_ptr<Guide>> guide = open_table(table, kAnyTableBytes);
  if (!guide.ok()) return guide.error();
  TableCheck check{std::move(guide).value(), 0, 1};
  const uint64_t samples_seen = check.guide->stats().samples_seen;
  if (samples_seen != table.header.samples_seen)
    return Error{ErrorCode::kCorrupt,
                 "the header tells of " + std::to_string(table.header.samples_seen) +
                     " samples seen, the table of " + std::to_string(samples_seen),
                 "table, header"};
  for (const GuidePoint& point : check.guide->known_points(kDensitiesChecked)) {
    const double integral = density_integral(*check.guide, point);
    if (!(std::abs(integral - 1) < kDensityTolerance))
      return Error{ErrorCode::kCorrupt,
                   "the density integrates to " + std::to_string(integral) + ", expected 1",
                   "table, state of key " + std::to_string(point.key)};
    ++check.densities;
    if (std::abs(integral - 1) >= std::abs(check.worst - 1)) check.worst = integral;
  }
  return check;
}

Result<MergedTable> merge_tables(std::span<const TableFile> tables, size_t max_bytes) {
  std::vector<const TableFile*> order;
  for (const TableFile& table : tables) order.push_back(&table);
  std::ranges::sort(order, {}, [](const TableFile* t) { return t->header.id; });
  if (order.size() < 2)
    return Error{ErrorCode::kInvalid, "expected at least two tables to merge", ""};
  if (order.size() > kMaxTableParents)
    return Error{ErrorCode::kTooLarge,
                 "expected at most " + std::to_string(kMaxTableParents) + " tables to merge, got " +
                     std::to_string(order.size()),
                 ""};
  TableFile merged;
  merged.header = order[0]->header;
  merged.header.version = kTableFormatVersion;
  merged.header.parents.clear();
  std::unique_ptr<Guide> sum;
  for (const TableFile* table : order) {
    const TableHeader& header = table->header;
    if (Status same = check_same(order[0]->header, header); !same.ok()) return same.error();
    if (!merged.header.parents.empty() && merged.header.parents.back() == header.id)
      return Error{ErrorCode::kInvalid, "expected different tables, got one twice",
                   "table " + header.id};
    Result<std::unique_ptr<Guide>> guide = open_table(*table, max_bytes);
    if (!guide.ok()) return at_table(guide.error(), header.id);
    if (!sum) {
      sum = std::move(guide).value();
    } else if (Status added = sum->merge(*guide.value()); !added.ok()) {
      return at_table(added.error(), header.id);
    }
    merged.header.parents.push_back(header.id);
  }
  merged.header.program = QRAY_VERSION;
  merged.header.samples_seen = sum->stats().samples_seen;
  merged.sections = sum->save();
  merged.header.id = table_id(merged);
  return MergedTable{std::move(merged), sum->stats().states};
}

}  // namespace qray
