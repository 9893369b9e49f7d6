// What a server that ends at a bad moment leaves in its data folder, and what the next start makes
// of that.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include "server/sqlite/database.h"
#include "tests/server/test_service.h"

namespace qray::server {
namespace {

namespace fs = std::filesystem;
using test::Json;
using test::TestService;

Json tiny(int samples = 4) {
  return {{"scene", "box"},
          {"width", 32},
          {"height", 32},
          {"samples", samples},
          {"learning_samples", 2}};
}

// The database of a server that does not run.
void change(const fs::path& data, const char* sql) {
  Result<std::unique_ptr<Database>> db = Database::open(data / "qray.sqlite");
  ASSERT_TRUE(db.ok());
  const Status done = Database::Session(*db.value()).exec(sql);
  ASSERT_TRUE(done.ok()) << done.error().text();
}

TEST(ServiceLeftovers, FilesOfDeletedJobsAndTablesGo) {
  TestService s;
  s.start();
  const std::string kept = s.submit(tiny()), deleted = s.submit(tiny());
  s.wait_end(kept);
  const std::string table = s.wait_end(deleted)["table_out"];
  s.stop();
  // As if the server had been killed between the deletion of the record and that of the files.
  change(s.config.data, ("DELETE FROM jobs WHERE id=2; DELETE FROM tables WHERE id='" + table +
                         "'; UPDATE jobs SET state='rendering' WHERE id=1")
                            .c_str());
  const std::string half = ".tmp.123.4";
  for (const std::string& name : {"results/" + kept + "/image.exr", "checkpoints/" + kept,
                                  "tables/" + table + ".qrt", std::string("weights/w.qrw")})
    test::write_text(s.config.data / (name + half), "half of a file");
  s.start();
  for (const char* folder : {"results", "moments", "checkpoints"}) {
    EXPECT_FALSE(fs::exists(s.config.data / folder / deleted)) << folder;
    EXPECT_TRUE(fs::exists(s.config.data / folder / kept)) << folder;
  }
  EXPECT_FALSE(fs::exists(s.config.data / "tables" / (table + ".qrt")));
  for (const auto& entry : fs::recursive_directory_iterator(s.config.data))
    EXPECT_EQ(entry.path().string().find(half), std::string::npos) << entry.path();
  EXPECT_TRUE(fs::is_empty(s.config.data / "quarantine"));
  EXPECT_EQ(s.wait_end(kept)["state"], "succeeded");
}

TEST(ServiceLeftovers, ATableWhoseFileIsGoneIsNotListed) {
  TestService s;
  s.start();
  const std::string table = s.wait_end(s.submit(tiny()))["table_out"];
  ASSERT_EQ(s.get("/v1/tables")["tables"].size(), 1u);
  s.stop();
  fs::remove(s.config.data / "tables" / (table + ".qrt"));
  s.start();
  EXPECT_TRUE(s.get("/v1/tables")["tables"].empty());
  // Or gone while the server runs.
  const std::string next = s.wait_end(s.submit(tiny()))["table_out"];
  fs::remove(s.config.data / "tables" / (next + ".qrt"));
  EXPECT_EQ(s.wait_end(s.submit(tiny(8)))["warnings"].size(), 1u);
  const Json listed = s.get("/v1/tables");
  for (const Json& left : listed["tables"])
    EXPECT_TRUE(fs::exists(s.config.data / "tables" / (left["id"].get<std::string>() + ".qrt")));
}

// A database that was put back from a copy, or whose newest part was lost.
TEST(ServiceLeftovers, WhatTheDatabaseForgotIsSetAsideAndNoIdIsGivenTwice) {
  TestService s;
  s.start();
  const std::string first = s.submit(tiny());
  s.wait_end(first);
  s.stop();
  fs::copy_file(s.config.data / "qray.sqlite", s.scratch / "old.sqlite");
  s.start();
  const std::string second = s.submit(tiny(8));
  const std::string table = s.wait_end(second)["table_out"];
  s.stop();
  fs::copy_file(s.scratch / "old.sqlite", s.config.data / "qray.sqlite",
                fs::copy_options::overwrite_existing);
  s.start();
  EXPECT_TRUE(fs::exists(s.config.data / "results" / first));
  EXPECT_FALSE(fs::exists(s.config.data / "results" / second));
  EXPECT_TRUE(fs::exists(s.config.data / "quarantine" / ("results-" + second) / "image.exr"));
  EXPECT_TRUE(fs::exists(s.config.data / "quarantine" / ("tables-" + table + ".qrt")));
  const std::string third = s.submit(tiny());
  EXPECT_EQ(third, "j000003");
  s.wait_end(third);
  s.stop();
  // All of it lost.
  for (const char* name : {"qray.sqlite", "qray.sqlite-wal", "qray.sqlite-shm"})
    fs::remove(s.config.data / name);
  s.start();
  EXPECT_EQ(s.submit(tiny()), "j000004");
  EXPECT_TRUE(fs::exists(s.config.data / "quarantine" / ("results-" + first)));
}

// Damage that no write of ours makes.
TEST(ServiceLeftovers, ADamagedRowIsListedAsFailedAndCanBeDeleted) {
  TestService s;
  s.start();
  const std::string whole = s.submit(tiny()), ended = s.submit(tiny());
  s.wait_end(ended);
  s.stop();
  change(s.config.data,
         "DROP TRIGGER labels_of_a_changed_job; UPDATE jobs SET request='{', stats='{' WHERE id=2;"
         "INSERT INTO jobs(id, state, request, created_ms) VALUES(3, 'queued', '{}', 1)");
  s.start();
  const Json jobs = s.get("/v1/jobs")["jobs"];
  ASSERT_EQ(jobs.size(), 3u);
  for (const size_t i : {0, 1}) {
    EXPECT_EQ(jobs[i]["state"], "failed");
    EXPECT_NE(jobs[i]["error"]["message"].get<std::string>().find("damaged"), std::string::npos);
    const std::string path = "/v1/jobs/" + jobs[i]["id"].get<std::string>();
    EXPECT_EQ(s.get(path)["state"], "failed");
    EXPECT_EQ(s.client().Delete(path)->status, 204);
  }
  EXPECT_EQ(s.get("/v1/jobs")["jobs"].size(), 1u);
  EXPECT_EQ(s.wait_end(s.submit(tiny()))["state"], "succeeded");
}

TEST(ServiceLeftovers, APictureThatIsCutOffIsTheServersFault) {
  TestService s;
  s.start();
  const std::string id = s.submit(tiny()), path = "/v1/jobs/" + id;
  s.wait_end(id);
  s.stop();
  const fs::path file = s.config.data / "results" / id / "image.exr";
  fs::resize_file(file, fs::file_size(file) * 2 / 3);
  s.start();
  for (const char* what : {"/image.exr", "/image.png", "/tiles"})
    EXPECT_EQ(s.client().Get(path + what)->status, 500) << what;
}

// While it lives no other connection can write: to a server, a disk that takes nothing.
class LockedDatabase {
 public:
  explicit LockedDatabase(const fs::path& data) {
    EXPECT_EQ(sqlite3_open((data / "qray.sqlite").c_str(), &db_), SQLITE_OK);
    sqlite3_busy_timeout(db_, 5000);
    EXPECT_EQ(sqlite3_exec(db_, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  }
  ~LockedDatabase() { sqlite3_close(db_); }

 private:
  sqlite3* db_ = nullptr;
};

TEST(ServiceLeftovers, AQueuedJobThatCannotBePausedOrCanceledRuns) {
  TestService s;
  s.start();
  const std::string first = s.submit(tiny(1'000'000)), queued = s.submit(tiny());
  s.wait(first, {"learning", "rendering"});
  {
    const LockedDatabase full(s.config.data);
    for (const char* what : {"/pause", "/cancel"}) s.post("/v1/jobs/" + queued + what, "", 503);
  }
  EXPECT_EQ(s.get("/v1/jobs/" + queued)["state"], "queued");
  s.post("/v1/jobs/" + first + "/cancel", "", 202);
  EXPECT_EQ(s.wait_end(queued)["state"], "succeeded");
}

TEST(ServiceLeftovers, AJobWhoseStateTheDiskDoesNotTakeWaits) {
  TestService s;
  s.start();
  const std::string running = s.submit(tiny(400)), queued = s.submit(tiny());
  s.wait(running, {"learning", "rendering"});
  {
    const LockedDatabase full(s.config.data);
    std::this_thread::sleep_for(std::chrono::seconds(4));  // it ends, and the other would begin
    EXPECT_NE(s.get("/v1/jobs/" + running)["state"], "succeeded");
    EXPECT_EQ(s.get("/v1/jobs/" + queued)["state"], "queued");
  }
  EXPECT_EQ(s.wait_end(running)["state"], "succeeded");
  EXPECT_EQ(s.wait_end(queued)["state"], "succeeded");
}

// A job that was interrupted twice, or the one beside it, ends the server: each runs alone next.
TEST(ServiceLeftovers, SuspectsRunAlone) {
  TestService s;
  s.config.jobs_at_once = 3;
  s.start();
  const std::string a = s.submit(tiny(1'000'000)), b = s.submit(tiny(1'000'000));
  s.wait(b, {"learning", "rendering"});
  s.stop();
  const fs::path states = s.config.data / "checkpoints";
  fs::remove_all(states);
  change(s.config.data, "UPDATE jobs SET attempts=2");
  s.start();
  const auto queued = [&](const std::string& id) {
    return s.get("/v1/jobs/" + id)["state"] == "queued";
  };
  while (queued(a) && queued(b)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const std::string first = queued(a) ? b : a, second = queued(a) ? a : b;
  const std::string other = s.submit(tiny(1'000'000));
  // Until it has a state on disk, which is after a second.
  for (bool alone = true; !fs::exists(states / first);) {
    alone = queued(second) && queued(other);
    ASSERT_TRUE(alone || fs::exists(states / first));
  }
  // Then the second waits to be alone, and the other, which is no suspect, for that.
  s.post("/v1/jobs/" + first + "/cancel", "", 202);
  s.wait(other, {"learning", "rendering"});
  EXPECT_TRUE(fs::exists(states / second));
  for (const std::string& id : {second, other}) s.post("/v1/jobs/" + id + "/cancel", "", 202);
}

}  // namespace
}  // namespace qray::server
