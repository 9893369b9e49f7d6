// qray watch: follow a server's job to its end, by its events.
#include <CLI/CLI.hpp>
#include <chrono>
#include <thread>

#include "core/cmd/commands.h"
#include "core/cmd/progress_line.h"
#include "core/cmd/service_client.h"

namespace qray::cmd {
namespace {

constexpr int kMaxFailures = 5;  // in a row, before the server counts as gone
constexpr auto kTurnPause = std::chrono::milliseconds(100);  // the stream was closed properly
constexpr auto kRetryPause = std::chrono::seconds(1);

void merge(proto::JobView& job, const proto::JobHint& hint) {
  if (hint.state) job.state = *hint.state;
  if (hint.fraction) job.fraction = *hint.fraction;
  if (hint.samples) job.samples = *hint.samples;
  if (hint.seconds) job.seconds = *hint.seconds;
}

// Events may be missed while the connection is down, so every round starts from the job itself.
Result<proto::JobView> follow(ServiceClient& client, const std::string& id, ProgressLine& line) {
  std::string last_event;
  for (int failures = 0;;) {
    Result<proto::JobView> fetched = client.job(id);
    if (fetched && fetched.value().ended()) return fetched;
    if (!fetched && fetched.error().code != ErrorCode::kIo) return fetched;
    if (fetched) {
      proto::JobView job = fetched.value();
      const Status stream = client.events(id, last_event, [&](const ServerEvent& event) {
        failures = 0;
        last_event = event.id;
        if (event.type == "done") return false;
        if (event.type == "reset") return true;
        const Result<proto::JobHint> hint = proto::parse_job_hint(event.data);
        if (hint && event.type == "loading") {
          line.show(hint.value().step.value_or(job.state), hint.value().fraction.value_or(0), "",
                    hint.value().seconds.value_or(0));
          return true;
        }
        if (hint) merge(job, hint.value());
        line.show(job.state, job.fraction, samples_words(job.samples), job.seconds);
        return !job.ended();
      });
      if (!stream && stream.error().code != ErrorCode::kIo) return stream.error();
      if (stream) {
        std::this_thread::sleep_for(kTurnPause);
        continue;
      }
    }
    if (++failures >= kMaxFailures)
      return Error{ErrorCode::kIo, "the server cannot be reached any more", id};
    std::this_thread::sleep_for(kRetryPause);
  }
}

struct WatchOptions {
  std::string id;
  ServerAddress server;
  bool quiet = false;
};

int run(const WatchOptions& o) {
  Result<std::unique_ptr<ServiceClient>> client = ServiceClient::open(o.server);
  if (!client) return report_client(client.error());
  const Result<proto::JobView> first = client.value()->job(o.id);  // a wrong URL is told at once
  if (!first) return report_client(first.error());
  ProgressLine line(o.quiet);
  const Result<proto::JobView> job = follow(*client.value(), o.id, line);
  line.finish();
  return job ? report_end(job.value()) : report_client(job.error());
}

}  // namespace

void add_watch(CLI::App& app, int& exit_code) {
  auto o = std::make_shared<WatchOptions>();
  CLI::App* sub = app.add_subcommand("watch", "show a job's progress until it ends");
  sub->add_option("id", o->id, "the job")->required();
  sub->add_flag("-q,--quiet", o->quiet, "no progress, only the end");
  add_server_option(*sub, o->server);
  sub->callback([o, &exit_code] { exit_code = run(*o); });
}

}  // namespace qray::cmd
