// Files as the command's subcommands name them: scenes, pictures, tables. One thread.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/cmd/progress_line.h"
#include "core/guide/table_file.h"
#include "core/image/image.h"
#include "core/job/load_and_prepare.h"
#include "core/job/run_job.h"
#include "core/recover/weights_file.h"

namespace qray::cmd {

// `scene`: the name of an included scene ("cornell-box"), a folder with scene.json, or a file.
Result<std::filesystem::path> find_scene_path(const std::string& scene);
// `strict` and `seconds` as load_scene has them; kCanceled when stopped.
Result<std::shared_ptr<const PreparedScene>> prepare_named_scene(
    const std::string& scene, int threads, ProgressLine& line, std::stop_token stop = {},
    bool strict = false, std::optional<double> seconds = {});

// Three channels, linear: .exr, .hdr and .pfm as stored, other formats decoded from sRGB.
Result<Image> read_linear_image(const std::filesystem::path& path);

Result<TableFile> read_table(const std::filesystem::path& path);
// None for an empty path. kConflict: learned from another scene.
Result<std::optional<TableFile>> read_fitting_table(const std::string& path, const SceneHash& hash);
Result<WeightsFile> read_weights(const std::filesystem::path& path);
// "none": no recovery. "auto": the default network, as files of one's own are named. Else an
// included network's name, or a weights file.
Result<std::optional<Recovery>> find_recovery(const std::string& name);
Status write_text(const std::filesystem::path& path, std::string_view text);
// Fails before hours of work when a result of this name cannot be written at their end.
Status check_writable(const std::filesystem::path& path);
Status check_picture_name(const std::filesystem::path& path);  // .exr or .png, in a folder

int default_threads();

}  // namespace qray::cmd
