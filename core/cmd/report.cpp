#include "core/cmd/report.h"

#include <cstdio>

namespace qray::cmd {

int report(const Error& error) {
  std::fprintf(stderr, "qray: %s\n", error.text().c_str());
  switch (error.code) {
    case ErrorCode::kCanceled:
      return kExitCanceled;
    case ErrorCode::kBusy:
      return kExitNotNow;
    default:
      return kExitBadInput;
  }
}

}  // namespace qray::cmd
