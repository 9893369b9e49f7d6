// From what a job sampled to its whole picture. Any thread.
#pragma once

#include <stop_token>

#include "core/film/film.h"
#include "core/recover/open_image_denoise.h"
#include "core/recover/recover.h"
#include "core/render/prepared_scene.h"
#include "core/settings/render_settings.h"

namespace qray {

// How a picture is made whole.
struct Recovery {
  std::string name;  // for the metadata: of included_recovery(), or an id
  Network network;
  std::shared_ptr<const OpenImageDenoise> peer{};  // instead of the network, where it is not null
};

// By the name of an included network or, of Open Image Denoise, "oidn". kInvalid: there is no such
// name; kUnsupported: not on this machine.
Result<Recovery> included_recovery(const std::string& name);

// Whether it can make a whole picture of the pixels that the settings sample.
Status check_recovery(const Recovery& recovery, const RenderSettings& settings);

// What is known of the film's picture: its colours and noise, and the features of all pixels.
// kCanceled when stopped. What the samples saw of lights directly is taken off the colours; what is
// put back is known better, from rays of its own too.
Result<RecoveryInput> recovery_input(const PreparedScene& scene, const RenderSettings& settings,
                                     const Film& film, TaskPool& pool, std::stop_token stop);

// By which pixels the settings sampled; check_recovery() must have passed. The film's noise must
// have been estimated.
Result<Recovered> recover_picture(const PreparedScene& scene, const RenderSettings& settings,
                                  const Recovery& recovery, const Film& film, TaskPool& pool,
                                  std::stop_token stop);

}  // namespace qray
