// The whole picture from what was sampled of it, by any rung of the ladder (ladder.h). Any thread;
// the pool's work.
#pragma once

#include "core/base/task_pool.h"
#include "core/recover/balance.h"
#include "core/recover/network.h"
#include "core/recover/recovery_input.h"

namespace qray {

// From the first pixel of each 2 x 2 block. Even sides. The network's pyramid cleans these pixels
// as it does all pixels below, and what features tell makes the others of them (upsample.h); where
// it has none, the network for blocks does both. Balanced with the samples (balance.h), but where
// there is no network.
Recovered recover_quarter(const Network& net, const RecoveryInput& input, TaskPool& pool);

// From all pixels: what the network's pyramid makes of them or, where it has none, the mean of what
// each of the four pixels of the blocks makes of the picture; and the samples by as much as they
// are surer (shrink.h), balanced with the samples.
Recovered recover_all(const Network& net, const RecoveryInput& input, TaskPool& pool);

}  // namespace qray
