// Factors of the light of a scene's groups: as text, and as a scene that is lit so. Pure.
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/render/light_split.h"
#include "core/render/prepared_scene.h"

namespace qray {

constexpr float kMostMixFactor = 1e6f;

// One a group, in their order: "1;0;2,1.5,1". kInvalid says what was expected.
Result<std::vector<Rgb>> parse_mix(std::string_view text, size_t groups);

// The pictures of groups, each times its factor, summed in their order.
Image mixed(std::span<const Image> groups, std::span<const Rgb> factors);

// The scene whose lights are what the settings' mix makes of them; itself without one. Its hash is
// another: tables learned there say so. It shares tree and images. kInvalid: the mix is none of the
// scene's groups.
Result<std::shared_ptr<const PreparedScene>> lit_by_mix(
    const std::shared_ptr<const PreparedScene>& scene, const RenderSettings& settings);

}  // namespace qray
