// The whole picture from what was sampled of it. Any thread; the pool's work.
#pragma once

#include "core/base/task_pool.h"
#include "core/recover/balance.h"
#include "core/recover/network.h"
#include "core/recover/recovery_input.h"

namespace qray {

// From the first pixel of each 2 x 2 block. Even sides. The network cleans these pixels as it does
// all pixels below, and what features tell makes the others of them (upsample.h). Balanced with the
// samples (balance.h). Without a network the others are interpolated, and nothing is cleaned.
Recovered recover_quarter(const Network& net, const RecoveryInput& input, TaskPool& pool);

// From all pixels: what the network makes of them, and the samples by as much as they are surer
// (shrink.h), balanced with the samples. Without a network: the samples.
Recovered recover_all(const Network& net, const RecoveryInput& input, TaskPool& pool);

}  // namespace qray
