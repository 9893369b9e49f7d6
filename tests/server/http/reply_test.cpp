#include "server/http/reply.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace qray::server {
namespace {

TEST(Reply, AFullDiskIsNoFaultOfTheProgramAndNamesNoPaths) {
  httplib::Response res;
  reply_error(res, {ErrorCode::kIo, "SQLite: database or disk is full", "data/qray.sqlite"});
  EXPECT_EQ(res.status, 503);
  EXPECT_TRUE(res.has_header("Retry-After"));
  EXPECT_EQ(res.body.find("sqlite"), std::string::npos) << res.body;
  EXPECT_FALSE(nlohmann::json::parse(res.body)["detail"].get<std::string>().empty());
}

TEST(Reply, ADamagedFileIsAnInternalError) {
  httplib::Response res;
  reply_error(res, {ErrorCode::kCorrupt, "wrong checksum", "data/tables/x.qrt"});
  EXPECT_EQ(res.status, 500);
  EXPECT_EQ(res.body.find("x.qrt"), std::string::npos) << res.body;
}

}  // namespace
}  // namespace qray::server
