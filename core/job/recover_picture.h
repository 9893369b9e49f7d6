// From what a job sampled to its whole picture. Any thread.
#pragma once

#include <stop_token>

#include "core/film/film.h"
#include "core/recover/recover.h"
#include "core/render/prepared_scene.h"
#include "core/settings/render_settings.h"

namespace qray {

// What is known of the film's picture: its colours and noise, and the features of all pixels.
// kCanceled when stopped.
Result<RecoveryInput> recovery_input(const PreparedScene& scene, const RenderSettings& settings,
                                     const Film& film, TaskPool& pool, std::stop_token stop);

// By which pixels the settings sampled. The film's noise must have been estimated.
Result<Image> recover_picture(const PreparedScene& scene, const RenderSettings& settings,
                              const Network& network, const Film& film, TaskPool& pool,
                              std::stop_token stop);

}  // namespace qray
