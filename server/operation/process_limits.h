// What the system allows this process, and how it says no.
#pragma once

#include <cstddef>

namespace qray::server {

// A file that grows past `ulimit -f`, and a client that left, are errors where they happen; without
// this they end the process.
void survive_limits();

// So many connections at most, of those that are wanted, that the rest of the server has file
// descriptors too. Raises the limit of descriptors as far as the system allows.
size_t connections_within_limits(size_t wanted);

}  // namespace qray::server
