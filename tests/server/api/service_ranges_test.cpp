// Parts of pictures, and the names that browsers give them.
#include <gtest/gtest.h>

#include "tests/server/test_service.h"

namespace qray::server {
namespace {

TEST(ServiceRanges, APictureComesInParts) {
  test::TestService s;
  s.start();
  const std::string id =
      s.submit({{"scene", "box"}, {"width", 16}, {"height", 16}, {"samples", 1}});
  s.wait_end(id);
  const std::string path = "/v1/jobs/" + id + "/image.exr";
  const auto get = [&](const httplib::Headers& headers) { return s.client().Get(path, headers); };
  const auto whole = get({});
  ASSERT_EQ(whole->status, 200);
  const std::string& bytes = whole->body;
  EXPECT_EQ(whole->get_header_value("Accept-Ranges"), "bytes");
  EXPECT_EQ(whole->get_header_value_count("Accept-Ranges"), 1u);
  EXPECT_EQ(whole->get_header_value("Content-Disposition"), "inline; filename=\"" + id + ".exr\"");
  const std::string tag = whole->get_header_value("ETag");

  const auto part = get({{"Range", "bytes=10-19"}, {"If-Range", tag}});
  EXPECT_EQ(part->status, 206);
  EXPECT_EQ(part->body, bytes.substr(10, 10));
  EXPECT_EQ(part->get_header_value("Content-Range"), "bytes 10-19/" + std::to_string(bytes.size()));
  EXPECT_EQ(get({{"Range", "bytes=10-"}})->body, bytes.substr(10));
  EXPECT_EQ(get({{"Range", "bytes=-10"}})->body, bytes.substr(bytes.size() - 10));
  // It is another picture now, or no range: the whole.
  EXPECT_EQ(get({{"Range", "bytes=10-19"}, {"If-Range", "\"other\""}})->body, bytes);
  EXPECT_EQ(get({{"Range", "pixels=10-19"}})->status, 200);
  const auto behind = get({{"Range", "bytes=" + std::to_string(bytes.size()) + "-"}});
  EXPECT_EQ(behind->status, 416);
  EXPECT_EQ(behind->get_header_value("Content-Range"), "bytes */" + std::to_string(bytes.size()));
  EXPECT_EQ(get({{"Range", "bytes=0-9"}, {"If-None-Match", tag}})->status, 304);
  // What does not come in parts says so, and comes whole.
  const auto job = s.client().Get("/v1/jobs/" + id, {{"Range", "bytes=0-1"}});
  EXPECT_EQ(job->status, 200);
  EXPECT_EQ(job->get_header_value("Accept-Ranges"), "none");
  EXPECT_EQ(s.client()
                .Get("/v1/jobs/" + id + "/image.png?moment=1")
                ->get_header_value("Content-Disposition"),
            "inline; filename=\"" + id + "-moment-1.png\"");
}

}  // namespace
}  // namespace qray::server
