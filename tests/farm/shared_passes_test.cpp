// One picture on several workers: whoever samples what, it has the bits of one machine.
// QRAY_FARM_SCENES=all goes through all included scenes, with two and with four workers.
#include "core/job/load_and_prepare.h"
#include "core/render/unit_renderer.h"
#include "core/settings/job_settings.h"
#include "server/jobs/bits_of_machine.h"
#include "server/jobs/unit_loop.h"
#include "server/postgres/pg_records.h"
#include "tests/farm/farm.h"

namespace qray::server {
namespace {

using test::Json;
using test::Process;

class SharedPassesTest : public test::FarmTest {
 protected:
  void SetUp() override {
    FarmTest::SetUp();
    config_.scenes = qray::test::source_dir() / "scenes";
  }
  struct Made {
    std::string picture, table;
    Json job;
    bool operator==(const Made& other) const {
      return picture == other.picture && table == other.table;
    }
  };
  static std::string file(const std::filesystem::path& path) {
    std::ostringstream bytes;
    bytes << std::ifstream(path, std::ios::binary).rdbuf();
    return bytes.str().empty() ? "" : test::sha(bytes.str());
  }
  // A table's name is the hash of its bytes.
  static Made made(const Process& server, const std::filesystem::path& data, const Json& request) {
    const std::string id = server.submit(request);
    Made made;
    made.job = server.wait_state(id, "succeeded");
    made.picture = picture_in(data, id);
    EXPECT_FALSE(made.picture.empty());
    if (made.job["table_out"].is_string()) made.table = made.job["table_out"];
    return made;
  }
  // With all that was made beside it.
  static std::string picture_in(const std::filesystem::path& data, const std::string& id) {
    std::map<std::string, std::string> hashes;
    for (const auto& entry : std::filesystem::directory_iterator(data / "results" / id))
      if (entry.path().extension() == ".exr") hashes[entry.path().filename()] = file(entry.path());
    std::string all;
    for (const auto& [name, hash] : hashes) all += name + " " + hash + "\n";
    return all;
  }
  std::vector<Made> made_alone(const std::vector<Json>& requests, int threads = 1) {
    Config alone = config_;
    alone.store.clear();
    alone.data = scratch_ / "alone";
    std::vector<Made> all;
    {
      const Process server(alone, "", false, "", threads);
      for (const Json& request : requests) all.push_back(made(server, alone.data, request));
    }
    std::filesystem::remove_all(alone.data);
    return all;
  }
  static std::string log_of(const Process& front, const std::string& id) {
    const auto answer = httplib::Client("127.0.0.1", front.port()).Get("/v1/jobs/" + id + "/log");
    return answer ? answer->body : "";
  }
};

// Units, as the job's log tells them.
uint64_t sampled_by_others(const std::string& log) {
  constexpr std::string_view kSays = ") sampled ";
  const size_t at = log.find(kSays);
  EXPECT_NE(at, std::string::npos) << log;
  return at == std::string::npos ? 0 : std::strtoull(&log[at + kSays.size()], nullptr, 10);
}

Json request_of(const std::string& scene, const char* method, int samples) {
  return {{"scene", scene},     {"method", method}, {"width", 200},     {"height", 130},
          {"samples", samples}, {"seed", 4},        {"workers", "auto"}};
}

// Cold, with layers and a region that comes first, then warm with the table that this left; then a
// quarter of the pixels, recovered.
std::vector<Json> requests_of(const std::string& scene, int samples) {
  Json cold = request_of(scene, "adaptive", samples), warm = cold,
       quarter = request_of(scene, "none", samples);
  warm["seed"] = 5;
  cold["light_groups"] = "each";
  cold["passes"] = {"bounces", "indirect"};
  cold["region"] = {{"x", 20}, {"y", 30}, {"width", 90}, {"height", 70}};
  quarter["pixels"] = "quarter";
  quarter["recover"] = "default";
  return {request_of(scene, "none", samples), cold, warm, quarter};
}

TEST_F(SharedPassesTest, APictureHasTheBitsOfOneMachine) {
  const char* wanted = std::getenv("QRAY_FARM_SCENES");
  const bool all = wanted && std::string(wanted) == "all";
  std::vector<std::string> scenes = {"ajar-door"};
  if (all)
    scenes = {"ajar-door",     "lamp-room", "thesis-room", "cornell-box",
              "glass-caustic", "furnace",   "many-lights"};
  const int samples = all ? 64 : 32;
  std::map<std::string, std::vector<Made>> alone;
  for (const std::string& scene : scenes) alone[scene] = made_alone(requests_of(scene, samples));
  for (const std::string& scene : all ? scenes : std::vector<std::string>()) {
    EXPECT_TRUE(made_alone(requests_of(scene, samples), 2) == alone[scene]) << scene;
  }
  for (const int workers : all ? std::vector{2, 4} : std::vector{3}) {
    config_.store = postgres_->url(postgres_->new_schema());
    config_.data = scratch_ / ("data-" + std::to_string(workers));
    const auto front = this->front();
    std::vector<std::unique_ptr<Process>> processes;
    for (int i = 0; i < workers; ++i)
      processes.push_back(worker("workers", !all && i == 0 ? 2 : 1));
    uint64_t of_others = 0;
    for (const std::string& scene : scenes) {
      const std::vector<Json> requests = requests_of(scene, samples);
      for (size_t i = 0; i < requests.size(); ++i) {
        const Made shared = made(*front, config_.data, requests[i]);
        EXPECT_EQ(shared.picture, alone[scene][i].picture) << requests[i];
        EXPECT_EQ(shared.table, alone[scene][i].table) << requests[i];
        of_others += sampled_by_others(log_of(*front, shared.job["id"]));
        if (all)
          std::printf("%s %d workers: %s %s%s\n", scene.c_str(), workers,
                      requests[i]["method"].get<std::string>().c_str(),
                      shared.picture.substr(0, 16).c_str(),
                      shared == alone[scene][i] ? "" : " DIFFERS");
      }
    }
    // On a busy machine a short job may be over before anybody helps.
    for (int more = 8 * samples; of_others == 0 && more <= 512 * samples; more *= 4) {
      const Made job = made(*front, config_.data, request_of(scenes[0], "none", more));
      of_others += sampled_by_others(log_of(*front, job.job["id"]));
    }
    EXPECT_GT(of_others, 0u) << "nobody helped";
    const Json listed = front->get("/v1/workers");
    for (const Json& one : listed["workers"]) EXPECT_EQ(one["aside"], "") << one;
  }
}

TEST_F(SharedPassesTest, WhatLearnsInOrderAndWhatHasManyFramesStaysWhole) {
  const auto front = this->front(), one = worker(), other = worker();
  Json huang = request_of("cornell-box", "huang", 4);
  const Json done = made(*front, config_.data, huang).job;
  EXPECT_NE(done["warnings"].dump().find("workers"), std::string::npos) << done;
  Json frames = request_of("cornell-box", "none", 2);
  frames["frames"] = {{"turntable", 2}};
  const std::string id = front->submit(frames);
  EXPECT_NE(front->wait_state(id, "succeeded")["warnings"].dump().find("many frames"),
            std::string::npos);
}

// A worker whose memory is bad, or whose library is another one.
TEST_F(SharedPassesTest, AWorkerThatMakesOtherBitsIsPutAside) {
  const Json request = request_of("cornell-box", "adaptive", 64);
  const Made alone = made_alone({request})[0];
  const auto front = this->front(), owner = worker();
  EventLog events;
  const auto records =
      open_pg_records(config_.store, events, [] { return int64_t{0}; }, {false}).value();
  SharedPasses& passes = *records->passes();
  WorkerInfo me;
  me.kind = "worker";
  me.bits = bits_of_machine();
  ASSERT_TRUE(records->shared()->present(me).ok());

  const std::string id = front->submit(request);
  std::optional<SharedPasses::Open> open;
  for (int i = 0; i < 2000 && !open; ++i) {
    open = passes.find(me.bits).value();
    if (!open) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(open) << "no pass was shared";
  ASSERT_TRUE(passes.join(*open).value());
  const auto scene = load_and_prepare_scene(config_.scenes / "cornell-box/scene.json", 1).value();
  const JobRequest asked = records->jobs().get(open->job).value().request;
  const RenderSettings settings = settings_of(asked, scene->scene);
  TaskPool pool(1);
  const auto renderer = UnitRenderer::make(*scene, settings, pool).value();
  const SteadyClock clock;
  int spoiled = 0;
  UnitLoop loop(passes, *renderer, clock,
                [&](const SharedPasses::Pass& pass, SharedPasses::Unit unit) {
                  unit.sampled[unit.sampled.size() / 2] ^= 1;
                  unit.hash = hash_of_unit(unit.sampled);
                  const Result<SharedPasses::Put> put = passes.put(pass.key, unit);
                  if (put.ok() && put.value() != SharedPasses::Put::kLate) ++spoiled;
                });
  std::optional<SharedPasses::Key> last;
  std::string aside;
  for (int i = 0; i < 4000 && aside.empty(); ++i) {
    const auto pass = passes.next(*open, last);
    ASSERT_TRUE(pass.ok());
    if (pass.value() && loop.start(*pass.value())) {
      last = pass.value()->key;
      loop.run(*pass.value(), [&] { return spoiled == 0; }, {});
    }
    const Json all = front->get("/v1/workers");
    for (const Json& one : all["workers"])
      if (one["id"] == passes.me()) aside = one["aside"];
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GT(spoiled, 0);
  EXPECT_NE(aside, "") << "nobody noticed";
  EXPECT_FALSE(records->shared()->present(me).value()) << "it is to take no more jobs";
  EXPECT_FALSE(passes.find(me.bits).value()) << "nor parts of others'";
  const Json done = front->wait_state(id, "succeeded");
  EXPECT_NE(done["warnings"].dump().find("was put aside"), std::string::npos) << done;
  EXPECT_EQ(picture_in(config_.data, id), alone.picture);
  EXPECT_EQ(done["table_out"], alone.table);
}

TEST_F(SharedPassesTest, WhoseBitsMayDifferTakesNoPartAndThatIsSaid) {
  const auto front = this->front(), owner = worker();
  EventLog events;
  const auto records =
      open_pg_records(config_.store, events, [] { return int64_t{0}; }, {false}).value();
  WorkerInfo me;
  me.kind = "worker";
  me.bits = "another build";
  me.threads = 1;
  ASSERT_TRUE(records->shared()->present(me).ok());
  const std::string id = front->submit(request_of("cornell-box", "none", 16));
  for (int i = 0; i < 200; ++i) EXPECT_FALSE(records->passes()->find(me.bits).value());
  const Json done = front->wait_state(id, "succeeded");
  EXPECT_NE(done["warnings"].dump().find("takes no part"), std::string::npos) << done;
}

}  // namespace
}  // namespace qray::server
