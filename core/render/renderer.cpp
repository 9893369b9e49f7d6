#include "core/render/renderer.h"

#include "core/base/check.h"
#include "core/render/render_report.h"
#include "core/render/unit_renderer.h"

namespace qray {
namespace {

PassCost pass_cost(const PathCounters& all) {
  return {static_cast<double>(all.paths), static_cast<double>(all.rays),
          static_cast<double>(all.lookups)};
}

PassCost guided_cost(const PathCounters& all) {
  return {static_cast<double>(all.guided_paths), static_cast<double>(all.guided_rays),
          static_cast<double>(all.lookups)};
}

}  // namespace

Renderer::Renderer(const PreparedScene& scene, const RenderSettings& settings, Guide* guide,
                   Film& film, TaskPool& pool, const Clock& clock, RenderMode mode)
    : scene_(scene),
      settings_(settings),
      guide_(guide),
      film_(film),
      pool_(pool),
      clock_(clock),
      mode_(std::move(mode)),
      camera_(settings.camera.value_or(scene.scene.camera), settings.width, settings.height),
      split_(light_split(scene.scene, settings).value()),
      start_(clock.seconds()),
      workers_(scene, settings, guide, pool, split_.layers.count() > 0 ? &split_ : nullptr),
      parts_(render_parts(scene, settings, workers_.lights(), guide)),
      plan_(settings, mode_.most_pass_samples),
      pixels_(settings, mode_.in_rounds),
      updates_(guide, clock) {
  QRAY_CHECK(film.width() == settings.width && film.height() == settings.height &&
             film.layers() == split_.layers);
  if (guide) decision_.emplace(*guide, /*open=*/!settings.gate, mode_.view_lasts);
  if (guide || shows_noise()) noise_.emplace(pixels_.width(), pixels_.height());
}

// Beside what the guide needs of it.
bool Renderer::shows_noise() const {
  return settings_.estimates_noise || settings_.noise > 0 || settings_.pixels == Pixels::kByNoise ||
         mode_.measures_noise;
}

void Renderer::begin_after(const Pilot& pilot) {
  counters_before_ = pilot.counters;
  pilot_samples_ = pilot.samples;
  decision_->begin_after(pilot.gate, pass_cost(pilot.counters), guided_cost(pilot.counters));
}

size_t Renderer::units() const {
  return static_cast<size_t>(film_.tile_count()) * static_cast<size_t>(pixels_.rounds());
}

size_t Renderer::pass_units() const {
  return settings_.last_pass_tiles > 0 && plan_.passes().size() == settings_.passes.size()
             ? std::min(units(), static_cast<size_t>(settings_.last_pass_tiles))
             : units();
}

bool Renderer::start_pass(bool may_learn) {
  const int samples = plan_.start(age(), last_pass_seconds_);
  if (samples == 0) return false;
  pass_ = {true, samples, 0, elapsed()};
  if (decision_)
    decision_->start_pass(samples_, pixels_.pixels() * static_cast<uint64_t>(samples),
                          may_learn && plan_.learning(age()));
  measures_ = noise_ && (shows_noise() || pixels_.by_noise() || decision_->awake(samples_) ||
                         decision_->noise_changed());
  if (measures_) noise_->start_pass(guided(), learning());
  pixels_.start_pass(samples, noise_ ? &*noise_ : nullptr);
  return true;
}

size_t Renderer::sample(size_t most, const std::function<bool()>& enough,
                        const std::stop_token& stop, RenderObserver& observer) {
  updates_.start(pass_.next_unit);
  const double samples_a_unit = pass_.samples / static_cast<double>(units());
  size_t sampled = pass_.next_unit;
  const size_t done = pool_.run_until(
      std::min(most, units_left()),
      [&](size_t i, int worker) {
        if (!sample_one(pass_.next_unit + i, workers_[worker], stop)) return;
        std::lock_guard lock(observer_mutex_);
        observer.on_tile(progress(samples_a_unit * static_cast<double>(++sampled)));
      },
      enough);
  pass_.next_unit += done;
  return done;
}

PassView Renderer::pass_view() const {
  return {camera_, settings_.seed, pixels_,
          noise_ ? noise_->deviations() : std::span<const float>(),
          decision_ ? decision_->pixels() : GuidedPixels()};
}

// False when stopped; the unit is then left out of everything.
bool Renderer::sample_one(size_t unit, RenderWorker& worker, const std::stop_token& stop) {
  const auto tiles = static_cast<size_t>(film_.tile_count());
  TileSamples& samples = worker.samples;
  samples.start(film_.tile(static_cast<int>(unit % tiles)), film_.layers().count());
  std::unique_ptr<GuideDelta> learned;
  if (learning()) learned = updates_.empty_delta();
  if (!sample_unit(pass_view(), static_cast<int>(unit / tiles), worker.tracer, samples,
                   learned.get(), stop)) {
    worker.tracer.discard();
    return false;
  }
  add_samples(unit, samples);
  if (learned) updates_.finish(unit, std::move(learned));
  return true;
}

void Renderer::add_samples(size_t unit, TileSamples& samples) {
  const auto tiles = static_cast<size_t>(film_.tile_count());
  const int tile = static_cast<int>(unit % tiles), round = static_cast<int>(unit / tiles);
  if (measures_) add_noise(round, samples);
  // A tile counts the samples of a pass once.
  film_.add(tile, samples.sums(), static_cast<uint32_t>(round == 0 ? pass_.samples : 0),
            samples.counts(), samples.seen(), samples.layers(),
            static_cast<uint32_t>(pixels_.by_noise() ? pass_.samples : 0));
  if (mode_.on_samples) mode_.on_samples(samples);
}

void Renderer::save_pass(SnapshotWriter& out) const {
  QRAY_CHECK(pass_.running && !mode_.in_rounds && (!guide_ || guide_->share()));
  const PassView pass = pass_view();
  out(PassOf::of(scene_, settings_), pixels_,
      std::vector<float>(pass.deviations.begin(), pass.deviations.end()), pass.guide);
}

void Renderer::save_guide(SnapshotWriter& out) const { guide_->share()->save_copy(out); }

bool Renderer::add_units(std::span<const uint8_t> sampled, RenderObserver& observer) {
  ByteReader times(sampled);
  PathCounters counters, cycles;
  for (uint64_t* of : {&cycles.timed_total, &cycles.timed_tracing, &cycles.timed_guiding})
    *of = times.u64();
  SnapshotReader in(sampled.subspan(times.offset()));
  uint64_t first = 0, count = 0;
  Bytes learned;
  in(first, count, counters, learned);
  if (!in.ok() || first != pass_.next_unit || count > units_left()) return false;
  std::vector<TileSamples> samples(count);
  for (size_t i = 0; i < count; ++i)
    samples[i].load(film_.tile(static_cast<int>(first + i)), film_.layers().count(), in);
  if (!in.whole() || (learning() && !guide_->share()->add_learned(learned))) return false;
  counters += cycles;
  counters_before_ += counters;
  const double samples_a_unit = pass_.samples / static_cast<double>(units());
  for (TileSamples& tile : samples) {
    add_samples(pass_.next_unit++, tile);
    observer.on_tile(progress(samples_a_unit * static_cast<double>(pass_.next_unit)));
  }
  return true;
}

void Renderer::add_noise(int round, const TileSamples& samples) {
  pixels_.for_each_in_round(round, samples.rect(), [&](int x, int y) {
    const int column = x / pixels_.step(), row = y / pixels_.step();
    const SampleHalves<Rgb> of = samples.halves(x, y);
    noise_->add(column, row, pixels_.first(column, row), samples.count(x, y),
                {luminance(of.even), luminance(of.odd), luminance(of.earlier), luminance(of.later)},
                decision_ && decision_->pixels().learns(column, row)
                    ? std::optional(samples.saved(x, y))
                    : std::nullopt);
    return true;
  });
}

void Renderer::end_pass() {
  QRAY_CHECK(pass_.running && pass_whole());
  pass_.running = false;
  samples_ += static_cast<uint64_t>(pass_.samples);
  pixels_.end_pass();
  if (learning()) {
    const double start = clock_.seconds();
    guide_->end_pass();
    guide_pass_seconds_ += clock_.seconds() - start;
    learning_samples_ = samples_;
  }
  measure_pass();
  if (settings_.estimates_noise) film_.set_noise(noise_picture());
  last_pass_seconds_ = elapsed() - pass_.start;
}

// How noisy the pass was; by that, what the film's samples before it still count, and what is to
// become of the guide.
void Renderer::measure_pass() {
  const bool measured = measures_ && noise_->end_pass();
  if (measured && decision_ && decision_->noise_changed()) {
    if (const float weight = noise_->weight_of_earlier(); weight != 1) film_.fade(weight);
  }
  if (decision_) {
    const PathCounters sum = counters();
    decision_->judge(samples_, pass_cost(sum), guided_cost(sum), measured ? &*noise_ : nullptr);
  }
  noise_level_ = shows_noise() ? noise_->level() : 0;
}

RenderProgress Renderer::progress(double samples_in_pass) const {
  const RenderAge now = age();
  return {learning(), plan_.fraction(now, samples_in_pass), samples_, now.seconds, now.noise};
}

double Renderer::samples_per_pixel() const {
  const double in_pass = pass_.running ? static_cast<double>(pass_.next_unit) /
                                             static_cast<double>(units()) * pass_.samples
                                       : 0;
  return static_cast<double>(samples_) + in_pass;
}

PathCounters Renderer::counters() const {
  PathCounters sum = counters_before_;
  sum += workers_.counters();
  return sum;
}

double Renderer::learning_seconds() const {
  return guide_pass_seconds_ + updates_.seconds() / workers_.threads();
}

RenderStats Renderer::stats() const {
  const RenderTotals totals{samples_,     learning_samples_,  elapsed(),
                            noise_level_, workers_.threads(), counters()};
  RenderStats stats = render_stats(scene_, settings_, totals, guide_, decision());
  stats.parts = parts_;
  stats.light_groups = split_.groups;
  if (decision_ && !decision_->on()) stats.parts["guide"] = "off: it cost more than it saved";
  stats.passes = plan_.passes();
  stats.pilot_samples = pilot_samples_;
  if (pass_.running && pass_.next_unit == 0) stats.passes.pop_back();
  if (pass_.running) stats.last_pass_tiles = static_cast<int>(pass_.next_unit);
  return stats;
}

Image Renderer::noise_picture() const {
  const int step = pixels_.step();
  Image picture(settings_.width, settings_.height, kFilmNoiseChannels);
  for (int y = 0; y < pixels_.height(); ++y)
    for (int x = 0; x < pixels_.width(); ++x) {
      const auto set = [&](FilmNoise channel, float value) {
        picture.at(x * step, y * step, channel) = value;
      };
      set(kRelativeError, noise_->relative_error(x, y));
      set(kOwnError, noise_->own_error(x, y));
      set(kDeviation, noise_->deviation(x, y));
      set(kSamples, noise_->samples(x, y));
    }
  return picture;
}

void Renderer::save_state(SnapshotWriter& out) const {
  const double now = elapsed();
  out(settings_.method, static_cast<int>(settings_.pixels), settings_.seed, now, now - pass_.start,
      counters());
  exchange(*this, out);
  if (noise_) out(*noise_);
  if (decision_) out(*decision_);
  film_.save_state(out);
}

bool Renderer::load_state(SnapshotReader& in) {
  std::string method;
  int pixels = 0;
  uint64_t seed = 0;
  double elapsed_before = 0, in_pass = 0;
  in(method, pixels, seed, elapsed_before, in_pass, counters_before_);
  if (method != settings_.method || pixels != static_cast<int>(settings_.pixels) ||
      seed != settings_.seed)
    return false;
  start_ -= elapsed_before;
  pass_.start = elapsed_before - in_pass;
  exchange(*this, in);
  if (noise_) in(*noise_);
  if (decision_) in(*decision_);
  film_.load_state(in);
  if (!in.ok()) return false;
  if (settings_.estimates_noise && samples_ > 0) film_.set_noise(noise_picture());
  return true;
}

}  // namespace qray
