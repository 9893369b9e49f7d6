#include "server/policy/network_choice.h"

#include "core/recover/included_networks.h"

namespace qray::server {

std::string network_name(WeightsStore& weights, const SceneHash& scene, const std::string& wanted) {
  return wanted == "auto" ? weights.fitting(scene).value_or("default") : wanted;
}

Result<Network> load_network(WeightsStore& weights, const std::string& name) {
  if (Result<Network> included = included_network(name); included.ok()) return included;
  Result<WeightsFile> trained = weights.load(name);
  if (!trained.ok()) return trained.error();
  return std::move(trained.value().network);
}

}  // namespace qray::server
