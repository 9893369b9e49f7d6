// A trained network on disk: proto/weights_file.md is the format. This file owns bytes; where files
// live and which one a job gets is the server's and the command's. Any thread.
#pragma once

#include <string>
#include <vector>

#include "core/base/byte_io.h"
#include "core/base/result.h"
#include "core/base/sha256.h"
#include "core/recover/network.h"

namespace qray {

constexpr uint32_t kWeightsFormatVersion = 4;
// Counts up when what a feature or an input means, or the network's shape, changes.
constexpr uint32_t kFeatureLayout = 2;

constexpr uint64_t kMaxWeightsBytes = 1 << 20;

struct WeightsFile {
  std::string id;                      // 32 hex digits: weights_id()
  std::string program;                 // version that wrote it
  std::string scene;                   // name of what it learned from, for people
  Digest geometry, materials, lights;  // of that scene; zeros where there were several
  uint32_t steps = 0;                  // of training
  std::vector<float> held_out;         // relMSE of each view that was kept apart
  Network network;
};

Bytes encode_weights(const WeightsFile& weights);
// A hash of what it holds but its id, so the same training makes the same file.
std::string weights_id(WeightsFile weights);
// Checks magic, version, layout, sizes (before allocating), checksum, and that all values are
// finite. Errors are kCorrupt, or kUnsupported for another version or layout, with the byte offset.
Result<WeightsFile> decode_weights(std::span<const uint8_t> bytes);

}  // namespace qray
