// Guides of any method that have learned something, without a scene.
#pragma once

#include <memory>

#include "core/guide/guide.h"
#include "core/math/warp.h"
#include "tests/support/random.h"

namespace qray::test {

inline GuideSetup setup_of(int grid = 32) {
  GuideSetup setup;
  setup.bounds = {{-3.1f, 0.2f, 11}, {2.7f, 1.9f, 14.5f}};
  setup.brightest_light = 40;
  setup.huang.grid = grid;
  setup.adaptive.split_samples = 300;  // few, so that there are places
  return setup;
}

// Taught by events at random places of a floor, of a wall that leans, and of one whose side is the
// seed's. `spoil` may change what each event tells.
template <class Spoil = void (*)(GuideVertex&)>
std::unique_ptr<Guide> taught(
    std::string_view method, uint64_t seed, const GuideSetup& setup,
    Spoil spoil = [](GuideVertex&) {}) {
  std::unique_ptr<Guide> guide = make_guide(method, setup).value();
  Random random(seed);
  const Vec3 normals[] = {
      {0, 1, 0}, normalize(Vec3{-1, 0.4f, 0.2f}), {0, 0, seed % 2 == 0 ? 1.0f : -1.0f}};
  const Vec3 size = setup.bounds.extent();
  for (int pass = 0; pass < 4; ++pass) {
    const std::unique_ptr<GuideDelta> delta = guide->make_delta();
    for (int i = 0; i < 1000; ++i) {
      GuideVertex v;
      v.p = setup.bounds.lo +
            Vec3{size.x * random.next(), size.y * random.next(), size.z * random.next()};
      v.at = guide->find(v.p, normals[i % 3]);
      v.guidable = true;
      const Vec3 local = square_to_cosine_hemisphere(random.next_2d());
      v.wi = Frame(normals[i % 3]).to_world(local);
      v.pdf_w = v.bsdf.pdf_w = cosine_hemisphere_pdf_w(local.z);
      v.bsdf.f_cos = 0.5f * v.pdf_w;
      v.transition.emitted = local.x > 0.4f ? 30 * random.next() : 0.1f;
      v.arriving = Rgb{v.transition.emitted};
      spoil(v);
      guide->record({&v, 1}, *delta);
    }
    guide->update(*delta);
    guide->end_pass();
  }
  return guide;
}

}  // namespace qray::test
