#include "server/http/tokens.h"

#include <sys/random.h>

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "core/base/file.h"

namespace qray::server {
namespace {

constexpr uint64_t kMaxFileBytes = 1u << 20;
constexpr size_t kMaxNameBytes = 64;

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= kMaxNameBytes &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return std::isalnum(c) || c == '-' || c == '_' || c == '.' || c == '@';
         });
}

std::optional<Scope> scope_named(std::string_view name) {
  for (Scope scope : {Scope::kRead, Scope::kSubmit, Scope::kAdmin})
    if (name == name_of(scope)) return scope;
  return std::nullopt;
}

// The widest of "read,submit".
std::optional<Scope> scope_of(const std::string& list) {
  std::optional<Scope> widest;
  std::stringstream in(list);
  for (std::string name; std::getline(in, name, ',');) {
    const std::optional<Scope> scope = scope_named(name);
    if (!scope) return std::nullopt;
    widest = std::max(widest.value_or(Scope::kOpen), *scope);
  }
  return widest;
}

std::optional<Digest> digest_from(std::string_view hex) {
  Digest digest;
  if (hex.size() != 2 * digest.bytes.size()) return std::nullopt;
  if (hex.find_first_not_of("0123456789abcdef") != std::string_view::npos) return std::nullopt;
  const auto value = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  for (size_t i = 0; i < digest.bytes.size(); ++i)
    digest.bytes[i] = static_cast<uint8_t>(value(hex[2 * i]) << 4 | value(hex[2 * i + 1]));
  return digest;
}

bool same(const Digest& a, const Digest& b) {
  unsigned differing = 0;
  for (size_t i = 0; i < a.bytes.size(); ++i) differing |= a.bytes[i] ^ b.bytes[i];
  return differing == 0;
}

}  // namespace

Result<Tokens> Tokens::parse(std::string_view text, const std::string& file) {
  Tokens tokens;
  std::stringstream lines{std::string(text)};
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::stringstream words(line.substr(0, line.find('#')));
    std::string name, scopes, hex, more;
    if (!(words >> name)) continue;
    words >> scopes >> hex;
    const std::optional<Scope> scope = scope_of(scopes);
    const std::optional<Digest> digest = digest_from(hex);
    if (!is_name(name) || !scope || !digest || words >> more) {
      return Error{ErrorCode::kInvalid,
                   "expected NAME SCOPE SHA-256, as `qrayd token NAME SCOPE` prints it; SCOPE is "
                   "read, submit or admin",
                   file + ":" + std::to_string(number)};
    }
    tokens.entries_.push_back({name, *scope, *digest});
  }
  if (tokens.empty())
    return Error{ErrorCode::kInvalid, "no tokens: make one by `qrayd token NAME SCOPE`", file};
  return tokens;
}

Result<Tokens> Tokens::read(const std::filesystem::path& file) {
  const Result<Bytes> bytes = read_file(file, kMaxFileBytes);
  if (!bytes.ok()) return bytes.error();
  return parse({reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size()},
               file.string());
}

const Tokens::Entry* Tokens::find(const Digest& digest) const {
  const Entry* found = nullptr;
  for (const Entry& entry : entries_)
    if (same(entry.digest, digest)) found = &entry;
  return found;
}

std::string random_secret() {
  Digest random;
  QRAY_CHECK(::getrandom(random.bytes.data(), random.bytes.size(), 0) ==
             static_cast<ssize_t>(random.bytes.size()));
  return random.hex();
}

std::optional<int> token_command(int argc, const char* const* argv) {
  if (argc < 2 || std::string_view(argv[1]) != "token") return std::nullopt;
  if (argc != 4 || !is_name(argv[2]) || !scope_of(argv[3])) {
    std::fprintf(stderr, "usage: qrayd token NAME SCOPE; SCOPE is read, submit or admin\n");
    return 1;
  }
  const std::string token = random_secret();
  std::fprintf(stderr, "token, shown this once: %s\n", token.c_str());
  std::printf("%s %s %s\n", argv[2], argv[3], sha256(token).hex().c_str());
  return 0;
}

}  // namespace qray::server
