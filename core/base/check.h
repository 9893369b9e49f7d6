// QRAY_CHECK: an invariant of our own code, checked in every build. Never reachable from input.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace qray::detail {
[[noreturn]] inline void check_failed(const char* what, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: QRAY_CHECK failed: %s\n", file, line, what);
  std::abort();
}
}  // namespace qray::detail

#define QRAY_CHECK(condition) \
  ((condition) ? void(0) : ::qray::detail::check_failed(#condition, __FILE__, __LINE__))
