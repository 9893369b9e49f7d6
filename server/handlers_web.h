// The page: files of one folder, whose names are read once at the start. A client's path is only
// ever compared with those names, never opened. Any thread.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "server/router.h"

namespace qray::server {

class WebHandlers {
 public:
  explicit WebHandlers(const std::filesystem::path& folder);
  void add_to(Router& router);
  size_t file_count() const { return files_.size(); }

 private:
  struct File {
    std::filesystem::path path;
    const char* content_type;
  };
  bool serve(const httplib::Request& req, httplib::Response& res) const;
  std::map<std::string, File, std::less<>> files_;  // by URL path
};

}  // namespace qray::server
