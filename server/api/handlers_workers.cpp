#include "server/api/handlers_workers.h"

#include "proto/worker_json.h"
#include "server/http/reply.h"

namespace qray::server {

void WorkerHandlers::add_to(Router& router) {
  router.add("GET", "/v1/workers", [this](auto&, auto& res, auto&) { list(res); });
  router.add(
      "POST", "/v1/workers/{id}/drain", [this](auto&, auto& res, auto& id) { drain(res, id); },
      Scope::kAdmin);
}

void WorkerHandlers::list(httplib::Response& res) const {
  std::vector<proto::WorkerMessage> messages;
  if (shared_) {
    const Result<std::vector<WorkerInfo>> workers = shared_->workers();
    if (!workers.ok()) return reply_error(res, workers.error());
    for (const WorkerInfo& w : workers.value()) {
      messages.push_back({w.id,
                          w.host,
                          w.kind,
                          w.build,
                          w.bits,
                          w.threads,
                          w.draining,
                          w.samples,
                          w.samples_a_second,
                          w.age_seconds,
                          w.silent_seconds,
                          {},
                          w.helps ? w.helps->text() : std::string(),
                          w.aside});
      for (const JobId id : w.jobs) messages.back().jobs.push_back(id.text());
    }
  }
  reply_json(res, 200, proto::worker_list_to_json(messages));
}

void WorkerHandlers::drain(httplib::Response& res, const std::string& id) const {
  const Status drained =
      shared_ ? shared_->drain(id) : Status(Error{ErrorCode::kNotFound, "no worker " + id, ""});
  if (!drained.ok()) return reply_error(res, drained.error());
  list(res);
  res.status = 202;
}

}  // namespace qray::server
