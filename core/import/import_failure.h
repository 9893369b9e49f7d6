// How the readers of this folder give up: thrown in their depths, caught by their entry points,
// which turn it into a Result. Never leaves the folder.
#pragma once

#include <string>

#include "core/base/result.h"

namespace qray {

struct ImportFailure {
  Error error;
};

[[noreturn]] inline void fail_import(ErrorCode code, std::string message, std::string where) {
  throw ImportFailure{{code, std::move(message), std::move(where)}};
}

}  // namespace qray
