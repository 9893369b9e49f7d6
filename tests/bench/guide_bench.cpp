// What a guide adds to a vertex of a path, on a table that has learned a room.
#include <benchmark/benchmark.h>

#include <map>

#include "core/guide/guide.h"
#include "core/math/warp.h"

namespace qray::bench {
namespace {

constexpr size_t kEvents = 1 << 16;  // enough that neither caches nor branches know them by heart
// What a table is taught by: passes of as many events as a picture has, until it has about 3000
// states (ppg's places have more samples each: it gets fewer).
constexpr int kRounds = 16, kMinPasses = 6, kMaxPasses = 20;
constexpr size_t kStates = 3000;
const char* const kMethods[] = {"adaptive", "ppg", "huang", "dahm-keller"};

// A room of 5 x 3 x 4 m with a table in it.
constexpr Vec3 kRoom{5, 3, 4}, kTableLo{1.5f, 0.75f, 1}, kTableHi{3.2f, 0.8f, 2.5f};

struct Surface {
  Vec3 p, n;
};

// A side of a box; seen from outside or within.
Surface on_box(Vec3 lo, Vec3 hi, int side, bool within, Vec2 u) {
  const int axis = side / 2, a = (axis + 1) % 3, b = (axis + 2) % 3;
  Surface s;
  s.p[axis] = side % 2 == 0 ? hi[axis] : lo[axis];
  s.p[a] = lo[a] + (hi[a] - lo[a]) * u.x;
  s.p[b] = lo[b] + (hi[b] - lo[b]) * u.y;
  s.n[axis] = (side % 2 == 0) != within ? 1.0f : -1.0f;
  return s;
}

struct Event {
  Surface at;
  GuideVertex vertex;  // but `at`; with another direction than the guide's
  Vec2 u;
};

class Learned {
 public:
  explicit Learned(std::string_view method) {
    GuideSetup setup;
    setup.bounds = {{0, 0, 0}, kRoom};
    setup.brightest_light = 20;
    guide = std::move(make_guide(method, setup)).value();
    for (size_t i = 0; i < kEvents; ++i) {
      Event e;
      const int side = static_cast<int>(8 * random());
      const Vec2 u{random(), random()};
      e.at = side < 6 ? on_box({}, kRoom, side, true, u)
                      : on_box(kTableLo, kTableHi, side - 4, false, u);  // its top and its bottom
      e.vertex = vertex(e.at, {random(), random()});
      e.u = {random(), random()};
      events.push_back(e);
    }
    for (int pass = 0; pass < kMinPasses || (pass < kMaxPasses && guide->stats().states < kStates);
         ++pass) {
      const auto delta = guide->make_delta();
      for (int round = 0; round < kRounds; ++round) {
        for (const Event& e : events) {
          GuideVertex v = vertex(e.at, {random(), random()});
          v.at = guide->find(e.at.p, e.at.n);
          guide->record({&v, 1}, *delta);
        }
        guide->update(*delta);
      }
      guide->end_pass();
    }
  }

  // Light from a window, a strip of one wall.
  static GuideVertex vertex(const Surface& at, Vec2 u) {
    GuideVertex v;
    v.p = at.p;
    const Vec3 local = square_to_cosine_hemisphere(u);
    v.wi = Frame(at.n).to_world(local);
    v.pdf_w = v.bsdf.pdf_w = cosine_hemisphere_pdf_w(local.z);
    v.bsdf.f_cos = 0.5f * v.pdf_w;
    v.transition.albedo = 0.5f;
    v.guidable = true;
    const float seconds = v.wi.x > 0 ? (kRoom.x - v.p.x) / v.wi.x : 1e9f;
    const Vec3 hit = v.p + v.wi * seconds;
    v.transition.emitted = hit.y > 1 && hit.y < 2 && hit.z > 1.5f && hit.z < 2 ? 20.0f : 0.3f;
    v.arriving = Rgb{v.transition.emitted};
    return v;
  }

  std::unique_ptr<Guide> guide;
  std::vector<Event> events;

 private:
  float random() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<float>(state_ >> 40) * 0x1p-24f;
  }
  uint64_t state_ = 5;
};

// Benchmarks run several times, and share their tables.
Learned& learned_by(std::string_view method) {
  static std::map<std::string_view, Learned> tables;
  return tables.try_emplace(method, method).first->second;
}

// Vertices of eight paths at once, as the tracer has them: both directions are needed, that which
// the guide draws and that which the BSDF or a light gave. `vertex`: the time for one of them.
void GuidedVertex(benchmark::State& state, bool records) {
  const char* method = kMethods[state.range(0)];
  Learned& learned = learned_by(method);
  const auto delta = learned.guide->make_delta();
  const Guide& guide = *learned.guide;
  size_t next = 0;
  int64_t guided = 0;
  std::array<const Event*, kWidth> events;
  Vec3Lanes p, n, wi, drawn;
  Vec2Lanes u;
  FloatLanes pdf_w;
  GuidePoints points;
  ExpectationLanes expected;
  for (auto _ : state) {
    for (int lane = 0; lane < kWidth; ++lane) {
      const Event& e = learned.events[++next % kEvents];
      events[static_cast<size_t>(lane)] = &e;
      p.set(lane, e.at.p);
      n.set(lane, e.at.n);
      wi.set(lane, e.vertex.wi);
      u.x[lane] = e.u.x;
      u.y[lane] = e.u.y;
    }
    guide.find_each(p, n, kAllLanes, points);
    benchmark::DoNotOptimize(guide.expect_each(points, kAllLanes, expected));
    uint32_t lanes = 0;
    for (int lane = 0; lane < kWidth; ++lane)
      if (guide.mixture(points[static_cast<size_t>(lane)], {}).guide > 0) lanes |= 1u << lane;
    if (lanes) {
      guide.sample_each(points, u, lanes, drawn, pdf_w);
      benchmark::DoNotOptimize(pdf_w);
      guide.pdf_w_each(points, wi, lanes, pdf_w);
      benchmark::DoNotOptimize(pdf_w);
      guided += std::popcount(lanes);
    }
    if (!records) continue;
    for (size_t lane = 0; lane < kWidth; ++lane) {
      GuideVertex v = events[lane]->vertex;
      v.at = points[lane];
      guide.record({&v, 1}, *delta);
    }
    if (next % kEvents < kWidth) {  // deltas hold a tile's events, not a bench's
      state.PauseTiming();
      learned.guide->update(*delta);
      state.ResumeTiming();
    }
  }
  const double vertices = static_cast<double>(kWidth * state.iterations());
  using Counter = benchmark::Counter;
  state.counters["vertex"] = Counter(vertices, Counter::kIsRate | Counter::kInvert);
  state.SetLabel(
      std::string(method) + ", " + std::to_string(guide.stats().states) + " states, " +
      std::to_string(static_cast<int>(100 * static_cast<double>(guided) / vertices + 0.5)) +
      "% guided");
}
BENCHMARK_CAPTURE(GuidedVertex, sampled, false)->DenseRange(0, 3);
BENCHMARK_CAPTURE(GuidedVertex, recorded, true)->DenseRange(0, 3);

// What of it costs what; not the time that a path's own work can hide.
enum class Part { kFind, kSample, kPdf, kRecord };
void AdaptivePart(benchmark::State& state, Part part) {
  Learned& learned = learned_by("adaptive");
  const Guide& guide = *learned.guide;
  const auto delta = guide.make_delta();
  std::vector<GuidePoint> points;
  for (const Event& e : learned.events) points.push_back(guide.find(e.at.p, e.at.n));
  size_t i = 0;
  for (auto _ : state) {
    i = (i + 1) % kEvents;
    const Event& e = learned.events[i];
    if (part == Part::kFind) benchmark::DoNotOptimize(guide.find(e.at.p, e.at.n));
    if (part == Part::kSample) benchmark::DoNotOptimize(guide.sample(points[i], e.u));
    if (part == Part::kPdf) benchmark::DoNotOptimize(guide.pdf_w(points[i], e.vertex.wi));
    if (part == Part::kRecord) {
      GuideVertex v = e.vertex;
      v.at = points[i];
      guide.record({&v, 1}, *delta);
    }
  }
}
BENCHMARK_CAPTURE(AdaptivePart, find, Part::kFind);
BENCHMARK_CAPTURE(AdaptivePart, sample, Part::kSample);
BENCHMARK_CAPTURE(AdaptivePart, pdf_w, Part::kPdf);
BENCHMARK_CAPTURE(AdaptivePart, record, Part::kRecord);

}  // namespace
}  // namespace qray::bench
