// Bearer tokens: the file that lists them by SHA-256, the look-up, and `qrayd token`, which makes
// one. Const after reading: any thread.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/base/sha256.h"
#include "server/http/scope.h"

namespace qray::server {

class Tokens {
 public:
  // Lines of "NAME SCOPE[,SCOPE] SHA-256"; '#' begins a comment. Errors name the line.
  static Result<Tokens> parse(std::string_view text, const std::string& file);
  static Result<Tokens> read(const std::filesystem::path& file);

  struct Entry {
    std::string name;
    Scope scope;
    Digest digest;
  };
  // Compares with every entry, each in a time that says nothing about it. Null: none.
  const Entry* find(std::string_view token) const { return find(sha256(token)); }
  const Entry* find(const Digest& digest) const;
  bool empty() const { return entries_.empty(); }

 private:
  std::vector<Entry> entries_;
};

// 256 random bits as 64 hex digits.
std::string random_secret();

// `qrayd token NAME SCOPE`: says a new token on stderr, and its line for the file on stdout. The
// exit code, or none when something else was asked for.
std::optional<int> token_command(int argc, const char* const* argv);

}  // namespace qray::server
