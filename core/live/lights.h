// A scene's lights as someone switches them: materials that emit, then lights without an extent,
// then the environment. Pure functions.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/render/prepared_scene.h"

namespace qray {

std::vector<std::string> light_names(const Scene& scene);

// The scene with each light's emission times its factor, 0: switched off. `factors`: as many as
// names. Its hash is another unless all are 1: tables learned there say so. It shares the
// tree and the images.
Result<std::shared_ptr<const PreparedScene>> with_lights(
    const std::shared_ptr<const PreparedScene>& scene, std::span<const float> factors);

// The same light as the mix of a job with `"light_groups":"material"`. kInvalid: the scene has more
// groups than a job may have.
Result<std::string> mix_of_lights(const Scene& scene, std::span<const double> factors);

}  // namespace qray
