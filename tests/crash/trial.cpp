#include "tests/crash/trial.h"

#include <spdlog/spdlog.h>
#include <sqlite3.h>
#include <sys/wait.h>

#include <csignal>

#include "tests/crash/plain_pictures.h"

namespace qray::server::test {
namespace {

namespace fs = std::filesystem;
using qray::test::Fault;
using qray::test::fault_plan;
using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;

constexpr seconds kMost{20};  // that a server may take for anything

bool wait_for(const std::function<bool()>& what, milliseconds most = kMost) {
  const auto deadline = steady_clock::now() + most;
  while (!what()) {
    if (steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(milliseconds(1));
  }
  return true;
}

[[noreturn]] void serve(const Config& config) {
  qray::test::FaultPlan& plan = fault_plan();
  qray::test::count_changes_here();
  Result<std::unique_ptr<Service>> service = Service::start(config);
  if (!service.ok()) {
    plan.armed = false;
    std::fprintf(stderr, "%s\n", service.error().text().c_str());
    plan.port = -1;
    ::_exit(1);
  }
  plan.port = service.value()->port();
  while (!plan.stop) std::this_thread::sleep_for(milliseconds(1));
  service.value()->stop();
  service.value().reset();
  ::_exit(0);
}

void expect_sound_database(const fs::path& file) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &db), SQLITE_OK);
  std::string said;
  const auto take = [](void* to, int, char** columns, char**) {
    *static_cast<std::string*>(to) += columns[0];
    return 0;
  };
  sqlite3_exec(db, "PRAGMA integrity_check", take, &said, nullptr);
  sqlite3_close(db);
  EXPECT_EQ(said, "ok");
}

// Names in a folder of the data folder; none where it is not there.
std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  std::error_code ec;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec))
    names.insert(it->path().filename().string());
  return names;
}

std::set<std::string> ids_of(const Json& list, const char* member) {
  std::set<std::string> ids;
  for (const Json& one : list) ids.insert(one[member].get<std::string>());
  return ids;
}

// Whatever was interrupted goes on, and what runs without end is canceled.
void settle(ChildServer& server, const Model& model) {
  const ChildServer::Answer list = server.get("/v1/jobs");
  ASSERT_EQ(list.status, 200) << list.body;
  for (const Json& job : list.json["jobs"]) {
    const std::string id = job["id"], path = "/v1/jobs/" + id;
    const auto wanted = model.jobs.find(id);
    const bool endless = wanted != model.jobs.end() && !wanted->second.ends.contains("succeeded");
    if (endless) {
      (void)server.post(path + "/cancel", {});  // or it has been
    } else if (job["state"] == "paused") {
      EXPECT_TRUE(server.post(path + "/resume", {}).yes()) << id;
    }
  }
  for (const Json& job : list.json["jobs"]) {
    const std::string id = job["id"];
    EXPECT_NE(server.wait(id, {"succeeded", "failed", "canceled", "gone"}), "")
        << id << " does not end: " << server.get("/v1/jobs/" + id).body;
  }
}

void judge_answers(ChildServer& server, const Model& model, bool may_fail) {
  const ChildServer::Answer list = server.get("/v1/jobs");
  ASSERT_EQ(list.status, 200) << list.body;
  size_t unknown = 0;
  std::set<std::string> tables_of_jobs;
  for (const Json& job : list.json["jobs"]) {
    const std::string id = job["id"];
    if (job["table_out"].is_string()) tables_of_jobs.insert(job["table_out"].get<std::string>());
    const auto wanted = model.jobs.find(id);
    if (wanted == model.jobs.end()) {
      ++unknown;
      continue;
    }
    EXPECT_NE(wanted->second.is, Model::Is::kGone) << id;
    const std::string state = job["state"];
    // One whose picture the disk did not take may fail, and says so.
    if (may_fail && state == "failed") {
      EXPECT_TRUE(job["error"]["message"].is_string());
      continue;
    }
    EXPECT_TRUE(wanted->second.ends.contains(state)) << job.dump();
    if (state != "succeeded") continue;
    const ChildServer::Answer picture = server.get("/v1/jobs/" + id + "/image.png");
    if (picture.status == 404 && wanted->second.is == Model::Is::kMaybe) continue;  // just expired
    EXPECT_EQ(picture.status, 200) << id;
    if (wanted->second.picture) {
      EXPECT_TRUE(picture.body == *wanted->second.picture) << id;
    }
  }
  const std::set<std::string> there = ids_of(list.json["jobs"], "id");
  for (const auto& [id, wanted] : model.jobs)
    EXPECT_TRUE(wanted.is != Model::Is::kThere || there.contains(id)) << id << " is lost";
  EXPECT_LE(unknown, model.unknown_jobs) << "jobs that nobody asked for";

  const std::set<std::string> tables = ids_of(server.get("/v1/tables").json["tables"], "id");
  const Json listed_scenes = server.get("/v1/scenes").json["scenes"];
  const std::set<std::string> scenes = ids_of(listed_scenes, "name");
  const std::set<std::string> weights = ids_of(server.get("/v1/weights").json["weights"], "id");
  const Json listed_webhooks = server.get("/v1/webhooks").json["webhooks"];
  const std::set<std::string> webhooks = ids_of(listed_webhooks, "id");
  for (const auto& [wanted, have] :
       {std::pair(&model.tables, &tables), std::pair(&model.scenes, &scenes),
        std::pair(&model.weights, &weights), std::pair(&model.webhooks, &webhooks)})
    for (const auto& [id, is] : *wanted)
      EXPECT_TRUE(is == Model::Is::kMaybe || have->contains(id) == (is == Model::Is::kThere)) << id;
  for (const Json& scene : listed_scenes) {
    const auto may = model.titles.find(scene["name"]);
    EXPECT_TRUE(may == model.titles.end() || may->second.contains(scene["title"])) << scene.dump();
  }
  for (const Json& webhook : listed_webhooks)
    EXPECT_GE(webhook["waiting"].get<size_t>(), model.waiting) << webhook.dump();
  for (const std::string& id : tables) {
    const bool known = model.tables.contains(id) || tables_of_jobs.contains(id);
    EXPECT_TRUE(known || model.more_tables) << id << " comes from nowhere";
  }
}

// Nothing is there that the server does not list.
void judge_folders(ChildServer& server, const fs::path& data) {
  const std::set<std::string> jobs = ids_of(server.get("/v1/jobs").json["jobs"], "id");
  for (const char* folder : {"results", "moments", "checkpoints"})
    for (const std::string& name : names_in(data / folder))
      EXPECT_TRUE(jobs.contains(name)) << folder << "/" << name;
  std::set<std::string> tables;
  for (const std::string& id : ids_of(server.get("/v1/tables").json["tables"], "id"))
    tables.insert(id + ".qrt");
  EXPECT_EQ(names_in(data / "tables"), tables);
  std::set<std::string> weights;
  for (const std::string& id : ids_of(server.get("/v1/weights").json["weights"], "id"))
    weights.insert(id + ".qrw");
  EXPECT_EQ(names_in(data / "weights"), weights);
  std::set<std::string> scenes;
  const Json listed = server.get("/v1/scenes").json["scenes"];
  for (const Json& scene : listed)
    if (const std::string name = scene["name"]; name.starts_with("up-")) scenes.insert(name);
  EXPECT_EQ(names_in(data / "scenes"), scenes);
  EXPECT_EQ(names_in(data / "quarantine"), std::set<std::string>());
  for (const auto& entry : fs::recursive_directory_iterator(data)) {
    const std::string name = entry.path().filename();
    EXPECT_TRUE(name.find(".tmp.") == std::string::npos && !name.ends_with(".part") &&
                !name.ends_with(".draft"))
        << entry.path();
  }
}

// What others may still be writing is left alone for some hours: they pass.
void age(const fs::path& data) {
  const auto before = fs::file_time_type::clock::now() - std::chrono::hours(48);
  for (const auto& entry : fs::recursive_directory_iterator(data))
    fs::last_write_time(entry, before);
}

// What prepare() made, once for each operation.
struct Prepared {
  qray::test::ScratchFolder scratch;
  Config config = scratch_config(scratch.path());
  std::string database;  // of PostgreSQL
  Model model;
};

const Prepared& prepared(const Operation& operation, Postgres postgres) {
  static std::map<std::pair<std::string, Postgres>, std::unique_ptr<Prepared>> all;
  std::unique_ptr<Prepared>& one = all[{operation.name, postgres}];
  if (one) return *one;
  spdlog::set_level(spdlog::level::off);
  use_image_library(plain_pictures());
  one = std::make_unique<Prepared>();
  one->config.threads = 1;
  one->config.program = qray::test::program("qrayd");
  if (postgres) {
    one->database = postgres->new_database();
    one->config.store = postgres->url_of(one->database);
    one->config.lease_seconds = 1;
  }
  ChildServer server(one->config);
  operation.prepare(server, one->model);
  if (operation.at_start) return *one;  // it is killed at work
  EXPECT_TRUE(server.stop());
  return *one;
}

// A copy of what is prepared, which goes with it.
class Copy {
 public:
  Copy(const Operation& operation, Postgres postgres)
      : postgres_(postgres), before_(prepared(operation, postgres)) {
    config = before_.config;
    config.data = scratch_ / "data";
    config.keep_days = operation.keep_days;
    fs::copy(before_.config.data, config.data, fs::copy_options::recursive);
    if (!postgres_) return;
    database_ = postgres_->new_database(before_.database);
    config.store = postgres_->url_of(database_);
  }
  ~Copy() {
    if (postgres_) postgres_->run("DROP DATABASE " + database_ + " WITH (FORCE)");
  }
  Copy(const Copy&) = delete;
  Copy& operator=(const Copy&) = delete;
  const Model& model() const { return before_.model; }

  Config config;

 private:
  qray::test::ScratchFolder scratch_;
  const Postgres postgres_;
  const Prepared& before_;
  std::string database_;
};

void arm(Fault fault, int64_t k) {
  qray::test::FaultPlan& plan = fault_plan();
  plan.fault = fault;
  plan.at = k;
  plan.changes = 0;
  plan.armed = true;
}

}  // namespace

ChildServer::ChildServer(const Config& config) {
  qray::test::FaultPlan& plan = fault_plan();
  plan.port = 0;
  plan.stop = false;
  std::fflush(nullptr);
  pid_ = ::fork();
  if (pid_ == 0) serve(config);
  wait_for([&] { return plan.port != 0 || !alive(); });
  port_ = plan.port;
}

ChildServer::~ChildServer() {
  if (!alive()) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

bool ChildServer::alive() {
  if (pid_ > 0 && ::waitpid(pid_, nullptr, WNOHANG) == pid_) pid_ = 0;
  return pid_ > 0;
}

ChildServer::Answer ChildServer::call(const std::string& method, const std::string& path,
                                      const std::string& body, const std::string& type) {
  if (port_ <= 0) return {};
  httplib::Client client("127.0.0.1", port_);
  client.set_read_timeout(kMost);
  httplib::Request request;
  request.method = method;
  request.path = path;
  request.body = body;
  if (!body.empty()) request.set_header("Content-Type", type);
  const httplib::Result result = client.send(request);
  if (!result) return {};
  return {result->status, Json::parse(result->body, nullptr, false), result->body};
}

std::string ChildServer::wait(const std::string& job, const std::set<std::string>& states,
                              milliseconds most) {
  std::string state;
  const bool there = wait_for(
      [&] {
        const Answer answer = get("/v1/jobs/" + job);
        if (answer.status == 200) state = answer.json["state"];
        if (answer.status == 404) state = "gone";
        return states.contains(state) || !alive();
      },
      most);
  return there && states.contains(state) ? state : "";
}

bool ChildServer::stop() {
  fault_plan().stop = true;
  return wait_for([&] { return !alive(); });
}

int64_t count_changes(const Operation& operation, Postgres postgres) {
  const Copy copy(operation, postgres);
  if (operation.at_start) arm(Fault::kKill, 0);
  ChildServer server(copy.config);
  Model model = copy.model();
  operation.act(server, model, [] { arm(Fault::kKill, 0); });
  fault_plan().armed = false;
  return fault_plan().changes;
}

void try_fault(const Operation& operation, Postgres postgres, Fault fault, int64_t k) {
  SCOPED_TRACE(std::string(operation.name) + ", " +
               qray::test::kFaultNames[static_cast<int>(fault)] + " at change " +
               std::to_string(k));
  Copy copy(operation, postgres);
  Config& config = copy.config;
  Model model = copy.model();

  // Step 1: the fault.
  const bool kills = fault == Fault::kKill || fault == Fault::kTorn;
  bool died = false;
  {
    if (operation.at_start) arm(fault, k);
    ChildServer server(config);
    if (server.alive()) operation.act(server, model, [&] { arm(fault, k); });
    fault_plan().armed = false;
    // It may be dying still.
    if (kills && fault_plan().changes >= k) wait_for([&] { return !server.alive(); });
    died = !server.alive();
    // A start may be refused by a disk that fails; nothing else ends the server.
    EXPECT_TRUE(!died || kills || operation.at_start) << "the server ended";
    if (!died) {
      // Step 2: without a restart, what was accepted comes to its end.
      EXPECT_EQ(server.get("/healthz").status, 200);
      // A line that was cut is tried again after a moment.
      EXPECT_TRUE(wait_for([&] { return server.get("/readyz").status == 200; }));
      settle(server, model);
      judge_answers(server, model, !kills);
      EXPECT_TRUE(server.stop()) << "it does not stop";
    }
  }
  // Step 3: after a restart, likewise.
  {
    ChildServer server(config);
    ASSERT_TRUE(server.alive()) << "it does not start again";
    settle(server, model);
    judge_answers(server, model, !kills);
    EXPECT_TRUE(server.stop());
  }
  // Step 4: what was left by the way has gone with the next start.
  config.keep_days = 0;
  if (postgres) age(config.data);
  ChildServer server(config);
  ASSERT_TRUE(server.alive());
  judge_folders(server, config.data);
  EXPECT_TRUE(server.stop());
  if (!postgres) expect_sound_database(config.data / "qray.sqlite");
}

}  // namespace qray::server::test
