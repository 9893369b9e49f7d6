// Files of scenes to be: PUT /v1/assets/{sha256} takes one as it arrives, HEAD asks for it. Any
// thread.
#pragma once

#include "server/http/router.h"
#include "server/store/asset_store.h"

namespace qray::server {

class AssetHandlers {
 public:
  AssetHandlers(AssetStore& assets, size_t max_asset_bytes)
      : assets_(assets), max_asset_bytes_(max_asset_bytes) {}
  void add_to(Router& router);

 private:
  void put(const httplib::Request& req, httplib::Response& res, const std::string& name,
           const httplib::ContentReader& body);

  AssetStore& assets_;
  size_t max_asset_bytes_;
};

}  // namespace qray::server
