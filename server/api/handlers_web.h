// The page: files of two folders, whose names are read once at the start. A client's path is only
// ever compared with those names, never opened. Any thread.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "server/http/router.h"

namespace qray::server {

class WebHandlers {
 public:
  // `libraries`: others' files, under /lib/; may be absent.
  WebHandlers(const std::filesystem::path& folder, const std::filesystem::path& libraries);
  void add_to(Router& router);
  size_t file_count() const { return files_.size(); }

 private:
  struct File {
    std::filesystem::path path;
    const char* content_type;
    bool packed;  // gzip would gain nothing
  };
  void add_files(const std::filesystem::path& folder, const std::string& url);
  bool serve(const httplib::Request& req, httplib::Response& res) const;
  std::map<std::string, File, std::less<>> files_;  // by URL path
};

}  // namespace qray::server
