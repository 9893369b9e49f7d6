// What all files of this library share. Pure.
#pragma once

#include <exception>
#include <string>

#include "core/base/result.h"

namespace qray::openimageio {

// Before the names of our metadata in files.
constexpr std::string_view kPrefix = "qray:";

// Runs a body that calls OpenImageIO, whose plug-ins may throw.
template <class Body>
auto guarded(const std::string& where, Body body) -> decltype(body()) {
  try {
    return body();
  } catch (const std::exception& e) {
    return Error{ErrorCode::kInvalid, std::string("cannot process the picture: ") + e.what(),
                 where};
  }
}

}  // namespace qray::openimageio
