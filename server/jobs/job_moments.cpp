#include "server/jobs/job_moments.h"

#include "server/jobs/tile_stream.h"

namespace qray::server {
namespace {

constexpr double kPictureGrowth = 1.3, kTableGrowth = 2;  // of the samples
constexpr int64_t kMostPixels = 2048 * 2048;              // 16 MiB a picture
constexpr size_t kMostTableBytes = 8u << 20;              // of memory

}  // namespace

JobMoments::JobMoments(MomentStore& store, JobId id, const Film& film,
                       std::function<TableFile(const GuideTable&)> table_of)
    : store_(store), id_(id), film_(film), table_of_(std::move(table_of)) {
  for (const proto::Moment& moment : store.moments(id)) {
    if (moment.picture) picture_at_ = moment.samples;
    if (moment.table) table_at_ = moment.samples;
  }
}

void JobMoments::add(const RenderProgress& progress, const RenderStats& stats, const Guide* guide) {
  proto::Moment moment;
  moment.number = static_cast<uint32_t>(stats.passes.size());
  moment.samples = stats.samples_per_pixel;
  moment.seconds = stats.seconds;
  moment.noise = stats.noise;
  moment.learning = progress.learning;
  if (guide && !stats.guide_passes.empty()) {
    const GuidePass& pass = stats.guide_passes.back();
    moment.guided = pass.guided;
    moment.efficiency_gain = pass.efficiency_gain;
    moment.states = pass.states;
    moment.direction_nodes = pass.direction_nodes;
    moment.table_bytes = pass.table_bytes;
    moment.gate = stats.parts.at("guide");
  }
  const auto grown = [&](uint64_t from, double growth) {
    return static_cast<double>(moment.samples) >= growth * static_cast<double>(from);
  };
  // A run that was cut off may have got further than where this one goes on from.
  picture_at_ = std::min(picture_at_, moment.samples);
  table_at_ = std::min(table_at_, moment.samples);
  moment.picture = int64_t{film_.width()} * film_.height() <= kMostPixels &&
                   (picture_at_ == 0 || grown(picture_at_, kPictureGrowth));
  moment.table = guide && moment.learning && moment.table_bytes <= kMostTableBytes &&
                 (table_at_ == 0 || grown(table_at_, kTableGrowth));
  Bytes picture, table;
  if (moment.picture)
    picture = encode_tiles(film_.width(), film_.height(), film_.tiles_since(0, film_.tile_count()));
  if (moment.table) table = encode_table(table_of_(*guide));
  const Status added = store_.add(id_, moment, picture, table);
  failure_ = added.ok() ? "" : added.error().text();
  if (!added.ok()) return;
  if (moment.picture) picture_at_ = moment.samples;
  if (moment.table) table_at_ = moment.samples;
}

}  // namespace qray::server
