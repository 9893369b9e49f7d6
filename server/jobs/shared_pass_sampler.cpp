#include "server/jobs/shared_pass_sampler.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "core/base/sha256.h"
#include "server/jobs/bits_of_machine.h"

namespace qray::server {
namespace {

// A unit takes about so long: little against a pass, for what is left to wait for at its end, and
// much against what it costs to hand one in.
constexpr double kMostUnitSeconds = 0.25, kUnitsAPass = 16;
// Seconds until a unit is given out again; the second: over a unit's time, as the last pass tells
// it. A process that slept tells far too much, so there is a bound.
constexpr double kLeastPatience = 0.5, kPatience = 4, kMostPatience = 10;
// Seconds between looks at the database: while there are units to sample here, and at a pass' end,
// where all wait for the last of them.
constexpr double kBetweenLooks = 0.1, kBetweenLastLooks = 0.01;
// Seconds without a unit, there being none to take, after which the rest is sampled here alone.
constexpr double kMostWait = 10;
constexpr std::chrono::milliseconds kLookAgain{5}, kNothingToTake{20};

Bytes written(const std::function<void(SnapshotWriter&)>& write) {
  Bytes bytes;
  SnapshotWriter out(
      [&](std::span<const uint8_t> part) { bytes.insert(bytes.end(), part.begin(), part.end()); });
  write(out);
  return bytes;
}

double samples_of(const Renderer& renderer, size_t units) {
  return renderer.samples_a_unit() * static_cast<double>(units);
}

}  // namespace

std::string SharedPassSampler::Totals::text() const {
  return std::to_string(passes) + " passes were shared: other workers (" +
         std::to_string(others.size()) + ") sampled " + std::to_string(of_others) + " of " +
         std::to_string(units) + " units, which took " + std::to_string(bytes_of_others) +
         " bytes from them and " + std::to_string(bytes_begun) + " to each of them";
}

Result<std::unique_ptr<SharedPassSampler>> SharedPassSampler::make(const Uses& uses,
                                                                   const Wanted& wanted) {
  Result<std::unique_ptr<UnitRenderer>> renderer =
      UnitRenderer::make(uses.scene, uses.settings, uses.pool);
  if (!renderer.ok()) return renderer.error();
  return std::unique_ptr<SharedPassSampler>(
      new SharedPassSampler(uses, wanted, std::move(renderer).value()));
}

SharedPassSampler::SharedPassSampler(const Uses& uses, const Wanted& wanted,
                                     std::unique_ptr<UnitRenderer> renderer)
    : uses_(uses),
      wanted_(wanted),
      bits_(bits_of_machine()),
      renderer_(std::move(renderer)),
      loop_(uses.passes, *renderer_, uses.clock,
            [this](const Pass& pass, Unit unit) {
              // The others need to know no more of it than its hash.
              (void)uses_.passes.put(pass.key, {unit.unit, unit.worker, unit.hash, {}});
              std::lock_guard lock(mutex_);
              if (under_way_ && under_way_->pass.key == pass.key) arrived(std::move(unit));
            }),
      own_thread_([this](std::stop_token stop) { sample_own(stop); }) {}

SharedPassSampler::~SharedPassSampler() {
  own_thread_.request_stop();
  end_pass();
  own_thread_.join();
  if (serial_ > 0) (void)uses_.passes.end(wanted_.job, wanted_.claim);
}

Status SharedPassSampler::sample(Renderer& renderer, const std::function<bool()>& enough,
                                 const std::stop_token& stop, RenderObserver& observer) {
  if (shared_ != renderer.pass()) {
    const double seconds = samples_of(renderer, renderer.units_left()) * seconds_a_sample_;
    const bool too_short = wanted_.least_seconds > 0 && seconds < wanted_.least_seconds;
    const Status begun = too_short ? Status() : begin(renderer);
    if (!begun.ok() && begun.error().code != ErrorCode::kIo) return begun;
    if (too_short || !begun.ok()) {
      sample_alone(renderer, enough, stop, observer);
      return {};
    }
  }
  while (renderer.units_left() > 0 && !stop.stop_requested() && !enough()) {
    if (const std::optional<Unit> unit = next_ready(renderer, stop)) {
      came_ = uses_.clock.seconds();
      // It has the hash that it was sent with, by a process whose bits are this one's.
      if (!renderer.add_units(unit->sampled, observer))
        return Error{ErrorCode::kIo, "a unit that was sampled elsewhere cannot be read", ""};
    } else if (nothing_to_take_ && uses_.clock.seconds() - came_ > kMostWait) {
      spdlog::warn("job={} a unit of its pass does not come: the rest is sampled here",
                   wanted_.job.text());
      end_pass();
      sample_alone(renderer, enough, stop, observer);
      return {};
    } else if (uses_.clock.seconds() - looked_ >=
               (nothing_to_take_ ? kBetweenLastLooks : kBetweenLooks)) {
      if (is_bad(uses_.passes.me()))
        return Error{ErrorCode::kCanceled, "this machine made two results of one unit", ""};
      const Status looked = collect();
      if (looked.ok()) continue;
      // The database is away, or was, and has lost the pass.
      end_pass();
      Status again = looked.error().code == ErrorCode::kNotFound ? begin(renderer) : looked;
      if (again.ok()) continue;
      if (again.error().code != ErrorCode::kIo) return again;
      sample_alone(renderer, enough, stop, observer);
      return {};
    }
  }
  if (renderer.units_left() == 0) end_pass();
  return {};
}

// Waits for it a little.
std::optional<SharedPassSampler::Unit> SharedPassSampler::next_ready(const Renderer& renderer,
                                                                     const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  const SharedPasses::Cut& cut = under_way_->pass.cut;
  const size_t number = (renderer.next_unit() - cut.first) / cut.tiles_a_unit;
  changed_.wait_for(lock, stop, kLookAgain, [&] { return ready_.contains(number); });
  const auto found = ready_.find(number);
  if (found == ready_.end()) return {};
  Unit unit = std::move(found->second);
  ready_.erase(found);
  ++totals_.units;
  if (unit.worker != uses_.passes.me()) {
    ++totals_.of_others;
    totals_.bytes_of_others += unit.sampled.size();
    totals_.others.insert(unit.worker);
  }
  return unit;
}

bool SharedPassSampler::is_bad(const std::string& worker) {
  std::lock_guard lock(mutex_);
  return bad_.contains(worker);
}

void SharedPassSampler::sample_alone(Renderer& renderer, const std::function<bool()>& enough,
                                     const std::stop_token& stop, RenderObserver& observer) {
  const double start = uses_.clock.seconds();
  const size_t units = renderer.sample(renderer.units_left(), enough, stop, observer);
  if (units == 0) return;
  seconds_a_sample_ = (uses_.clock.seconds() - start) / samples_of(renderer, units);
}

SharedPasses::Cut SharedPassSampler::cut_of(const Renderer& renderer, double pass_seconds) const {
  const auto threads = static_cast<size_t>(uses_.pool.threads());
  const double unit_seconds = std::min(pass_seconds / kUnitsAPass, kMostUnitSeconds);
  const double tile_seconds = pass_seconds / static_cast<double>(renderer.units_left());
  size_t tiles = 1;
  if (tile_seconds > 0) tiles = static_cast<size_t>(std::lround(unit_seconds / tile_seconds));
  // All threads of a process have something to do; the others are taken to have as many.
  tiles = std::max({tiles, size_t{1}, threads > 1 ? 2 * threads : 1});
  return {renderer.next_unit(), renderer.next_unit() + renderer.units_left(), tiles};
}

// kIo: the database is away.
Status SharedPassSampler::begin(const Renderer& renderer) {
  auto begun = std::make_shared<UnderWay>();
  Pass& pass = begun->pass;
  const double seconds = samples_of(renderer, renderer.units_left()) * seconds_a_sample_;
  pass.key = {wanted_.job, wanted_.claim, ++serial_};
  pass.cut = cut_of(renderer, seconds);
  pass.patience = std::clamp(kPatience * seconds / static_cast<double>(pass.cut.units()),
                             kLeastPatience, kMostPatience);
  pass.state = written([&](SnapshotWriter& out) { renderer.save_pass(out); });
  Bytes guide;
  if (renderer.needs_guide()) {
    guide = written([&](SnapshotWriter& out) { renderer.save_guide(out); });
    pass.guide = sha256(std::span<const uint8_t>(guide)).hex();
  }
  const bool new_guide = !pass.guide.empty() && pass.guide != guide_;
  if (Status s = uses_.passes.begin(pass, bits_, wanted_.workers, new_guide ? &guide : nullptr);
      !s.ok())
    return s;
  if (serial_ == 1) tell_of_others();
  if (new_guide) guide_ = pass.guide;
  totals_.bytes_begun += pass.state.size() + (new_guide ? guide.size() : 0);
  ++totals_.passes;
  shared_ = renderer.pass();
  came_ = uses_.clock.seconds();
  {
    std::lock_guard lock(mutex_);
    under_way_ = std::move(begun);
    own_seconds_ = own_samples_ = 0;
  }
  changed_.notify_all();
  return {};
}

void SharedPassSampler::tell_of_others() {
  const Result<int> others = uses_.passes.others_of_other_bits(bits_);
  if (!others.ok() || others.value() == 0) return;
  uses_.warn(std::to_string(others.value()) +
             (others.value() == 1 ? " worker takes" : " workers take") +
             " no part in this job's passes: of another build of qray, or on another kind of "
             "processor, they might make other bits");
}

// kNotFound: the database does not know the pass any more.
Status SharedPassSampler::collect() {
  std::vector<size_t> here;
  SharedPasses::Key key;
  {
    std::lock_guard lock(mutex_);
    key = under_way_->pass.key;
    for (const auto& [unit, origin] : known_) here.push_back(unit);
  }
  Result<SharedPasses::Collected> collected = uses_.passes.collect(key, here);
  looked_ = uses_.clock.seconds();
  if (!collected.ok()) return collected.error();
  if (!collected.value().there) {
    guide_.clear();
    return Error{ErrorCode::kNotFound, "the database has lost the pass", ""};
  }
  std::vector<size_t> of_bad;  // brought by those that were put aside, meanwhile
  {
    std::lock_guard lock(mutex_);
    for (const Unit& unit : collected.value().units)
      if (bad_.contains(unit.worker)) of_bad.push_back(unit.unit);
  }
  if (!of_bad.empty()) (void)uses_.passes.reopen(key, of_bad);
  std::lock_guard lock(mutex_);
  for (Unit& unit : collected.value().units) arrived(std::move(unit));
  for (Unit& unit : collected.value().disputed)
    if (!bad_.contains(unit.worker) && checked_.emplace(key.pass, unit.unit, unit.worker).second)
      to_check_.push_back(std::move(unit));
  changed_.notify_all();
  return {};
}

// Under the mutex.
void SharedPassSampler::arrived(Unit unit) {
  if (bad_.contains(unit.worker) || known_.contains(unit.unit) ||
      unit.unit >= under_way_->pass.cut.units())
    return;
  const std::string hash = hash_of_unit(unit.sampled);
  const bool mine = unit.worker == uses_.passes.me();
  known_[unit.unit] = {unit.worker, hash};
  if (hash == unit.hash && (mine || trusted_.contains(unit.worker))) {
    ready_.emplace(unit.unit, std::move(unit));
  } else {
    std::vector<Unit>& held = held_[unit.worker];
    if (held.empty() || hash != unit.hash) to_check_.push_back({unit.unit, unit.worker, hash, {}});
    held.push_back(std::move(unit));
  }
  changed_.notify_all();
}

void SharedPassSampler::end_pass() {
  std::unique_lock lock(mutex_);
  if (under_way_) {
    // A result that differs may have come last.
    changed_.wait(lock, [&] {
      return to_check_.empty() || !own_is_busy_ || own_thread_.get_stop_token().stop_requested();
    });
    under_way_->over.request_stop();
  }
  under_way_.reset();
  changed_.notify_all();
  changed_.wait(lock, [&] { return !own_is_busy_; });
  ready_.clear();
  known_.clear();
  held_.clear();
  to_check_.clear();
  shared_ = -1;
  if (own_samples_ > 0) seconds_a_sample_ = own_seconds_ / own_samples_;
}

void SharedPassSampler::sample_own(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return under_way_ != nullptr; })) {
    const std::shared_ptr<UnderWay> under_way = under_way_;
    own_is_busy_ = true;
    lock.unlock();
    sample_own(*under_way);
    lock.lock();
    own_is_busy_ = false;
    changed_.notify_all();
    changed_.wait(lock, stop, [&] { return under_way_ != under_way; });
  }
}

void SharedPassSampler::sample_own(UnderWay& under_way) {
  const std::stop_token over = under_way.over.get_token();
  if (!loop_.start(under_way.pass))
    return spdlog::error("job={} its pass cannot be read again", wanted_.job.text());
  const auto nothing_to_check = [&] {
    std::lock_guard lock(mutex_);
    return to_check_.empty();
  };
  while (!over.stop_requested()) {
    check_units(under_way);
    const double start = uses_.clock.seconds();
    const uint64_t before = renderer_->paths();
    nothing_to_take_ = false;
    const size_t units = loop_.run(under_way.pass, nothing_to_check, over);
    nothing_to_take_ = true;
    std::unique_lock lock(mutex_);
    if (units > 0) {
      own_seconds_ += uses_.clock.seconds() - start;
      own_samples_ += static_cast<double>(renderer_->paths() - before);
    } else {
      changed_.wait_for(lock, over, kNothingToTake, [&] { return !to_check_.empty(); });
    }
  }
}

void SharedPassSampler::check_units(UnderWay& under_way) {
  for (;;) {
    Unit unit;
    {
      std::lock_guard lock(mutex_);
      if (to_check_.empty()) return;
      unit = to_check_.back();
    }
    const SharedPasses::Cut& cut = under_way.pass.cut;
    const std::optional<Bytes> again = renderer_->sample(
        cut.first_of(unit.unit), cut.tiles_of(unit.unit), under_way.over.get_token());
    if (!again) return;
    judge(under_way, unit, hash_of_unit(*again));
  }
}

// `hash`: of the unit as this process has just sampled it.
void SharedPassSampler::judge(const UnderWay& under_way, const Unit& unit,
                              const std::string& hash) {
  const std::string& worker = unit.worker;
  std::vector<size_t> dropped;
  bool is_new = false;  // among the bad ones
  {
    std::lock_guard lock(mutex_);
    if (unit.hash == hash) {
      trust(worker);
    } else {
      is_new = bad_.insert(worker).second;
      dropped = drop(worker);
    }
    std::erase_if(to_check_, [&](const Unit& other) {
      return (other.unit == unit.unit && other.worker == worker) || bad_.contains(other.worker);
    });
  }
  changed_.notify_all();
  if (!dropped.empty()) (void)uses_.passes.reopen(under_way.pass.key, dropped);
  if (!is_new) return;
  spdlog::error("job={} worker={} its result of a unit differs from that of {}, and is put aside",
                wanted_.job.text(), worker, uses_.passes.me());
  (void)uses_.passes.put_aside(worker, "its samples of job " + wanted_.job.text() +
                                           " differ from those of " + uses_.passes.me());
  uses_.warn("the worker " + worker +
             " made other bits of the same samples than this one and was put aside; what it had "
             "brought before that stays in the picture");
}

// Under the mutex.
void SharedPassSampler::trust(const std::string& worker) {
  trusted_.insert(worker);
  for (Unit& unit : held_[worker]) ready_.emplace(unit.unit, std::move(unit));
  held_.erase(worker);
}

// Under the mutex. The units of the pass that are to be sampled again.
std::vector<size_t> SharedPassSampler::drop(const std::string& worker) {
  std::vector<size_t> dropped;
  held_.erase(worker);
  for (auto known = known_.begin(); known != known_.end();) {
    // What was added already stays.
    const bool added = trusted_.contains(worker) && !ready_.contains(known->first);
    if (known->second.worker != worker || added) {
      ++known;
      continue;
    }
    ready_.erase(known->first);
    dropped.push_back(known->first);
    known = known_.erase(known);
  }
  return dropped;
}

}  // namespace qray::server
