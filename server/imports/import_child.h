// Reads an upload in a process of its own (check_scene.h): what breaks there, or takes too much
// memory or time, ends that process and nothing else. Any thread.
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/base/result.h"
#include "proto/messages.h"

namespace qray::server {

struct ImportLimits {
  std::filesystem::path program = "/proc/self/exe";  // qrayd
  uint64_t memory_mib = 2048;
  uint64_t seconds = 60;
  uint64_t unpacked_bytes = uint64_t{1} << 30;
  uint64_t max_triangles = 5'000'000;
};

// The scene, or why `folder` holds none (its `error`). kCanceled: `stop`; kIo: no process could be
// started.
Result<proto::SceneReport> read_upload(const ImportLimits& limits,
                                       const std::filesystem::path& folder,
                                       const std::string& entry, std::stop_token stop);

}  // namespace qray::server
