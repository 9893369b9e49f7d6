// Result<T>: a value, or an Error that names what is wrong, where, and what was expected.
// For the caller's faults (request, scene, file); our own bugs are QRAY_CHECK. Any thread.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "core/base/check.h"

namespace qray {

enum class ErrorCode {
  kInvalid,      // a value is wrong: type, range, syntax
  kNotFound,     // a file, scene, table or job is not there
  kUnsupported,  // understood, and not something this program does
  kTooLarge,     // over a limit
  kCorrupt,      // checksum, order or size in a binary file is wrong
  kConflict,     // not possible in the present state
  kBusy,         // a bounded queue is full; try again later
  kCanceled,     // a stop was asked for
  kIo,           // the operating system said no
};

struct Error {
  ErrorCode code = ErrorCode::kInvalid;
  std::string message;  // what is wrong, what was expected
  std::string where;    // "scene.json:/materials/3/ior", "room.obj:812", a path; may be empty

  std::string text() const { return where.empty() ? message : where + ": " + message; }
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }
  const T& value() const& {
    QRAY_CHECK(ok());
    return std::get<0>(state_);
  }
  T& value() & {
    QRAY_CHECK(ok());
    return std::get<0>(state_);
  }
  T&& value() && {
    QRAY_CHECK(ok());
    return std::get<0>(std::move(state_));
  }
  const Error& error() const {
    QRAY_CHECK(!ok());
    return std::get<1>(state_);
  }

 private:
  std::variant<T, Error> state_;
};

// A Result without a value.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)) {}

  bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  const Error& error() const {
    QRAY_CHECK(!ok());
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace qray
