// Tables over HTTP: one by its id, several merged, deleted.
#include <gtest/gtest.h>

#include "core/base/file.h"
#include "core/guide/open_table.h"
#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

class ServiceTables : public ::testing::Test {
 protected:
  void SetUp() override { s_.start(); }
  static Json request(const Json& changes = Json::object()) {
    Json request = {
        {"scene", "box"}, {"width", 24}, {"height", 24}, {"samples", 16}, {"learning_samples", 16}};
    request.update(changes);
    return request;
  }
  // Id of the table that such a job leaves; it may have grown from an earlier one's.
  std::string learned(const Json& changes = Json::object()) {
    const Json job = s_.wait_end(s_.submit(request(changes)));
    EXPECT_EQ(job["state"], "succeeded") << job.dump();
    return job.value("table_out", "");
  }
  static std::string body(const std::vector<std::string>& ids) {
    return Json{{"tables", ids}}.dump();
  }
  Json merge(const std::vector<std::string>& ids, int status) const {
    return s_.post("/v1/tables/merge", body(ids), status);
  }
  std::filesystem::path file(const std::string& id) const {
    return s_.config.data / "tables" / (id + ".qrt");
  }
  TestService s_;
};

TEST_F(ServiceTables, AreListedInPagesAndDownloaded) {
  std::vector<std::string> ids;
  for (int i = 1; i <= 3; ++i) ids.push_back(learned({{"seed", i}}));
  std::vector<std::string> seen;
  for (std::string before = "start"; !before.empty();) {
    const Json page = s_.get("/v1/tables?limit=2" + (before == "start" ? "" : "&before=" + before));
    EXPECT_LE(page["tables"].size(), 2u);
    for (const Json& table : page["tables"]) seen.insert(seen.begin(), table["id"]);
    before = page.value("next", "");
  }
  EXPECT_EQ(seen, ids);
  for (const char* wrong : {"limit=0", "limit=1001", "before=x"})
    s_.get(std::string("/v1/tables?") + wrong, 422);
  s_.get("/v1/tables?before=" + std::string(32, '0'), 404);

  const auto answer = s_.client().Get("/v1/tables/" + ids[0] + "/file");
  ASSERT_EQ(answer->status, 200);
  EXPECT_EQ(answer->get_header_value("Content-Disposition"),
            "attachment; filename=\"" + ids[0] + ".qrt\"");
  const Bytes bytes = read_file(file(ids[0]), 1 << 28).value();
  EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), answer->body.begin(), answer->body.end(),
                         [](uint8_t a, char b) { return a == static_cast<uint8_t>(b); }));
  s_.get("/v1/tables/" + std::string(32, '0') + "/file", 404);
}

TEST_F(ServiceTables, OneOfAnotherServerIsUploadedAndUsed) {
  const std::string id = learned();
  const std::string bytes = s_.client().Get("/v1/tables/" + id + "/file")->body;
  TestService other;
  other.start();
  const auto post = [&](const std::string& body, const char* query = "",
                        const char* type = "application/octet-stream") {
    return other.client().Post(std::string("/v1/tables") + query, body, type);
  };
  const auto made = post(bytes, "?scene=box");
  ASSERT_EQ(made->status, 201) << made->body;
  EXPECT_EQ(made->get_header_value("Location"), "/v1/tables/" + id);
  Json info = Json::parse(made->body), was = s_.get("/v1/tables/" + id);
  EXPECT_EQ(info, other.get("/v1/tables/" + id));
  EXPECT_TRUE(info["job"].is_null());
  for (const char* same : {"scene", "method", "parents", "bytes", "states", "samples_seen"})
    EXPECT_EQ(info[same], was[same]) << same;
  EXPECT_EQ(other.client().Get("/v1/tables/" + id + "/file")->body, bytes);
  EXPECT_EQ(post(bytes)->status, 200);
  EXPECT_EQ(other.get("/v1/tables")["tables"], Json({info}));
  EXPECT_EQ(other.wait_end(other.submit(request({{"seed", 9}})))["table_in"], id);

  // A changed bit, a cut file, one whose checksums are good and whose id is another's.
  std::string wrong = bytes;
  wrong[wrong.size() / 2] = static_cast<char>(wrong[wrong.size() / 2] ^ 1);
  Result<TableFile> table = decode_table(read_file(file(id), 1 << 28).value());
  ASSERT_TRUE(table.ok());
  table.value().header.samples_seen += 1;
  const Bytes forged = encode_table(table.value());
  for (const std::string& body : {wrong, bytes.substr(0, bytes.size() / 2), std::string(),
                                  std::string(forged.begin(), forged.end())})
    EXPECT_EQ(post(body)->status, 422);
  EXPECT_EQ(post(bytes, "?scene=B")->status, 422);
  EXPECT_EQ(post(bytes, "", "text/plain")->status, 415);
  TestService small;
  small.config.table_mib = 1;
  small.start();
  const std::string large(2u << 20, 'x');
  EXPECT_EQ(small.client().Post("/v1/tables", large, "application/octet-stream")->status, 413);
}

TEST_F(ServiceTables, TwoMergedAreOneThatTheNextJobStartsFrom) {
  const std::string a = learned({{"seed", 1}}), b = learned({{"seed", 2}});
  const auto answer = s_.client().Post("/v1/tables/merge", body({a, b}), "application/json");
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->status, 201) << answer->body;
  const Json merged = Json::parse(answer->body);
  const std::string id = merged["id"];
  EXPECT_EQ(answer->get_header_value("Location"), "/v1/tables/" + id);
  EXPECT_EQ(merged["parents"], Json(a < b ? std::vector{a, b} : std::vector{b, a}));
  EXPECT_TRUE(merged["job"].is_null());
  EXPECT_EQ(merged["scene"], "box");
  const Json of_a = s_.get("/v1/tables/" + a), of_b = s_.get("/v1/tables/" + b);
  EXPECT_EQ(merged["samples_seen"],
            of_a["samples_seen"].get<int>() + of_b["samples_seen"].get<int>());
  EXPECT_GE(merged["states"], of_b["states"]);
  EXPECT_EQ(merged["bytes"], std::filesystem::file_size(file(id)));
  EXPECT_EQ(s_.get("/v1/tables/" + id), merged);
  EXPECT_EQ(s_.get("/v1/tables")["tables"][0], merged);
  const Result<TableFile> table = decode_table(read_file(file(id), 1 << 28).value());
  ASSERT_TRUE(table.ok());
  EXPECT_TRUE(check_table(table.value()).ok());
  // The other order makes the same table.
  EXPECT_EQ(merge({b, a}, 201)["id"], id);
  EXPECT_EQ(s_.get("/v1/tables")["tables"].size(), 3u);

  EXPECT_EQ(s_.wait_end(s_.submit(request({{"seed", 9}})))["table_in"], id);
}

TEST_F(ServiceTables, TheNewestIsNotTheBest) {
  const std::string first = learned({{"samples", 4}});
  const std::string best = learned({{"samples", 64}, {"learning_samples", 64}});
  const std::string newest = learned({{"samples", 4}, {"table", first}});
  ASSERT_NE(newest, "");
  EXPECT_EQ(s_.get("/v1/tables")["tables"][0]["id"], newest);
  EXPECT_EQ(s_.wait_end(s_.submit(request({{"seed", 9}})))["table_in"], best);
}

TEST_F(ServiceTables, WhatCannotBeMergedIsRefused) {
  const std::string a = learned({{"method", "huang"}}),
                    grid = learned({{"method", "huang"}, {"guide", {{"grid", 3}}}}),
                    ppg = learned({{"method", "ppg"}, {"seed", 1}}),
                    other = learned({{"method", "ppg"}, {"seed", 2}}), none(32, '0');
  EXPECT_EQ(merge({a, none}, 404)["errors"][0]["pointer"], "/tables/1");
  EXPECT_NE(merge({a, grid}, 409).value("detail", "").find("grids differ"), std::string::npos);
  EXPECT_NE(merge({a, ppg}, 409).value("detail", "").find("method"), std::string::npos);
  EXPECT_NE(merge({ppg, other}, 422).value("detail", "").find("'ppg'"), std::string::npos);
  EXPECT_EQ(merge({a, a}, 422)["errors"][0]["pointer"], "/tables/1");
  EXPECT_EQ(merge({a}, 422)["errors"][0]["pointer"], "/tables");
  EXPECT_EQ(merge({a, "x"}, 422)["errors"][0]["pointer"], "/tables/1");
  EXPECT_EQ(merge(std::vector<std::string>(17, a), 422)["errors"][0]["pointer"], "/tables");
  for (const char* wrong : {"[]", "{}", R"({"tables":7})", R"({"tables":[1,2],"more":1})"})
    s_.post("/v1/tables/merge", wrong, 422);
  s_.post("/v1/tables/merge", "{", 400);
  EXPECT_EQ(s_.client().Post("/v1/tables/merge", body({a, grid}), "text/plain")->status, 415);
  EXPECT_EQ(s_.get("/v1/tables")["tables"].size(), 4u);

  Bytes bytes = read_file(file(a), 1 << 28).value();
  bytes[bytes.size() / 2] ^= 1;
  ASSERT_TRUE(write_file_atomic(file(a), bytes).ok());
  EXPECT_NE(merge({a, grid}, 409).value("detail", "").find("cannot be read"), std::string::npos);
}

TEST_F(ServiceTables, OnesTooLargeForTheServerAreRefused) {
  const std::string a = learned({{"method", "huang"}, {"guide", {{"grid", 200}}}}),
                    b = learned({{"method", "huang"}, {"guide", {{"grid", 200}}}, {"seed", 2}});
  s_.stop();
  s_.config.table_mib = 1;
  s_.start();
  merge({a, b}, 413);
}

TEST_F(ServiceTables, DeletedUnlessAJobNamesIt) {
  const std::string id = learned();
  s_.get("/v1/tables/nothing", 404);
  EXPECT_EQ(s_.client().Delete("/v1/tables/nothing")->status, 404);
  const std::string running = s_.submit(request({{"samples", 1'000'000}, {"table", "none"}}));
  const std::string queued = s_.submit(request({{"table", id}}));
  const auto refused = s_.client().Delete("/v1/tables/" + id);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 409);
  EXPECT_NE(refused->body.find(queued), std::string::npos) << refused->body;
  EXPECT_TRUE(std::filesystem::exists(file(id)));
  s_.post("/v1/jobs/" + queued + "/cancel", "", 202);
  s_.post("/v1/jobs/" + running + "/cancel", "", 202);
  s_.wait_end(running);
  const auto deleted = s_.client().Delete("/v1/tables/" + id);
  ASSERT_TRUE(deleted);
  EXPECT_EQ(deleted->status, 204);
  EXPECT_EQ(deleted->body, "");
  EXPECT_FALSE(std::filesystem::exists(file(id)));
  s_.get("/v1/tables/" + id, 404);
  EXPECT_EQ(s_.client().Delete("/v1/tables/" + id)->status, 404);
  EXPECT_TRUE(s_.wait_end(s_.submit(request()))["table_in"].is_null());
}

}  // namespace
}  // namespace qray::server
