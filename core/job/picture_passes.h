// The layers of a finished picture: what the settings' passes and groups of lights ask for, beside
// the picture itself. docs/passes.md lists them. Any thread.
#pragma once

#include <optional>
#include <stop_token>

#include "core/film/film.h"
#include "core/image/picture_layers.h"
#include "core/render/surface_passes.h"

namespace qray {

struct LayeredPicture {
  std::vector<PictureLayer> layers;    // the picture itself first
  size_t first_group = 0, groups = 0;  // which of them are those of groups of lights
  ImageMetadata metadata;
};

// Whether Film::noise() is among what they need.
bool passes_need_noise(const RenderSettings& settings);

// `recovered`: the whole picture, where there is one. kCanceled when stopped.
Result<LayeredPicture> make_picture_passes(const PreparedScene& scene,
                                           const RenderSettings& settings, const Film& film,
                                           const std::optional<Image>& recovered,
                                           const NeighbourFrames& neighbours, TaskPool& pool,
                                           std::stop_token stop);

// "Combined_key": the layer of a group of lights. What a layer's name cannot have becomes "_".
std::string light_group_layer(const std::string& group);

}  // namespace qray
