// Which program this is, as far as what it computes depends on its build. Any thread.
#pragma once

namespace qray {

// SHA-256, in hex, of the sources of core, proto and server, of the compiler, its options and
// Embree's version. Building the same sources again gives the same one, wherever they lie.
// Libraries of the system, which change without a build, are not in it.
const char* build_identity();

}  // namespace qray
