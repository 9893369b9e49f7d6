#include "server/jobs/unit_loop.h"

#include <future>

#include "core/base/sha256.h"

namespace qray::server {
namespace {

constexpr double kLongWay = 0.05;  // to the database, over the time that a unit takes

}  // namespace

std::string hash_of_unit(std::span<const uint8_t> sampled) {
  return sha256(sampled.subspan(std::min(sampled.size(), UnitRenderer::kTimesBytes))).hex();
}

bool UnitLoop::start(const SharedPasses::Pass& pass) {
  if (!pass.guide.empty() && pass.guide != guide_) {
    const Result<Bytes> guide = passes_.load_guide({pass.key.job, pass.key.claim}, pass.guide);
    if (!guide.ok() || sha256(std::span<const uint8_t>(guide.value())).hex() != pass.guide)
      return false;
    SnapshotReader in(guide.value());
    guide_.clear();
    if (!renderer_.set_guide(in)) return false;
    guide_ = pass.guide;
  }
  SnapshotReader in(pass.state);
  return renderer_.start_pass(in);
}

size_t UnitLoop::run(const SharedPasses::Pass& pass, const std::function<bool()>& goes_on,
                     const std::stop_token& stop) {
  using Taken = std::optional<size_t>;
  double to_take = 0;  // seconds, of the last time
  const auto take = [&]() -> Taken {
    if (!goes_on()) return {};
    const double start = clock_.seconds();
    const Result<Taken> taken = passes_.take(pass.key, pass.patience);
    to_take = clock_.seconds() - start;
    return taken.ok() && taken.value() && *taken.value() < pass.cut.units() ? taken.value()
                                                                            : Taken();
  };
  size_t sampled = 0;
  double to_sample = 0;
  std::future<void> handed_in;
  for (Taken unit = take(); unit;) {
    // A unit that waits here is one that nobody else samples: only where the way is long.
    std::future<Taken> next;
    if (to_take > kLongWay * to_sample) next = std::async(std::launch::async, take);
    const double start = clock_.seconds();
    std::optional<Bytes> bytes =
        renderer_.sample(pass.cut.first_of(*unit), pass.cut.tiles_of(*unit), stop);
    to_sample = clock_.seconds() - start;
    if (handed_in.valid()) handed_in.get();
    if (!bytes) {
      if (next.valid()) (void)next.get();
      return sampled;
    }
    ++sampled;
    handed_in = std::async(
        std::launch::async, [this, &pass, number = *unit, sampled = *std::move(bytes)]() mutable {
          std::string hash = hash_of_unit(sampled);
          hand_in_(pass, {number, passes_.me(), std::move(hash), std::move(sampled)});
        });
    unit = next.valid() ? next.get() : take();
  }
  if (handed_in.valid()) handed_in.get();
  return sampled;
}

}  // namespace qray::server
