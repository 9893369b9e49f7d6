// What a token allows and a call needs: each scope includes those before it.
#pragma once

#include <string_view>

namespace qray::server {

enum class Scope { kOpen, kRead, kSubmit, kAdmin };

// Of a route that says nothing else: looking, sending, deleting.
constexpr Scope usual_scope(std::string_view method) {
  if (method == "GET" || method == "HEAD") return Scope::kRead;
  return method == "DELETE" ? Scope::kAdmin : Scope::kSubmit;
}

constexpr std::string_view name_of(Scope scope) {
  constexpr std::string_view kNames[] = {"open", "read", "submit", "admin"};
  return kNames[static_cast<int>(scope)];
}

}  // namespace qray::server
