// What one path vertex is made of: random numbers, scattering, guiding, and the film at its end.
#include <benchmark/benchmark.h>

#include <array>

#include "core/bsdf/bsdf.h"
#include "core/film/film.h"
#include "core/guide/guide.h"
#include "core/image/rgb9e5.h"
#include "core/math/sampler.h"
#include "core/math/warp.h"

namespace qray::bench {
namespace {

constexpr size_t kInputs = 4096;  // a power of two: enough that no branch is learned by heart

std::vector<Vec2> random_points() {
  std::vector<Vec2> points;
  Sampler sampler(7);
  for (uint32_t i = 0; i < kInputs; ++i) {
    sampler.start(i, 0, 0);
    points.push_back(sampler.next_2d());
  }
  return points;
}

void SamplerNext2d(benchmark::State& state) {
  Sampler sampler(1);
  uint32_t i = 0;
  for (auto _ : state) {
    if (i++ % 8 == 0) sampler.start(i, 1, i);
    benchmark::DoNotOptimize(sampler.next_2d());
  }
}
BENCHMARK(SamplerNext2d);

Material material_of(int64_t kind) {
  Material material;
  material.kind = static_cast<MaterialKind>(kind);
  material.roughness.value = 0.4f;
  return material;
}
const char* const kKindNames[] = {"diffuse", "conductor", "dielectric", "plastic"};

void BsdfSampling(benchmark::State& state) {
  const auto bsdf = make_bsdf(material_of(state.range(0)));
  const ShadingPoint sp{Rgb{0.5f}, 0.4f};
  const std::vector<Vec2> points = random_points();
  const Vec3 wo = normalize({0.3f, 0.2f, 0.8f});
  size_t i = 0;
  for (auto _ : state) {
    const Vec2 u = points[++i % kInputs];
    benchmark::DoNotOptimize(bsdf->sample(bsdf->at(sp, wo), points[(i + 7) % kInputs].x, u));
  }
  state.SetLabel(kKindNames[state.range(0)]);
}
BENCHMARK(BsdfSampling)->DenseRange(0, 3);

void BsdfEvaluation(benchmark::State& state) {
  const auto bsdf = make_bsdf(material_of(state.range(0)));
  const ShadingPoint sp{Rgb{0.5f}, 0.4f};
  std::vector<Vec3> directions;
  for (Vec2 u : random_points()) directions.push_back(square_to_uniform_hemisphere(u));
  size_t i = 0;
  for (auto _ : state) {
    ++i;
    benchmark::DoNotOptimize(
        bsdf->eval(bsdf->at(sp, directions[i % kInputs]), directions[(i + 7) % kInputs]));
  }
  state.SetLabel(kKindNames[state.range(0)]);
}
BENCHMARK(BsdfEvaluation)->DenseRange(0, 3);

// A guide that has learned on the floor of a unit box, and points to ask it about.
struct TaughtGuide {
  std::unique_ptr<Guide> guide;
  std::vector<Vec3> points;
  std::vector<Vec2> u = random_points();

  TaughtGuide() {
    GuideSetup setup;
    setup.bounds = {{0, 0, 0}, {1, 1, 1}};
    guide = std::move(make_guide("huang", setup)).value();
    for (Vec2 p : u) points.push_back({p.x, 0, p.y});
    const auto delta = guide->make_delta();
    for (size_t i = 0; i < kInputs; ++i) {
      GuideVertex vertex;
      vertex.at = guide->find(points[i], {0, 1, 0});
      const Vec3 local = square_to_uniform_hemisphere(u[(i * 5 + 1) % kInputs]);
      vertex.wi = {local.x, local.z, local.y};
      vertex.pdf_w = kUniformHemispherePdfW;
      vertex.guidable = true;
      vertex.transition.emitted = local.z > 0.8f ? 10.0f : 0.1f;
      guide->record({&vertex, 1}, *delta);
    }
    guide->update(*delta);
    guide->end_pass();
  }
};

void HuangFind(benchmark::State& state) {
  const TaughtGuide taught;
  size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(taught.guide->find(taught.points[++i % kInputs], {0, 1, 0}));
}
BENCHMARK(HuangFind);

void HuangSample(benchmark::State& state) {
  const TaughtGuide taught;
  std::vector<GuidePoint> at;
  for (Vec3 p : taught.points) at.push_back(taught.guide->find(p, {0, 1, 0}));
  size_t i = 0;
  for (auto _ : state) {
    ++i;
    benchmark::DoNotOptimize(taught.guide->sample(at[i % kInputs], taught.u[(i + 9) % kInputs]));
  }
}
BENCHMARK(HuangSample);

void HuangPdf(benchmark::State& state) {
  const TaughtGuide taught;
  std::vector<GuidePoint> at;
  std::vector<Vec3> wi;
  for (size_t i = 0; i < kInputs; ++i) {
    at.push_back(taught.guide->find(taught.points[i], {0, 1, 0}));
    wi.push_back(taught.guide->sample(at.back(), taught.u[i]).wi);
  }
  size_t i = 0;
  for (auto _ : state) {
    ++i;
    benchmark::DoNotOptimize(taught.guide->pdf_w(at[i % kInputs], wi[(i + 9) % kInputs]));
  }
}
BENCHMARK(HuangPdf);

void FilmAddTile(benchmark::State& state) {
  Film film(Film::kTilePx * 8, Film::kTilePx * 8);
  const std::vector<Rgb> sums(Film::kTilePx * Film::kTilePx, Rgb{0.5f});
  int tile = 0;
  for (auto _ : state) film.add(tile++ % film.tile_count(), sums, 1);
  state.SetItemsProcessed(state.iterations() * Film::kTilePx * Film::kTilePx);
}
BENCHMARK(FilmAddTile);

void PackTile(benchmark::State& state) {
  std::vector<Rgb> pixels;
  for (Vec2 u : random_points()) pixels.push_back({u.x, 2 * u.y, 40 * u.x});
  std::array<uint32_t, kInputs> packed;
  for (auto _ : state) {
    for (size_t i = 0; i < kInputs; ++i) packed[i] = pack_rgb9e5(pixels[i]);
    benchmark::DoNotOptimize(packed);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kInputs));
}
BENCHMARK(PackTile);

}  // namespace
}  // namespace qray::bench
