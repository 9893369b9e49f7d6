// Each operation of the server is cut off, or meets a disk that fails, at each change of a file
// that it makes. What a client was told must hold afterwards, and nothing may be left lying.
// QRAY_CRASH_STRIDE=1 tries all points; usually it is a few, spread over all, of each fault other
// ones. On PostgreSQL the k-th statement counts as well: the server is killed before it is sent or
// before it is answered, or the line is cut.
#include <gtest/gtest.h>

#include "core/base/file.h"
#include "tests/crash/trial.h"
#include "tests/support/sanitized.h"

namespace qray::server::test {
namespace {

using Is = Model::Is;

constexpr int64_t kUsualTrials = 5;            // of an operation and a fault
constexpr int64_t kUsualTrialsOnPostgres = 1;  // each waits for a lease to end

Json tiny(const char* table = "auto", int samples = 4) {
  return {{"scene", "box"}, {"width", 16},        {"height", 16},         {"method", "huang"},
          {"table", table}, {"samples", samples}, {"learning_samples", 2}};
}

Json endless() { return tiny("none", 1'000'000); }

std::string submit(ChildServer& server, const Json& request) {
  const ChildServer::Answer made = server.post("/v1/jobs", request);
  EXPECT_EQ(made.status, 202) << made.body;
  return made.yes() ? made.json["id"].get<std::string>() : "";
}

// A job that has succeeded, with its picture.
Json finished(ChildServer& server, Model& model, const Json& request) {
  const std::string id = submit(server, request);
  EXPECT_EQ(server.wait(id, {"succeeded"}), "succeeded");
  model.jobs[id].picture = server.get("/v1/jobs/" + id + "/image.png").body;
  const Json job = server.get("/v1/jobs/" + id).json;
  if (job["table_out"].is_string()) model.tables[job["table_out"].get<std::string>()] = Is::kThere;
  return job;
}

// Where no answer came, or another than yes, either may be.
Is now_or(const ChildServer::Answer& answer, Is yes) { return answer.yes() ? yes : Is::kMaybe; }

const Operation kSubmit{"submit", [](ChildServer&, Model&) {},
                        [](ChildServer& server, Model& model, const auto& arm) {
                          arm();
                          const auto made = server.post("/v1/jobs", tiny());
                          if (made.yes()) {
                            const std::string id = made.json["id"];
                            model.jobs[id];
                            server.wait(id, {"succeeded", "failed"}, std::chrono::seconds(3));
                          } else {
                            ++model.unknown_jobs;
                          }
                          model.more_tables = true;
                        }};

// Resumed, it is claimed, learns, and leaves a table, a picture, a state and moments.
const Operation kRun{"run",
                     [](ChildServer& server, Model& model) {
                       const std::string wanted = finished(server, model, tiny())["id"];
                       const std::string picture = *model.jobs[wanted].picture;
                       const std::string table = model.tables.begin()->first;
                       EXPECT_EQ(server.call("DELETE", "/v1/jobs/" + wanted).status, 204);
                       EXPECT_EQ(server.call("DELETE", "/v1/tables/" + table).status, 204);
                       model = {};
                       const std::string blocking = submit(server, endless());
                       const std::string id = submit(server, tiny());
                       EXPECT_TRUE(server.post("/v1/jobs/" + id + "/pause", {}).yes());
                       EXPECT_TRUE(server.post("/v1/jobs/" + blocking + "/cancel", {}).yes());
                       EXPECT_EQ(server.wait(blocking, {"canceled"}), "canceled");
                       EXPECT_EQ(server.call("DELETE", "/v1/jobs/" + blocking).status, 204);
                       model.jobs[id].picture = picture;
                     },
                     [](ChildServer& server, Model& model, const auto& arm) {
                       const std::string id = model.jobs.begin()->first;
                       arm();
                       if (server.post("/v1/jobs/" + id + "/resume", {}).yes())
                         server.wait(id, {"succeeded", "failed"}, std::chrono::seconds(3));
                     }};

const Operation kPause{"pause",
                       [](ChildServer& server, Model& model) {
                         const std::string id = submit(server, endless());
                         server.wait(id, {"learning", "rendering"});
                         EXPECT_TRUE(server.post("/v1/jobs/" + id + "/pause", {}).yes());
                         EXPECT_EQ(server.wait(id, {"paused"}), "paused");
                         model.jobs[id].ends = {"canceled"};
                       },
                       [](ChildServer& server, Model& model, const auto& arm) {
                         const std::string id = model.jobs.begin()->first;
                         const std::string path = "/v1/jobs/" + id;
                         (void)server.post(path + "/resume", {});
                         server.wait(id, {"learning", "rendering"});
                         arm();
                         if (server.post(path + "/pause", {}).yes())
                           server.wait(id, {"paused"}, std::chrono::seconds(3));
                       }};

const Operation kCancel{"cancel", kPause.prepare,
                        [](ChildServer& server, Model& model, const auto& arm) {
                          const std::string id = model.jobs.begin()->first;
                          const std::string path = "/v1/jobs/" + id;
                          (void)server.post(path + "/resume", {});
                          server.wait(id, {"learning", "rendering"});
                          arm();
                          if (server.post(path + "/cancel", {}).yes())
                            server.wait(id, {"canceled"}, std::chrono::seconds(3));
                        }};

// One that waits behind another. It must run all the same: it was not canceled.
const Operation kHoldQueued{"pause and resume what is queued",
                            [](ChildServer& server, Model& model) {
                              const std::string first = submit(server, endless());
                              server.wait(first, {"learning", "rendering"});
                              model.jobs[first].ends = {"canceled"};
                              model.jobs[submit(server, tiny("none"))];
                            },
                            [](ChildServer& server, Model& model, const auto& arm) {
                              server.wait(model.jobs.begin()->first, {"learning", "rendering"});
                              const std::string path = "/v1/jobs/" + model.jobs.rbegin()->first;
                              arm();
                              (void)server.post(path + "/pause", {});
                              (void)server.post(path + "/resume", {});
                            }};

const Operation kExtend{
    "extend",
    [](ChildServer& server, Model& model) {
      const Json first = finished(server, model, tiny("none"));
      const std::string path = "/v1/jobs/" + first["id"].get<std::string>();
      EXPECT_TRUE(server.post(path + "/extend", {{"samples", 2}}).yes());
      EXPECT_EQ(server.wait(first["id"], {"succeeded"}), "succeeded");
      const std::string more = server.get(path + "/image.png").body;
      EXPECT_EQ(server.call("DELETE", path).status, 204);
      model = {};
      const Json again = finished(server, model, tiny("none"));
      EXPECT_NE(*model.jobs[again["id"].get<std::string>()].picture, more);
      model.jobs[again["id"].get<std::string>()].picture = more;
    },
    [](ChildServer& server, Model& model, const auto& arm) {
      const std::string id = model.jobs.begin()->first;
      arm();
      const auto extended = server.post("/v1/jobs/" + id + "/extend", {{"samples", 2}});
      if (extended.yes()) {
        server.wait(id, {"succeeded", "failed"}, std::chrono::seconds(3));
      } else {
        model.jobs[id].picture.reset();
      }
    }};

const Operation kDeleteJob{
    "delete a job", [](ChildServer& server, Model& model) { finished(server, model, tiny()); },
    [](ChildServer& server, Model& model, const auto& arm) {
      auto& [id, wanted] = *model.jobs.begin();
      arm();
      wanted.is = now_or(server.call("DELETE", "/v1/jobs/" + id), Is::kGone);
      wanted.picture.reset();  // half of its files may be gone: the next start
    }};

const Operation kDeleteJobs{"delete jobs that a filter finds",
                            [](ChildServer& server, Model& model) {
                              finished(server, model, tiny("none"));
                              finished(server, model, tiny("none", 8));
                            },
                            [](ChildServer& server, Model& model, const auto& arm) {
                              arm();
                              const auto gone = server.call("DELETE", "/v1/jobs?state=succeeded");
                              for (auto& [id, wanted] : model.jobs) {
                                wanted.is = Is::kMaybe;
                                wanted.picture.reset();
                              }
                              if (!gone.yes()) return;
                              for (const Json& id : gone.json["deleted"])
                                model.jobs[id.get<std::string>()].is = Is::kGone;
                            }};

const Operation kDeleteTable{"delete a table", kDeleteJob.prepare,
                             [](ChildServer& server, Model& model, const auto& arm) {
                               auto& [id, is] = *model.tables.begin();
                               arm();
                               is = now_or(server.call("DELETE", "/v1/tables/" + id), Is::kGone);
                             }};

const Operation kMerge{"merge tables",
                       [](ChildServer& server, Model& model) {
                         finished(server, model, tiny());
                         finished(server, model, tiny("auto", 8));
                         EXPECT_EQ(model.tables.size(), 2u);
                       },
                       [](ChildServer& server, Model& model, const auto& arm) {
                         Json ids;
                         for (const auto& [id, is] : model.tables) ids.push_back(id);
                         arm();
                         const auto merged = server.post("/v1/tables/merge", {{"tables", ids}});
                         if (merged.yes()) {
                           model.tables[merged.json["id"].get<std::string>()] = Is::kThere;
                         } else {
                           model.more_tables = true;
                         }
                       }};

// A table that was deleted comes back as a file.
const Operation kUploadTable{
    "upload a table",
    [](ChildServer& server, Model& model) {
      finished(server, model, tiny());
      const std::string id = model.tables.begin()->first;
      model.file = server.get("/v1/tables/" + id + "/file").body;
      EXPECT_EQ(server.call("DELETE", "/v1/tables/" + id).status, 204);
      model.tables[id] = Is::kGone;
    },
    [](ChildServer& server, Model& model, const auto& arm) {
      auto& [id, is] = *model.tables.begin();
      arm();
      is = now_or(server.call("POST", "/v1/tables", model.file, "application/octet-stream"),
                  Is::kThere);
    }};

const Operation kChange{"change a job", kDeleteJob.prepare,
                        [](ChildServer& server, Model& model, const auto& arm) {
                          arm();
                          (void)server.call("PATCH", "/v1/jobs/" + model.jobs.begin()->first,
                                            R"({"labels":{"a":"b"},"priority":2})");
                        }};

const Operation kUpload{
    "upload a scene", [](ChildServer&, Model&) {},
    [](ChildServer& server, Model& model, const auto& arm) {
      const std::string text = kBoxScene, asset = sha(text);
      arm();
      const auto put = server.call("PUT", "/v1/assets/" + asset, text, "application/octet-stream");
      if (!put.yes()) return;
      const auto made = server.post("/v1/scenes", {{"files", {{"scene.json", asset}}}});
      if (made.yes()) model.scenes[made.json["name"].get<std::string>()] = Is::kThere;
    }};

const Operation kDeleteScene{"delete a scene",
                             [](ChildServer& server, Model& model) {
                               kUpload.act(server, model, [] {});
                               EXPECT_EQ(model.scenes.size(), 1u);
                             },
                             [](ChildServer& server, Model& model, const auto& arm) {
                               auto& [name, is] = *model.scenes.begin();
                               arm();
                               is = now_or(server.call("DELETE", "/v1/scenes/" + name), Is::kGone);
                             }};

const Operation kTitleScene{
    "give a scene a title",
    [](ChildServer& server, Model& model) { kUpload.act(server, model, [] {}); },
    [](ChildServer& server, Model& model, const auto& arm) {
      const std::string name = model.scenes.begin()->first;
      arm();
      const auto titled = server.call("PATCH", "/v1/scenes/" + name, R"({"title":"Kitchen"})");
      model.titles[name] = {"Kitchen"};
      if (!titled.yes()) model.titles[name].insert(name);
    }};

const Operation kThumbnail{"make a small picture of a scene", [](ChildServer&, Model&) {},
                           [](ChildServer& server, Model&, const auto& arm) {
                             arm();
                             (void)server.get("/v1/scenes/box/thumbnail.jpg");
                           }};

const Operation kUploadNetwork{
    "upload and delete a network", [](ChildServer&, Model&) {},
    [](ChildServer& server, Model& model, const auto& arm) {
      const Result<Bytes> file =
          read_file(qray::test::source_dir() / "core/recover/default.qrw", 1 << 20);
      ASSERT_TRUE(file.ok());
      const std::string bytes(file.value().begin(), file.value().end());
      arm();
      const auto kept = server.call("POST", "/v1/weights", bytes, "application/octet-stream");
      if (!kept.yes()) return;
      Is& is = model.weights[kept.json["id"].get<std::string>()];
      is = now_or(server.call("DELETE", "/v1/weights/" + model.weights.begin()->first), Is::kGone);
    }};

// To an address that takes nothing: what it is to be told waits.
const Operation kWebhook{
    "tell a webhook", [](ChildServer&, Model&) {},
    [](ChildServer& server, Model& model, const auto& arm) {
      arm();
      const auto added = server.post("/v1/webhooks", {{"url", "http://127.0.0.1:9/"}});
      if (!added.yes()) return;
      model.webhooks[added.json["id"].get<std::string>()] = Is::kThere;
      const auto made = server.post("/v1/jobs", tiny("none"));
      if (made.yes()) {
        const std::string id = made.json["id"];
        model.jobs[id];
        model.waiting = 1;
        server.wait(id, {"succeeded", "failed"}, std::chrono::seconds(3));
      } else {
        ++model.unknown_jobs;
      }
    }};

const Operation kLeaveSession{
    "leave a session", [](ChildServer&, Model&) {},
    [](ChildServer& server, Model& model, const auto& arm) {
      model.more_tables = true;
      const Json wanted = {{"scene", "box"}};
      const auto session = server.post("/v1/live", wanted);
      ASSERT_TRUE(session.yes()) << session.body;
      const std::string id = session.json["id"], path = "/v1/live/" + id;
      RawConnection frames(server.port());
      frames.send("GET " + path + "/frames HTTP/1.1\r\nHost: localhost\r\n\r\n");
      for (size_t read = 0; read < 100'000;) {  // some frames
        const size_t more = frames.read_some(1 << 16).size();
        if (more == 0) break;
        read += more;
      }
      arm();
      (void)server.call("DELETE", path);
      for (int i = 0; i < 1000 && server.alive(); ++i) {
        if (!server.get("/v1/tables").json["tables"].empty()) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    }};

// A server that was killed at work starts: its jobs go on, and one that ended long ago goes.
const Operation kStart{
    "start",
    [](ChildServer& server, Model& model) {
      for (const char* ends : {"succeeded", "canceled"}) {
        Json request = tiny();
        if (*ends == 'c') request = endless();
        const std::string id = submit(server, request);
        model.jobs[id].ends = {ends};
        model.jobs[id].is = Is::kMaybe;  // none that has ended is kept
        if (*ends == 's') {
          EXPECT_EQ(server.wait(id, {ends}), ends);
        } else {
          server.wait(id, {"learning", "rendering"});
        }
      }
      model.more_tables = true;
    },
    [](ChildServer& server, Model& model, const auto&) {
      server.wait(model.jobs.rbegin()->first, {"learning", "rendering"}, std::chrono::seconds(3));
    },
    /*at_start=*/true, /*keep_days=*/1e-9};

// Each operation beside faults, with records where `postgres` says.
void try_faults(const Operation& operation, Postgres postgres, int64_t trials) {
  const char* given = std::getenv("QRAY_CRASH_STRIDE");
  const int64_t changes = count_changes(operation, postgres);
  ASSERT_GT(changes, 0);
  const int64_t stride = given ? std::max(1, std::atoi(given)) : 1 + changes / trials;
  int64_t tried = 0;
  for (int f = 0; f < 4; ++f)
    for (int64_t k = 1 + (f * 3 + changes) % stride; k <= changes; k += stride, ++tried)
      try_fault(operation, postgres, static_cast<qray::test::Fault>(f), k);
  std::printf("%s: %lld changes, %lld trials\n", operation.name, static_cast<long long>(changes),
              static_cast<long long>(tried));
}

class CrashTest : public ::testing::TestWithParam<const Operation*> {
 protected:
  void SetUp() override {
    if (qray::test::kSanitized)
      GTEST_SKIP() << "sanitizers have functions of the C library themselves";
  }
};

TEST_P(CrashTest, WhatWasToldHolds) { try_faults(*GetParam(), nullptr, kUsualTrials); }

#ifdef QRAY_POSTGRES
TEST_P(CrashTest, OnPostgreSqlToo) {
  const Postgres postgres = qray::test::PostgresServer::instance();
  if (!postgres) GTEST_SKIP() << qray::test::PostgresServer::why();
  try_faults(*GetParam(), postgres, kUsualTrialsOnPostgres);
}
#endif

INSTANTIATE_TEST_SUITE_P(Operations, CrashTest,
                         ::testing::Values(&kSubmit, &kRun, &kPause, &kCancel, &kHoldQueued,
                                           &kExtend, &kDeleteJob, &kDeleteJobs, &kDeleteTable,
                                           &kMerge, &kUpload, &kDeleteScene, &kTitleScene,
                                           &kThumbnail, &kUploadNetwork, &kWebhook, &kLeaveSession,
                                           &kUploadTable, &kChange, &kStart),
                         [](const auto& info) {
                           std::string name = info.param->name;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

}  // namespace
}  // namespace qray::server::test
