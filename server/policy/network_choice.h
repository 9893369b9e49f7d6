// The network that makes a job's or a live session's pictures whole. Any thread.
#pragma once

#include <string>

#include "core/recover/network.h"
#include "core/scene/scene_hash.h"
#include "server/store/weights_store.h"

namespace qray::server {

// The name of what is meant: that which is wanted or, of "auto", the newest of the scene's
// trainings, else the one that comes with the program.
std::string network_name(WeightsStore& weights, const SceneHash& scene, const std::string& wanted);

// An included network, or one that was trained here, by its id.
Result<Network> load_network(WeightsStore& weights, const std::string& name);

}  // namespace qray::server
