#include "server/api/handlers_web.h"

#include "core/base/file.h"
#include "server/http/gzip.h"
#include "server/http/http_head.h"
#include "server/http/reply.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kMaxFileBytes = 16u << 20;

struct FileType {
  const char* extension;
  const char* content_type;
  bool packed;  // by its format
};

constexpr FileType kTypes[] = {
    {".html", "text/html; charset=utf-8", false},
    {".js", "text/javascript; charset=utf-8", false},
    {".css", "text/css; charset=utf-8", false},
    {".svg", "image/svg+xml", false},
    {".png", "image/png", true},
    {".ico", "image/x-icon", false},
    {".woff2", "font/woff2", true},
    {".webmanifest", "application/manifest+json", false},
};

const FileType* type_of(const fs::path& path) {
  for (const FileType& type : kTypes) {
    if (path.extension() == type.extension) return &type;
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
    const FileType* type = type_of(it->path());
    if (!type || !it->is_regular_file(unreadable)) continue;
    files_[url + it->path().lexically_relative(folder).generic_string()] = {
        it->path(), type->content_type, type->packed};
  }
}

void WebHandlers::add_to(Router& router) {
  router.set_fallback([this](auto& req, auto& res) { return serve(req, res); });
}

bool WebHandlers::serve(const httplib::Request& req, httplib::Response& res) const {
  // Links of when the live view was a page of its own. A browser keeps what stands after the #.
  if (req.path == "/live.html") {
    res.set_redirect("/", 301);
    return true;
  }
  const auto found = files_.find(req.path);
  if (found == files_.end()) return false;
  const File& file = found->second;
  const Result<Bytes> bytes = read_file(file.path, kMaxFileBytes);
  if (!bytes.ok()) return false;
  // The tag is of the bytes as they are sent: another with gzip (RFC 9110, section 8.8.3.3).
  if (!file.packed) res.set_header("Vary", "Accept-Encoding");
  if (!file.packed && req.has_header(kAcceptsGzip)) {
    reply_tagged(req, res, gzip(bytes.value()), file.content_type);
    if (res.status != 304) res.set_header("Content-Encoding", "gzip");
  } else {
    reply_tagged(req, res, bytes.value(), file.content_type);
  }
  res.headers.erase("Cache-Control");
  res.set_header("Cache-Control", "no-cache");
  res.set_header("Content-Security-Policy",
                 "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; "
                 "base-uri 'none'; form-action 'self'; frame-ancestors 'none'");
  return true;
}

}  // namespace qray::server
