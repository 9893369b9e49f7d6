#include "server/api/handlers_live.h"

#include "server/api/references.h"
#include "server/http/query.h"
#include "server/http/reply.h"
#include "server/live/frame_stream.h"

namespace qray::server {
namespace {

constexpr std::chrono::milliseconds kLookForFrame{250};  // how soon a reader that left is noticed

struct FrameReader {
  FrameReader(std::shared_ptr<LiveSession> s, FrameEncoding e)
      : session(std::move(s)), encoding(e) {}
  ~FrameReader() { session->remove_reader(); }
  FrameReader(const FrameReader&) = delete;
  FrameReader& operator=(const FrameReader&) = delete;

  std::shared_ptr<LiveSession> session;
  FrameEncoding encoding;
  uint64_t last = 0;
};

// The newest frame, whatever was missed meanwhile. False: the reader has gone.
bool pump(FrameReader& reader, httplib::DataSink& sink) {
  const std::shared_ptr<const ShownFrame> shown = reader.session->wait(reader.last, kLookForFrame);
  if (!shown) {
    if (!reader.session->ended()) return sink.is_writable();
    sink.done();
    return true;
  }
  reader.last = shown->frame.number;
  const Result<Bytes> bytes = encode_frame(*shown, reader.encoding);
  if (!bytes.ok()) return false;
  return sink.write(reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size());
}

}  // namespace

LiveHandlers::LiveHandlers(LiveSessions& sessions, Stores stores,
                           const proto::RequestLimits& limits)
    : sessions_(sessions), stores_(stores), limits_(limits) {
  limits_.max_pixels = std::min(limits_.max_pixels, LiveSessions::kMaxPixels);
}

void LiveHandlers::add_to(Router& router) {
  // Calls `handle` with the session, if there is one.
  const auto on_session = [this](auto handle) {
    return [this, handle](const Request& req, Response& res, const std::string& id) {
      if (const std::shared_ptr<LiveSession> session = sessions_.find(id))
        return handle(req, res, session);
      reply_error(res, {ErrorCode::kNotFound, "no live session of this id: it may have ended", ""});
    };
  };
  router.add("POST", "/v1/live", [this](auto& req, auto& res, auto&) { open(req, res); });
  router.add("GET", "/v1/live/{id}", on_session([](auto&, auto& res, auto session) {
               reply_json(res, 200, proto::live_to_json(session->info()));
             }));
  router.add("DELETE", "/v1/live/{id}", on_session([](auto&, auto& res, auto session) {
               session->end();
               res.status = 204;
             }),
             Scope::kSubmit);
  router.add("PUT", "/v1/live/{id}/camera", on_session([this](auto& req, auto& res, auto session) {
               set_camera(req, res, *session);
             }));
  router.add(
      "PUT", "/v1/live/{id}/switches",
      on_session([this](auto& req, auto& res, auto session) { set_switches(req, res, *session); }));
  router.add("PUT", "/v1/live/{id}/lights", on_session([this](auto& req, auto& res, auto session) {
               set_lights(req, res, *session);
             }));
  router.add("GET", "/v1/live/{id}/frames",
             on_session([this](auto& req, auto& res, auto session) { frames(req, res, session); }));
}

std::optional<proto::Problem> LiveHandlers::check_references(const proto::LiveRequest& request) {
  std::vector<proto::FieldError> errors;
  std::optional<int> width = request.width, height = request.height;
  check_scene(stores_, request.scene, width, height, limits_.max_pixels, errors);
  check_table(stores_, request.table, request.method, errors);
  check_recover(stores_, request.recover, errors);
  return problem_of(std::move(errors), "Wrong live request");
}

void LiveHandlers::open(const Request& req, Response& res) {
  if (!is_json(req)) return reply_not_json(res);
  const auto parsed = proto::parse_live_request(req.body, limits_);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed))
    return reply_problem(res, *problem);
  const auto& request = std::get<proto::LiveRequest>(parsed);
  if (const auto problem = check_references(request)) return reply_problem(res, *problem);
  const Result<std::shared_ptr<LiveSession>> session = sessions_.open(request);
  if (!session.ok() && session.error().code == ErrorCode::kBusy) {
    res.set_header("Retry-After", "5");
    return reply_problem(res, {503, "No room for a live session", session.error().message, {}});
  }
  if (!session.ok()) return reply_error(res, session.error());
  res.set_header("Location", "/v1/live/" + session.value()->id());
  reply_json(res, 201, proto::live_to_json(session.value()->info()));
}

void LiveHandlers::set_camera(const Request& req, Response& res, LiveSession& session) {
  if (!is_json(req)) return reply_not_json(res);
  const auto parsed = proto::parse_live_camera(req.body, limits_);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed))
    return reply_problem(res, *problem);
  const Result<proto::LiveCameraAnswer> answer =
      session.set_camera(std::get<proto::LiveCameraRequest>(parsed));
  if (!answer.ok())
    return reply_problem(
        res, {422, "Wrong camera", answer.error().message, {{"/camera", answer.error().message}}});
  reply_json(res, 200, proto::live_camera_to_json(answer.value()));
}

void LiveHandlers::set_switches(const Request& req, Response& res, LiveSession& session) {
  if (!is_json(req)) return reply_not_json(res);
  const auto parsed = proto::parse_live_switches(req.body, limits_, session.info().switches);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed))
    return reply_problem(res, *problem);
  session.set_switches(std::get<proto::LiveSwitchesRequest>(parsed));
  reply_json(res, 200, proto::live_to_json(session.info()));
}

void LiveHandlers::set_lights(const Request& req, Response& res, LiveSession& session) {
  if (!is_json(req)) return reply_not_json(res);
  auto parsed = proto::parse_live_lights(req.body, limits_, session.info().lights.size());
  if (const auto* problem = std::get_if<proto::Problem>(&parsed))
    return reply_problem(res, *problem);
  session.set_lights(std::get<std::vector<double>>(std::move(parsed)));
  reply_json(res, 200, proto::live_to_json(session.info()));
}

void LiveHandlers::frames(const Request& req, Response& res, std::shared_ptr<LiveSession> session) {
  const std::string name = req.has_param("enc") ? req.get_param_value("enc") : "rgb9e5";
  const std::optional<FrameEncoding> encoding = frame_encoding_named(name);
  if (!encoding) {
    const std::string expected = "expected rgb9e5, jpeg or webp";
    return reply_problem(res, {422, "Wrong parameter", "/enc: " + expected, {{"/enc", expected}}});
  }
  if (!session->add_reader())
    return reply_problem(res, {503, "Too many readers", "or the session has ended", {}});
  auto reader = std::make_shared<FrameReader>(std::move(session), *encoding);
  res.status = 200;
  res.set_header("Cache-Control", "no-store");
  res.set_header("X-Accel-Buffering", "no");  // for a proxy in between
  res.set_chunked_content_provider(
      kBytesType, [reader](size_t, httplib::DataSink& sink) { return pump(*reader, sink); });
}

}  // namespace qray::server
