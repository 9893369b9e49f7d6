#include "tests/orders/life.h"

#include <sys/mman.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <set>
#include <thread>

#include "server/jobs/janitor.h"
#include "server/jobs/job_runner.h"
#include "server/open_records.h"
#include "server/store/leftovers.h"
#include "tests/crash/faults.h"
#include "tests/orders/ground.h"
#include "tests/orders/scheduler.h"

namespace qray::server::test {
namespace {

namespace fs = std::filesystem;
using qray::test::Fault;
using qray::test::fault_plan;
using qray::test::sleep_virtually;

constexpr double kKeepDays = 1;
constexpr unsigned kMostSeconds = 100;  // that a life of the server takes

// Of {"job":"j000001","state":"queued",...}.
std::string state_in(const std::string& event) {
  constexpr std::string_view kMember = "\"state\":\"";
  const size_t begin = event.find(kMember) + kMember.size();
  return event.substr(begin, event.find('"', begin) - begin);
}

// Every n-th sample is n, so that a lost or doubled one shows in the mean.
float mean_of(int samples) { return static_cast<float>(samples + 1) / 2; }

class Server {
 public:
  explicit Server(const Order& order) : order_(order) {}

  // False: the disk is full.
  bool start() {
    Ground& ground = Ground::instance();
    const fs::path& data = ground.data();
    Config config;
    config.data = data;
    config.store = ground.store();
    config.lease_seconds = 3600;  // each life begins by ending those of the life before
    Result<std::unique_ptr<Records>> records = open_records(
        config, events_, [this] { return now_ms(); }, /*publishes=*/true);
    if (!records.ok()) return refused(records.error());
    records_ = std::move(records).value();
    jobs_ = &records_->jobs();
    Result<std::unique_ptr<TableStore>> tables =
        TableStore::open(records_->tables(), data, size_t{1} << 20);
    if (!tables.ok()) return refused(tables.error());
    tables_ = std::move(tables).value();
    Result<std::unique_ptr<WeightsStore>> weights = WeightsStore::open(data);
    if (!weights.ok()) return refused(weights.error());
    weights_ = std::move(weights).value();
    results_ = std::make_unique<ResultStore>(data);
    checkpoints_ = std::make_unique<CheckpointStore>(data, uint64_t{1} << 30, this_build());
    moments_ = std::make_unique<MomentStore>(data, uint64_t{1} << 30);
    if (Status s = tidy_data_folder(data, *jobs_, *tables_); !s.ok()) return refused(s.error());
    Result<std::vector<JobRecord>> queued = jobs_->recover();
    if (!queued.ok()) return refused(queued.error());
    checkpoints_->tidy([this](JobId id) {
      using enum CheckpointStore::Keep;
      const Result<JobRecord> job = jobs_->get(id);
      if (!job.ok()) return kNo;
      if (!has_ended(job.value().state)) return kOpen;
      return job.value().state == JobState::kSucceeded ? kFinished : kNo;
    });
    JobRunner::Limits limits;
    limits.at_once = order_.at_once;
    limits.max_queued = static_cast<size_t>(order_.max_queued);
    runner_ = std::make_unique<JobRunner>(
        Stores{*jobs_, *tables_, *weights_, *results_, ground.scenes(), *checkpoints_, *moments_,
               /*metrics=*/nullptr, records_->shared()},
        limits, clock_, [this] { return now_ms(); },
        [this](auto&&... arguments) {
          return render(std::forward<decltype(arguments)>(arguments)...);
        });
    runner_->start(queued.value());
    return true;
  }

  void stop() { runner_->stop(); }
  // The clients' next steps, until they have no more or the server shall stop.
  void serve() {
    std::vector<std::thread> clients;
    for (int c = 0; c < Order::kClients; ++c)
      clients.emplace_back([this, c] {
        const std::vector<Step>& steps = order_.steps[c];
        int& next = shared().next_step[c];
        while (!leave_ && static_cast<size_t>(next) < steps.size())
          act(steps[static_cast<size_t>(next++)]);
      });
    for (std::thread& client : clients) client.join();
  }

  // Everything ends that was asked for; then it is compared.
  void settle() {
    fault_plan().armed = false;
    for (int polls = 0; polls < 400; ++polls) {
      bool open = false;
      for (const JobRecord& job : list()) {
        open |= !has_ended(job.state);
        if (job.state == JobState::kPaused) (void)runner_->resume(job.id);
      }
      // A run's last words come after its job's end.
      if (!open && runs_ == 0 && runner_->memory().take_now(SIZE_MAX / 4)) return;
      sleep_virtually(1);
    }
    for (const JobRecord& job : list())
      if (!has_ended(job.state))
        fail(job.id.text() + " does not end: " + std::string(to_string(job.state)));
    if (!runner_->memory().take_now(SIZE_MAX / 4)) fail("memory is not given back");
  }

  void judge() {
    if (runner_->queued() != 0) fail("a job is in the queue that has ended");
    std::set<uint64_t> known;
    for (const Asked& asked : shared().jobs)
      if (asked.accepted) {
        known.insert(asked.id);
        judge_job(asked);
      }
    size_t unknown = 0, unanswered = 0;
    for (const JobRecord& job : list()) unknown += known.contains(job.id.value) ? 0 : 1;
    for (const Asked& asked : shared().jobs) unanswered += asked.submit_begun && !asked.accepted;
    if (unknown > unanswered) fail("there is a job that nobody asked for");
    judge_events();
  }

  // After another start: nothing is there that the list does not have.
  void judge_folders() {
    std::set<std::string> listed;
    for (const JobRecord& job : list()) listed.insert(job.id.text());
    for (const char* folder : {"results", "moments", "checkpoints"}) {
      std::error_code ec;
      for (fs::recursive_directory_iterator it(Ground::instance().data() / folder, ec), end;
           !ec && it != end; it.increment(ec)) {
        const std::string name = it->path().filename();
        if (it.depth() == 0 && !listed.contains(name))
          fail(std::string(folder) + "/" + name + " stays");
        if (name.find(".tmp.") != std::string::npos) fail(it->path().string() + " stays");
      }
    }
  }

 private:
  static bool refused(const Error& error) {
    if (!fault_plan().armed) fail("no start: " + error.text());
    return false;
  }
  int64_t now_ms() const {
    return static_cast<int64_t>(clock_.seconds() * 1000) +
           (1000 + shared().clock_hours) * 3600 * 1000;
  }
  std::vector<JobRecord> list() {
    Result<std::vector<JobRecord>> jobs = jobs_->list(100, {});
    if (jobs.ok()) return std::move(jobs).value();
    fail("no list: " + jobs.error().text());
    return {};
  }

  void act(const Step& step) {
    Asked& job = shared().jobs[step.job];
    const JobId id{job.id};
    const auto expect = [&](const Result<JobRecord>& answer,
                            std::initializer_list<JobState> states) {
      if (answer.ok() &&
          std::find(states.begin(), states.end(), answer.value().state) == states.end())
        fail(std::string(to_string(step.act)) + " was answered " +
             std::string(to_string(answer.value().state)));
      if (!answer.ok() && answer.error().code == ErrorCode::kNotFound && !job.remove_begun &&
          !shared().expire_begun)
        fail(id.text() + " is not found");
      return answer.ok();
    };
    using enum JobState;
    switch (step.act) {
      case Act::kSubmit:
        if (!job.submit_begun) submit(step, job);
        break;
      case Act::kPause:
        if (job.accepted) expect(runner_->pause(id), {kPausing, kPaused});
        break;
      case Act::kResume:
        if (job.accepted) expect(runner_->resume(id), {kQueued});
        break;
      case Act::kCancel: {
        if (!job.accepted) break;
        job.cancel_begun = true;
        const Result<JobRecord> answer = runner_->cancel(id);
        if (!expect(answer, {kCanceling, kCanceled})) break;
        job.cancel_answered = true;
        job.canceled |= answer.value().state == kCanceled;
        break;
      }
      case Act::kRemove:
        if (!job.accepted) break;
        job.remove_begun = true;
        job.removed |= runner_->remove(id).ok();
        break;
      case Act::kExtend:
        if (!job.accepted) break;
        job.maybe_more += step.value;
        // Nothing is answered yet, but a render may take it up before this thread goes on.
        if (const auto answer = runner_->extend(id, {step.value, {}, {}});
            expect(answer, {kQueued}))
          job.samples += step.value;
        job.maybe_more -= step.value;
        break;
      case Act::kExpire:
        shared().expire_begun = true;
        Janitor::sweep(*runner_, *jobs_, kKeepDays, now_ms());
        break;
      case Act::kTurnClock:
        shared().clock_hours += step.value;
        break;
      case Act::kFullDisk:
        shared().disk_was_full = true;
        fault_plan().fault = Fault::kFullDisk;
        fault_plan().at = 1;
        fault_plan().changes = 0;
        fault_plan().armed = true;
        break;
      case Act::kRoomAgain:
        fault_plan().armed = false;
        break;
      case Act::kSleep:
        sleep_virtually(step.value / 10.0);
        break;
      case Act::kStop:
        leave_ = true;
        break;
      case Act::kKill:
        ++shared().kills;
        shared().kill_begun = true;
        ::kill(::getpid(), SIGKILL);
        for (;;) ::pause();
      case Act::kCount:
        break;
    }
  }

  void submit(const Step& step, Asked& job) {
    JobRequest request;
    request.set(field::kScene, "box");
    request.set(field::kSamples, step.value);
    request.set(field::kMethod, "none");
    request.set(field::kWidth, 4);
    request.set(field::kHeight, 4);
    request.set(field::kPriority, step.job - 1);
    job.submit_begun = true;
    const Result<JobRecord> answer = runner_->submit(request);
    if (!answer.ok()) {
      const ErrorCode code = answer.error().code;
      if (code != ErrorCode::kBusy && code != ErrorCode::kIo)
        fail("submit: " + answer.error().text());
      job.submit_begun = false;
      return;
    }
    job.id = answer.value().id.value;
    job.samples = step.value;
    job.accepted = true;
  }

  // A pass is a sample, and takes .4 s.
  Result<JobResult> render(const PreparedScene&, const RenderSettings& settings, StartingGuide,
                           Film& film, TaskPool&, RenderObserver& observer, std::stop_token stop,
                           const Clock& clock, const Recovery*, const Checkpoints& checkpoints,
                           PassSampler*) {
    const JobId id = dynamic_cast<const RunningJob&>(observer).id();
    const Run run(*this, id);
    const Error canceled{ErrorCode::kCanceled, "canceled", ""};
    int done = 0;
    if (checkpoints.resume_from) {
      (*checkpoints.resume_from)(done);
      film.load_state(*checkpoints.resume_from);
      if (!checkpoints.resume_from->ok()) return Error{ErrorCode::kCorrupt, "torn", ""};
    }
    JobResult result;
    result.stats.method = settings.method;
    result.stats.width = settings.width;
    result.stats.height = settings.height;
    result.stats.passes.assign(static_cast<size_t>(done), 1);
    result.stats.samples_per_pixel = static_cast<uint64_t>(done);
    const double begin = clock.seconds();
    while (done < settings.samples) {
      if (stop.stop_requested()) return canceled;
      if (checkpoints.keeper->due() && !checkpoints.keeper->save([&](SnapshotWriter& out) {
            out(done);
            film.save_state(out);
          }))
        return canceled;
      ++done;
      film.add(0, std::vector<Rgb>(16, Rgb{static_cast<float>(done)}), 1);
      result.stats.passes.push_back(1);
      result.stats.samples_per_pixel = static_cast<uint64_t>(done);
      result.stats.seconds = clock.seconds() - begin;
      observer.on_pass(
          {false, double(done) / settings.samples, uint64_t(done), result.stats.seconds, 0},
          result.stats, nullptr);
      sleep_virtually(0.4);
    }
    // What is kept of a job that has succeeded is what it is extended from.
    (void)checkpoints.keeper->save([&](SnapshotWriter& out) {
      out(done);
      film.save_state(out);
    });
    return result;
  }

  // One render at work.
  struct Run {
    Run(Server& of, JobId of_job) : server(of), id(of_job) {
      if (!server.rendering_.insert(id).second) fail(id.text() + " is rendered twice at once");
      if (++server.runs_ > server.order_.at_once) fail("more run at once than may");
      for (const Asked& asked : shared().jobs) {
        if (!asked.accepted || asked.id != id.value) continue;
        if (asked.canceled) fail(id.text() + " is rendered after it was canceled");
        if (asked.removed) fail(id.text() + " is rendered after it was removed");
      }
    }
    ~Run() {
      server.rendering_.erase(id);
      --server.runs_;
    }
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;
    Server& server;
    const JobId id;
  };

  void judge_job(const Asked& asked) {
    const JobId id{asked.id};
    const std::string name = id.text();
    const Result<JobRecord> found = jobs_->get(id);
    if (!found.ok()) {
      if (found.error().code != ErrorCode::kNotFound) fail(name + ": " + found.error().text());
      if (!asked.remove_begun && !shared().expire_begun) fail(name + " is lost");
      return;
    }
    const JobRecord& job = found.value();
    const std::string state(to_string(job.state));
    if (asked.removed) fail(name + " is back after it was removed: " + state);
    if (asked.cancel_answered && job.state != JobState::kCanceled)
      fail(name + " was canceled and is " + state);
    if (job.state == JobState::kCanceled && !asked.cancel_begun)
      fail(name + " is canceled, which nobody asked for");
    if (job.state == JobState::kFailed && !shared().disk_was_full && shared().kills < kMaxAttempts)
      fail(name + " failed: " + (job.error ? job.error->message : "without a word"));
    if (job.state != JobState::kSucceeded) return;
    const int samples = static_cast<int>(job.progress.samples);
    if (samples < asked.samples || samples > asked.samples + asked.maybe_more)
      fail(name + " has " + std::to_string(samples) + " samples, expected " +
           std::to_string(asked.samples));
    const auto picture = results_->load(id);
    if (!picture.ok()) return fail(name + " has no picture: " + picture.error().text());
    const float mean = picture.value()->image.data()[0];
    if (std::abs(mean - mean_of(samples)) > 1e-3f)
      fail(name + "'s picture has the mean " + std::to_string(mean) + ", expected " +
           std::to_string(mean_of(samples)));
  }

  // Each job's states follow each other as docs/api.md says.
  void judge_events() {
    static const std::map<std::string, std::set<std::string>> kNext = {
        {"", {"queued"}},
        {"queued", {"preparing", "paused", "canceled", "failed"}},
        {"preparing", {"learning", "rendering", "pausing", "canceling", "failed", "queued"}},
        {"rendering", {"finalizing", "pausing", "canceling", "failed", "queued"}},
        {"finalizing", {"succeeded", "canceling", "failed", "queued"}},
        {"pausing", {"paused", "canceling", "failed"}},
        {"paused", {"queued", "canceled"}},
        {"canceling", {"canceled"}},
        {"succeeded", {"queued"}}};
    std::map<std::string, std::string> states;
    uint64_t newest = 0;
    const EventLog::Batch batch = events_.wait(0, "", std::chrono::milliseconds(0));
    if (batch.reset) return;  // the first ones went with a job that was removed
    for (const Event& event : batch.events) {
      if (event.id <= std::exchange(newest, event.id)) fail("events do not rise");
      if (event.kind == "deleted") states.erase(event.job);
      if (event.kind != "state") continue;
      std::string& state = states[event.job];
      const std::string next = state_in(event.data);
      const auto may = kNext.find(state);
      if (may == kNext.end() || !may->second.contains(next))
        fail(event.job + " went from " + state + " to " + next);
      state = next;
    }
    for (const JobRecord& job : list())
      if (states[job.id.text()] != to_string(job.state))
        fail(job.id.text() + " is " + std::string(to_string(job.state)) + ", its events say " +
             states[job.id.text()]);
  }

  const Order& order_;
  EventLog events_;
  SteadyClock clock_;
  std::unique_ptr<Records> records_;
  JobStore* jobs_ = nullptr;
  std::unique_ptr<TableStore> tables_;
  std::unique_ptr<WeightsStore> weights_;
  std::unique_ptr<ResultStore> results_;
  std::unique_ptr<CheckpointStore> checkpoints_;
  std::unique_ptr<MomentStore> moments_;
  std::set<JobId> rendering_;
  int runs_ = 0;
  bool leave_ = false;
  std::unique_ptr<JobRunner> runner_;
};

}  // namespace

Shared& shared() {
  static Shared* const memory = [] {
    void* made =
        ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (made == MAP_FAILED) std::abort();
    return static_cast<Shared*>(made);
  }();
  return *memory;
}

void fail(const std::string& text) {
  char* all = shared().failure;
  const size_t used = std::strlen(all);
  std::snprintf(all + used, sizeof shared().failure - used, "%s\n", text.c_str());
}

void live(const Order& order, int life) {
  ::alarm(kMostSeconds);
  qray::test::count_changes_here();
  qray::test::run_one_at_a_time(order.seed * 31 + static_cast<uint64_t>(life), fail);
  {
    Server server(order);
    if (!server.start()) {
      fault_plan().armed = false;  // somebody makes room
      ::_exit(0);
    }
    if (shared().settled) {  // after one more start: the same, and no file that nobody lists
      server.judge();
      server.judge_folders();
      shared().ended = true;
    } else {
      server.serve();
      bool done = true;
      for (int c = 0; c < Order::kClients; ++c)
        done &= static_cast<size_t>(shared().next_step[c]) >= order.steps[c].size();
      if (done) {
        server.settle();
        server.judge();
        shared().settled = true;
      }
    }
    server.stop();
  }
  ::_exit(0);
}

}  // namespace qray::server::test
