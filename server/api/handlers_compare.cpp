#include "server/api/handlers_compare.h"

#include <algorithm>

#include "core/base/turn.h"
#include "core/image/difference_map.h"
#include "core/image/metrics.h"
#include "server/http/query.h"
#include "server/http/reply.h"

namespace qray::server {
namespace {

struct Map {
  std::string_view name;
  Image (*draw)(const Image& a, const Image& b);
  std::string_view scale;
};
constexpr Map kMaps[] = {
    {"signed", &signed_map, kSignedMapScale},
    {"flip", &flip_false_color, kFlipMapScale},
    {"relative", &error_map, kErrorMapScale},
};

const Map* map_named(std::string_view name) {
  const auto found = std::find_if(std::begin(kMaps), std::end(kMaps),
                                  [&](const Map& map) { return map.name == name; });
  return found == std::end(kMaps) ? nullptr : found;
}

// What is wrong with a request: all of it at once. `needed`, `optional`: jobs.
proto::Problem judge(const httplib::Request& req, std::initializer_list<const char*> needed,
                     std::initializer_list<const char*> optional, bool needs_map = false) {
  proto::Problem wrong{422, "Wrong request", "", {}};
  const auto check = [&](const char* name, bool may_lack) {
    if ((!may_lack || req.has_param(name)) && !JobId::parse(req.get_param_value(name)))
      wrong.errors.push_back({std::string("/") + name, "expected a job's id"});
    const std::string moment = std::string(name) + "_moment";
    const auto number = query_number<uint32_t>(req, moment.c_str(), 1, UINT32_MAX, 1);
    if (!number.ok()) wrong.errors.push_back({number.error().where, number.error().message});
  };
  for (const char* name : needed) check(name, false);
  for (const char* name : optional) check(name, true);
  if (const std::string picture = req.get_param_value("picture");
      req.has_param("picture") && picture != "sampled" && picture != "recovered")
    wrong.errors.push_back({"/picture", "expected sampled or recovered"});
  if (needs_map && !map_named(req.get_param_value("map")))
    wrong.errors.push_back({"/map", "expected signed, flip or relative"});
  if (!wrong.errors.empty())
    wrong.detail = wrong.errors.front().pointer + ": " + wrong.errors.front().detail;
  return wrong;
}

Result<proto::PictureDifference> difference(const Image& picture, const Image& reference,
                                            const char* pointer) {
  const Result<ImageDifference> d = image_difference(picture, reference);
  if (!d.ok()) return Error{ErrorCode::kInvalid, d.error().message, pointer};
  return proto::PictureDifference{d.value().relmse, d.value().relmse_trimmed, d.value().flip,
                                  d.value().mean_ratio, d.value().max_abs};
}

}  // namespace

void CompareHandlers::add_to(Router& router) {
  router.add("GET", "/v1/compare", [this](auto& req, auto& res, auto&) { compare(req, res); });
  router.add("GET", "/v1/compare.png", [this](auto& req, auto& res, auto&) { map(req, res); });
  router.add("GET", "/v1/jobs/{id}/metrics",
             [this](auto& req, auto& res, auto& id) { metrics(req, res, id); });
}

Result<Image> CompareHandlers::image_named(const Request& req, const char* parameter,
                                           const char* moment) {
  const auto named = [&](Error error) {
    error.where = std::string("/") + parameter;
    return error;
  };
  const Result<JobRecord> job = stores_.jobs.find(req.get_param_value(parameter));
  if (!job.ok()) return named(job.error());
  const auto which = pictures_.which(req, job.value(), /*best=*/true, moment);
  if (!which.ok()) return which.error();
  Result<Image> image = pictures_.image(job.value(), which.value());
  if (!image.ok() && image.error().code == ErrorCode::kConflict) return named(image.error());
  return image;
}

Result<CompareHandlers::Pair> CompareHandlers::both(const Request& req) {
  Result<Image> a = image_named(req, "a", "a_moment");
  if (!a.ok()) return a.error();
  Result<Image> b = image_named(req, "b", "b_moment");
  if (!b.ok()) return b.error();
  return Pair{std::move(a).value(), std::move(b).value()};
}

void CompareHandlers::compare(const Request& req, Response& res) {
  if (const proto::Problem wrong = judge(req, {"a", "b"}, {"ref"}); !wrong.errors.empty())
    return reply_problem(res, wrong);
  const Turn turn(encoders_);
  if (!turn.mine()) return reply_problem(res, kTooManyPictures);
  const Result<Pair> pair = both(req);
  if (!pair.ok()) return reply_error(res, pair.error());
  const auto& [a, b] = pair.value();
  proto::Comparison comparison{
      req.get_param_value("a"), req.get_param_value("b"), req.get_param_value("ref"), {}, {}, {}};
  Result<proto::PictureDifference> d = difference(a, b, "/b");
  if (!d.ok()) return reply_error(res, d.error());
  comparison.difference = d.value();
  if (req.has_param("ref")) {
    const Result<Image> ref = image_named(req, "ref", "ref_moment");
    if (!ref.ok()) return reply_error(res, ref.error());
    for (const auto& [image, error] :
         {std::pair{&a, &comparison.a_error}, {&b, &comparison.b_error}}) {
      d = difference(*image, ref.value(), "/ref");
      if (!d.ok()) return reply_error(res, d.error());
      *error = d.value();
    }
  }
  reply_json(res, 200, proto::comparison_to_json(comparison));
}

void CompareHandlers::map(const Request& req, Response& res) {
  if (const proto::Problem wrong = judge(req, {"a", "b"}, {}, /*needs_map=*/true);
      !wrong.errors.empty())
    return reply_problem(res, wrong);
  const Map& wanted = *map_named(req.get_param_value("map"));
  const Turn turn(encoders_);
  if (!turn.mine()) return reply_problem(res, kTooManyPictures);
  const Result<Pair> pair = both(req);
  if (!pair.ok()) return reply_error(res, pair.error());
  const auto& [a, b] = pair.value();
  if (a.width() != b.width() || a.height() != b.height())
    return reply_error(res, {ErrorCode::kInvalid, "expected pictures of one size", "/b"});
  const Result<Bytes> png =
      encode_image(ImageFormat::kPng, wanted.draw(a, b),
                   {{"map", std::string(wanted.name)}, {"scale", std::string(wanted.scale)}});
  if (!png.ok()) return reply_error(res, png.error());
  reply_tagged(req, res, png.value(), "image/png");
}

Result<std::map<uint32_t, double>> CompareHandlers::errors(
    const JobRecord& job, const std::vector<proto::Moment>& moments, const Image& reference) {
  std::map<uint32_t, double> errors;
  for (const proto::Moment& moment : moments) {
    if (!moment.picture) continue;
    const Result<Image> image =
        pictures_.image(job, {PictureSource::Which::Kind::kMoment, moment.number});
    if (!image.ok()) continue;  // it made room meanwhile
    if (image.value().width() != reference.width() || image.value().height() != reference.height())
      return Error{ErrorCode::kInvalid, "expected a job whose picture is as large", "/ref"};
    errors[moment.number] = relmse(image.value(), reference);
  }
  return errors;
}

void CompareHandlers::metrics(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  if (const proto::Problem wrong = judge(req, {}, {"ref"}); !wrong.errors.empty())
    return reply_problem(res, wrong);
  proto::JobMetrics metrics{id, req.get_param_value("ref"), {}, {}};
  metrics.moments = stores_.moments.moments(job.value().id);
  if (req.has_param("ref")) {
    const Turn turn(encoders_);
    if (!turn.mine()) return reply_problem(res, kTooManyPictures);
    const Result<Image> ref = image_named(req, "ref", "ref_moment");
    if (!ref.ok()) return reply_error(res, ref.error());
    Result<std::map<uint32_t, double>> errors =
        this->errors(job.value(), metrics.moments, ref.value());
    if (!errors.ok()) return reply_error(res, errors.error());
    metrics.relmse = std::move(errors).value();
  }
  reply_tagged(req, res, proto::metrics_to_json(metrics));
}

}  // namespace qray::server
