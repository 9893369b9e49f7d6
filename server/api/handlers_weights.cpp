#include "server/api/handlers_weights.h"

#include "server/http/reply.h"

namespace qray::server {
void WeightsHandlers::add_to(Router& router) {
  router.add("GET", "/v1/weights", [this](auto&, auto& res, auto&) {
    reply_json(res, 200, proto::weights_list_to_json(weights_.list()));
  });
  router.add(
      "POST", "/v1/weights", [this](auto& req, auto& res, auto&) { add(req, res); }, Scope::kAdmin);
  router.add("GET", "/v1/weights/{id}", [this](auto&, auto& res, auto& id) {
    const Result<proto::WeightsInfo> info = weights_.find(id);
    if (!info.ok()) return reply_error(res, info.error());
    reply_json(res, 200, proto::weights_to_json(info.value()));
  });
  router.add("GET", "/v1/weights/{id}/file", [this](auto&, auto& res, auto& id) { file(res, id); });
  router.add("DELETE", "/v1/weights/{id}", [this](auto&, auto& res, auto& id) {
    if (Status removed = weights_.remove(id); !removed.ok())
      return reply_error(res, removed.error());
    res.status = 204;
  });
}

void WeightsHandlers::add(const httplib::Request& req, httplib::Response& res) {
  if (req.get_header_value("Content-Type") != kBytesType)
    return reply_problem(
        res,
        {415, "Wrong media type", std::string("expected a weights file as ") + kBytesType, {}});
  if (req.body.size() > kMaxWeightsBytes)
    return reply_problem(
        res,
        {413, "Too large", "expected at most " + std::to_string(kMaxWeightsBytes) + " bytes", {}});
  const auto* bytes = reinterpret_cast<const uint8_t*>(req.body.data());
  const Result<WeightsFile> weights = decode_weights({bytes, req.body.size()});
  if (!weights.ok())
    return reply_problem(res, {422, "Wrong weights file", weights.error().text(), {}});
  if (Status added = weights_.add(weights.value()); !added.ok())
    return reply_error(res, added.error());
  const Result<proto::WeightsInfo> info = weights_.find(weights.value().id);
  if (!info.ok()) return reply_error(res, info.error());
  res.set_header("Location", "/v1/weights/" + info.value().id);
  reply_json(res, 201, proto::weights_to_json(info.value()));
}

void WeightsHandlers::file(httplib::Response& res, const std::string& id) {
  const Result<WeightsFile> weights = weights_.load(id);
  if (!weights.ok()) return reply_error(res, weights.error());
  reply_bytes(res, encode_weights(weights.value()), kBytesType);
}

}  // namespace qray::server
