#include "server/api/handlers_scenes.h"

#include "server/http/query.h"
#include "server/http/reply.h"

namespace qray::server {
namespace {

Error no_scene() { return {ErrorCode::kNotFound, "no such scene", ""}; }

}  // namespace

void SceneHandlers::add_to(Router& router) {
  router.add("GET", "/v1/scenes", [this](auto&, auto& res, auto&) {
    reply_json(res, 200, proto::scene_list_to_json(uses_.scenes.list()));
  });
  router.add("POST", "/v1/scenes", [this](auto& req, auto& res, auto&) { create(req, res); });
  router.add("GET", "/v1/scenes/{id}", [this](auto&, auto& res, auto& id) { get(res, id); });
  router.add("GET", "/v1/scenes/{id}/thumbnail.jpg",
             [this](auto& req, auto& res, auto& id) { thumbnail(req, res, id); });
  router.add("PATCH", "/v1/scenes/{id}",
             [this](auto& req, auto& res, auto& id) { rename(req, res, id); });
  router.add("DELETE", "/v1/scenes/{id}", [this](auto&, auto& res, auto& id) { remove(res, id); });
}

std::string SceneHandlers::json_of(const std::string& name) {
  proto::SceneInfo info{name, {}, {}, false};
  if (const auto size = uses_.scenes.size(name)) {
    info.width = size->first;
    info.height = size->second;
  }
  info.cameras = uses_.scenes.cameras(name);
  const std::optional<proto::SceneReport> report = uses_.uploads.find(name);
  info.uploaded = report.has_value();
  if (report) info.title = report->title;
  return proto::scene_to_json(info, report ? &*report : nullptr);
}

void SceneHandlers::create(const httplib::Request& req, httplib::Response& res) {
  if (!is_json(req)) return reply_not_json(res);
  auto parsed = proto::parse_scene_request(req.body, uses_.limits);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed))
    return reply_problem(res, *problem);
  const auto imported = uses_.importer.import(std::get<proto::SceneRequest>(std::move(parsed)));
  if (const auto* problem = std::get_if<proto::Problem>(&imported))
    return reply_problem(res, *problem);
  const auto& scene = std::get<SceneImporter::Imported>(imported);
  res.set_header("Location", "/v1/scenes/" + scene.name);
  reply_json(res, scene.is_new ? 201 : 200, json_of(scene.name));
}

void SceneHandlers::get(httplib::Response& res, const std::string& name) {
  if (!uses_.scenes.has(name)) return reply_error(res, no_scene());
  reply_json(res, 200, json_of(name));
}

void SceneHandlers::thumbnail(const httplib::Request& req, httplib::Response& res,
                              const std::string& name) {
  const Result<Bytes> picture = uses_.thumbnails.get(name);
  if (!picture.ok()) return reply_error(res, picture.error());
  reply_tagged(req, res, picture.value(), "image/jpeg");
}

void SceneHandlers::rename(const httplib::Request& req, httplib::Response& res,
                           const std::string& name) {
  if (!is_json(req)) return reply_not_json(res);
  auto parsed = proto::parse_title_request(req.body, uses_.limits);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed))
    return reply_problem(res, *problem);
  if (!uses_.scenes.has(name)) return reply_error(res, no_scene());
  if (!uses_.uploads.find(name))
    return reply_error(res, {ErrorCode::kConflict, "only uploaded scenes can be renamed", ""});
  if (const Status s = uses_.uploads.rename(name, std::get<std::string>(parsed)); !s.ok())
    return reply_error(res, s.error());
  reply_json(res, 200, json_of(name));
}

void SceneHandlers::remove(httplib::Response& res, const std::string& name) {
  if (!uses_.uploads.find(name)) {
    if (!uses_.scenes.has(name)) return reply_error(res, no_scene());
    return reply_error(res, {ErrorCode::kConflict, "only uploaded scenes can be deleted", ""});
  }
  const Status removed = uses_.jobs.remove_scene(name, [&] { return uses_.uploads.remove(name); });
  if (!removed.ok()) return reply_error(res, removed.error());
  uses_.assets.remove_unused();
  res.status = 204;
}

}  // namespace qray::server
