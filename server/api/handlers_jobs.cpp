#include "server/api/handlers_jobs.h"

#include <algorithm>

#include "core/base/sha256.h"
#include "core/base/turn.h"
#include "core/settings/job_settings.h"
#include "server/api/references.h"
#include "server/http/query.h"
#include "server/http/reply.h"

namespace qray::server {
namespace {

constexpr int kMaxWaiters = 64, kMaxWaitSeconds = 60;
constexpr size_t kMaxKeyBytes = 255;

}  // namespace

JobHandlers::JobHandlers(JobRunner& runner, Stores stores, const EventLog& events,
                         const proto::RequestLimits& limits)
    : runner_(runner), stores_(stores), events_(events), limits_(limits), waiters_(kMaxWaiters) {}

void JobHandlers::add_to(Router& router) {
  router.add("POST", "/v1/jobs", [this](auto& req, auto& res, auto&) { create(req, res); });
  router.add("GET", "/v1/jobs", [this](auto& req, auto& res, auto&) { list(req, res); });
  router.add("DELETE", "/v1/jobs", [this](auto& req, auto& res, auto&) { remove_many(req, res); });
  router.add("PATCH", "/v1/jobs/{id}",
             [this](auto& req, auto& res, auto& id) { update(req, res, id); });
  router.add("GET", "/v1/jobs/{id}", [this](auto& req, auto& res, auto& id) { get(req, res, id); });
  router.add("DELETE", "/v1/jobs/{id}", [this](auto&, auto& res, auto& id) { remove(res, id); });
  router.add("GET", "/v1/fields", [this](auto&, auto& res, auto&) {
    reply_json(res, 200, proto::fields_to_json(limits_));
  });
  router.add("GET", "/v1/jobs/{id}/log", [this](auto&, auto& res, auto& id) { log(res, id); });
  const auto action = [&](const char* name, Result<JobRecord> (JobRunner::*act)(JobId)) {
    router.add("POST", std::string("/v1/jobs/{id}/") + name,
               [this, act](auto&, auto& res, auto& id) {
                 const Result<JobRecord> job = stores_.jobs.find(id);
                 reply_job(res, 202, job.ok() ? (runner_.*act)(job.value().id) : job);
               });
  };
  action("cancel", &JobRunner::cancel);
  action("pause", &JobRunner::pause);
  action("resume", &JobRunner::resume);
  router.add("POST", "/v1/jobs/{id}/extend",
             [this](auto& req, auto& res, auto& id) { extend(req, res, id); });
}

void JobHandlers::reply_job(Response& res, int status, const Result<JobRecord>& job) const {
  if (!job.ok()) return reply_error(res, job.error());
  reply_json(res, status, proto::job_to_json(info(job.value())));
}

proto::JobInfo JobHandlers::info(const JobRecord& job) const {
  proto::JobInfo info = job.info();
  if (is_running(job.state)) {
    if (const auto running = runner_.running(job.id)) info.progress = running->progress();
  }
  info.extendable = job.state == JobState::kSucceeded && stores_.checkpoints.has(job.id);
  return info;
}

// What the request names must be there; sizes that it leaves out are filled in for its answer.
std::optional<proto::Problem> JobHandlers::check_references(JobRequest& request) {
  std::vector<proto::FieldError> errors;
  std::optional<int> width = request.given(field::kWidth), height = request.given(field::kHeight);
  check_scene(stores_, request.get(field::kScene), width, height, limits_.max_pixels, errors);
  if (width) request.set(field::kWidth, *width);
  if (height) request.set(field::kHeight, *height);
  check_table(stores_, request.get(field::kTable), request.get(field::kMethod), errors);
  for (const auto& [pointer, side] : {std::pair{"/width", width}, {"/height", height}})
    if (pixels_named(request.get(field::kPixels)) != Pixels::kAll && side && *side % 2 != 0)
      errors.push_back({pointer, "expected an even number for a quarter of the pixels, got " +
                                     std::to_string(*side)});
  check_recover(stores_, request.get(field::kRecover), errors);
  return problem_of(std::move(errors), "Wrong job request");
}

void JobHandlers::create(const Request& req, Response& res) {
  if (!is_json(req)) return reply_not_json(res);
  auto parsed = proto::parse_job_request(req.body, limits_);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed)) {
    return reply_problem(res, *problem);
  }
  JobRequest request = std::get<JobRequest>(std::move(parsed));
  if (const auto problem = check_references(request)) return reply_problem(res, *problem);
  fill_defaults(request);
  std::optional<JobStore::IdempotencyKey> key;
  if (req.has_header("Idempotency-Key")) {
    key.emplace(JobStore::IdempotencyKey{req.get_header_value("Idempotency-Key"), ""});
    const bool plain =
        std::all_of(key->key.begin(), key->key.end(), [](char c) { return c >= ' ' && c <= '~'; });
    if (key->key.empty() || key->key.size() > kMaxKeyBytes || !plain)
      return reply_problem(
          res, {400, "Wrong Idempotency-Key", "expected 1..255 printable ASCII characters", {}});
    key->request = sha256(proto::job_request_to_json(request)).hex();
  }
  const Result<JobRecord> job = runner_.submit(request, key);
  if (job.ok()) res.set_header("Location", "/v1/jobs/" + job.value().id.text());
  reply_job(res, 202, job);
}

// With `wait` the answer may take so many seconds: until it is another than the one that
// If-None-Match names or, without that, until the job's state has changed or it has ended.
void JobHandlers::get(const Request& req, Response& res, const std::string& id) {
  using std::chrono::steady_clock;
  uint64_t cursor = events_.newest();  // before the job is read: no event falls in between
  Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<int> wait = query_number(req, "wait", 0, kMaxWaitSeconds, 0);
  if (!wait.ok()) return reply_error(res, wait.error());
  const auto deadline = steady_clock::now() + std::chrono::seconds(wait.value());
  std::optional<Turn> turn;
  if (wait.value() > 0) turn.emplace(waiters_, std::chrono::milliseconds(0));
  if (turn && !turn->mine()) return reply_problem(res, {503, "Busy", "too many clients wait", {}});
  const JobState first = job.value().state;
  const std::string known = req.get_header_value("If-None-Match");
  for (;;) {
    const std::string json = proto::job_to_json(info(job.value()));
    const JobState state = job.value().state;
    const bool news = known.empty() ? state != first || has_ended(state) : !is_tag_of(known, json);
    const auto left = deadline - steady_clock::now();
    if (news || left <= steady_clock::duration::zero() || events_.closed())
      return reply_tagged(req, res, json);
    (void)events_.wait(cursor, id,
                       std::min(std::chrono::duration_cast<std::chrono::milliseconds>(left),
                                std::chrono::milliseconds(1000)));
    cursor = events_.newest();
    job = stores_.jobs.find(id);
    if (!job.ok()) return reply_error(res, job.error());
  }
}

void JobHandlers::extend(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  if (!is_json(req)) return reply_not_json(res);
  const auto parsed = proto::parse_extend_request(req.body, limits_);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed))
    return reply_problem(res, *problem);
  reply_job(res, 202, runner_.extend(job.value().id, std::get<proto::ExtendRequest>(parsed)));
}

void JobHandlers::update(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  if (!is_json(req)) return reply_not_json(res);
  const auto parsed = proto::parse_job_update(req.body, limits_);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed))
    return reply_problem(res, *problem);
  reply_job(res, 200, runner_.update(job.value().id, std::get<proto::JobUpdate>(parsed)));
}

void JobHandlers::remove(Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  if (Status s = runner_.remove(job.value().id); !s.ok()) return reply_error(res, s.error());
  res.status = 204;
}

void JobHandlers::log(Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<std::vector<JobStore::LogLine>> lines = stores_.jobs.log_of(job.value().id);
  if (!lines.ok()) return reply_error(res, lines.error());
  std::string text;
  for (const JobStore::LogLine& line : lines.value())
    text += proto::time_to_text(line.time_ms) + " " + line.level + " " + line.text + "\n";
  res.set_header("Cache-Control", "no-store");
  res.set_content(text, "text/plain; charset=utf-8");
}

}  // namespace qray::server
