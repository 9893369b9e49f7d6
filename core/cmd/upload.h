// A scene on this machine -> a scene of the server: its files as assets, then their manifest. One
// thread.
#pragma once

#include <filesystem>

#include "core/cmd/service_client.h"

namespace qray::cmd {

// `path`: a .glb or .zip, which is sent alone; another file, sent with all that its folder holds;
// or a folder. Says what it does on stderr when it takes over a second. The scene's name.
Result<std::string> upload_scene(ServiceClient& client, const std::filesystem::path& path);

}  // namespace qray::cmd
