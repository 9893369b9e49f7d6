// From a scene's file to a scene ready for rays: load_scene (core/import), then prepare_scene
// (core/render), with one watch over both. Any thread.
#pragma once

#include <filesystem>
#include <memory>

#include "core/import/load_scene.h"
#include "core/render/prepared_scene.h"

namespace qray {

// `build_threads`: of the tree for rays. Errors are load_scene's, and kCanceled where the options'
// watch ends it. The scene has the file's warnings, and the seconds that all of it took.
Result<std::shared_ptr<const PreparedScene>> load_and_prepare_scene(
    const std::filesystem::path& path, int build_threads, const LoadOptions& options = {});

}  // namespace qray
