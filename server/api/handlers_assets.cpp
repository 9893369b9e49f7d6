#include "server/api/handlers_assets.h"

#include <spdlog/spdlog.h>

#include "server/http/reply.h"

namespace qray::server {
namespace {

void reply_stored(httplib::Response& res, int status, const std::string& name) {
  reply_json(res, status, proto::asset_to_json(name));
}

void reply_not_stored(httplib::Response& res, const Error& error) {
  if (error.code == ErrorCode::kInvalid)
    return reply_problem(res, {422, "Wrong hash", error.message, {}});
  if (error.code == ErrorCode::kTooLarge)
    return reply_problem(res, {507, "Insufficient storage", error.message, {}});
  spdlog::error("an asset is not stored: {}", error.text());
  reply_problem(res, {503, "Not stored", "the disk did not take it", {}});
}

}  // namespace

void AssetHandlers::add_to(Router& router) {
  router.add_stream(
      "PUT", "/v1/assets/{id}", max_asset_bytes_,
      [this](auto& req, auto& res, auto& id, auto& body) { put(req, res, id, body); });
  router.add("HEAD", "/v1/assets/{id}", [this](auto&, auto& res, auto& id) {
    if (!assets_.has(id)) return reply_problem(res, {404, "Not found", "no such asset", {}});
    reply_stored(res, 200, id);
  });
}

void AssetHandlers::put(const httplib::Request& req, httplib::Response& res,
                        const std::string& name, const httplib::ContentReader& body) {
  if (!is_asset_name(name))
    return reply_problem(
        res, {422, "Wrong address", "expected a SHA-256: 64 digits of 0-9 and a-f", {}});
  if (assets_.has(name)) return reply_stored(res, 200, name);
  const auto size = req.get_header_value<uint64_t>("Content-Length");
  Result<AssetStore::Upload> upload = assets_.begin(name, size);
  if (!upload.ok()) return reply_not_stored(res, upload.error());
  Status stored;
  const bool arrived = body([&](const char* data, size_t count) {
    stored = upload.value().add({reinterpret_cast<const uint8_t*>(data), count});
    return stored.ok();
  });
  if (stored.ok() && !arrived)
    return reply_problem(res, {400, "Bad request", "the body did not arrive", {}});
  if (stored.ok()) stored = upload.value().commit();
  if (!stored.ok()) return reply_not_stored(res, stored.error());
  reply_stored(res, 201, name);
}

}  // namespace qray::server
