// Takes units of a shared pass and samples them, one after the other: what the owner of a pass does
// beside adding up, and all that the others do. While one is sampled, the one before is handed in
// and, where the way to the database is long, the next is taken.
#pragma once

#include <functional>
#include <stop_token>

#include "core/base/clock.h"
#include "core/render/unit_renderer.h"
#include "server/store/shared_passes.h"

namespace qray::server {

class UnitLoop {
 public:
  // All outlive this. `hand_in`: of a unit that was sampled, on a thread of its own.
  using HandIn = std::function<void(const SharedPasses::Pass&, SharedPasses::Unit)>;
  UnitLoop(SharedPasses& passes, UnitRenderer& renderer, const Clock& clock, HandIn hand_in)
      : passes_(passes), renderer_(renderer), clock_(clock), hand_in_(std::move(hand_in)) {}

  // Readies the renderer for the pass. False: it is not of this job, or its guide is gone.
  bool start(const SharedPasses::Pass& pass);
  // Of the pass that was started: until there is none to take, or `goes_on` says no (asked before
  // each). How many were sampled. What was sampled is handed in when this returns.
  size_t run(const SharedPasses::Pass& pass, const std::function<bool()>& goes_on,
             const std::stop_token& stop);

 private:
  SharedPasses& passes_;
  UnitRenderer& renderer_;
  const Clock& clock_;
  const HandIn hand_in_;
  std::string guide_;  // that the renderer has
};

// SHA-256 of a unit's result in hex, measured times left out.
std::string hash_of_unit(std::span<const uint8_t> sampled);

}  // namespace qray::server
