#include "server/handlers_web.h"

#include "core/base/file.h"
#include "server/reply.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kMaxFileBytes = 16u << 20;

constexpr std::pair<const char*, const char*> kTypes[] = {
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".ico", "image/x-icon"},
    {".woff2", "font/woff2"},
    {".webmanifest", "application/manifest+json"},
};

const char* type_of(const fs::path& path) {
  for (const auto& [extension, type] : kTypes) {
    if (path.extension() == extension) return type;
  }
  return nullptr;  // not for clients: READMEs, tests' settings
}

bool is_hidden(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with('.') || name == "node_modules";
}

}  // namespace

WebHandlers::WebHandlers(const fs::path& folder, const fs::path& libraries) {
  add_files(libraries, "/lib/");
  add_files(folder, "/");
  if (const auto index = files_.find("/index.html"); index != files_.end()) {
    files_["/"] = index->second;
  }
}

void WebHandlers::add_files(const fs::path& folder, const std::string& url) {
  std::error_code ec;
  for (fs::recursive_directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec)) {
    if (is_hidden(it->path())) {
      it.disable_recursion_pending();
      continue;
    }
    std::error_code unreadable;
    const char* type = type_of(it->path());
    if (!type || !it->is_regular_file(unreadable)) continue;
    files_[url + it->path().lexically_relative(folder).generic_string()] = {it->path(), type};
  }
}

void WebHandlers::add_to(Router& router) {
  router.set_fallback([this](auto& req, auto& res) { return serve(req, res); });
}

bool WebHandlers::serve(const httplib::Request& req, httplib::Response& res) const {
  const auto found = files_.find(req.path);
  if (found == files_.end()) return false;
  const Result<Bytes> bytes = read_file(found->second.path, kMaxFileBytes);
  if (!bytes.ok()) return false;
  reply_bytes(res, bytes.value(), found->second.content_type);
  res.headers.erase("Cache-Control");
  res.set_header("Cache-Control", "no-cache");
  res.set_header("Content-Security-Policy",
                 "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; "
                 "base-uri 'none'; form-action 'self'; frame-ancestors 'none'");
  return true;
}

}  // namespace qray::server
