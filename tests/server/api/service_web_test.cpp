// The files of the page as a browser asks for them: packed where it takes that, and not again while
// they are as it has them.
#include "tests/server/test_service.h"

namespace qray::server {
namespace {

const std::string kScript = [] {
  std::string text;
  for (int i = 0; i < 500; ++i) text += "export const value_" + std::to_string(i) + " = 'value';\n";
  return text;
}();

class ServiceWeb : public ::testing::Test {
 protected:
  void SetUp() override {
    test::write_text(s_.config.web / "page.js", kScript);
    test::write_text(s_.config.web / "picture.png", "not read by anybody here");
    s_.start();
  }
  httplib::Result get(const std::string& path, httplib::Headers headers) const {
    return s_.client().Get(path, headers);
  }

  test::TestService s_;
};

size_t sent_bytes(const httplib::Result& answer) {
  return std::stoul(answer->get_header_value("Content-Length"));
}

TEST_F(ServiceWeb, IsPackedForWhoTakesGzip) {
  const auto packed = get("/page.js", {{"Accept-Encoding", "gzip, deflate, br"}});
  ASSERT_TRUE(packed);
  EXPECT_EQ(packed->status, 200);
  EXPECT_EQ(packed->get_header_value("Content-Encoding"), "gzip");
  EXPECT_EQ(packed->get_header_value("Content-Type"), "text/javascript; charset=utf-8");
  EXPECT_EQ(packed->get_header_value("Vary"), "Accept-Encoding");
  EXPECT_EQ(packed->body, kScript);  // the client unpacks it
  EXPECT_LT(sent_bytes(packed), kScript.size() / 4);

  const auto head = s_.client().Head("/page.js", {{"Accept-Encoding", "gzip"}});
  ASSERT_TRUE(head);
  EXPECT_EQ(head->get_header_value("Content-Encoding"), "gzip");
  EXPECT_EQ(sent_bytes(head), sent_bytes(packed));
}

TEST_F(ServiceWeb, IsPlainForWhoDoesNot) {
  for (const char* codings : {"br", "gzip;q=0, *", "identity"}) {
    const auto plain = get("/page.js", {{"Accept-Encoding", codings}});
    ASSERT_TRUE(plain);
    EXPECT_FALSE(plain->has_header("Content-Encoding")) << codings;
    EXPECT_EQ(plain->get_header_value("Vary"), "Accept-Encoding");
    EXPECT_EQ(plain->body, kScript);
    EXPECT_EQ(sent_bytes(plain), kScript.size());
  }
}

TEST_F(ServiceWeb, ComesOnceWhileItStaysAsItIs) {
  const httplib::Headers takes{{"Accept-Encoding", "gzip"}}, takes_not{{"Accept-Encoding", "br"}};
  const std::string packed_tag = get("/page.js", takes)->get_header_value("ETag");
  const std::string plain_tag = get("/page.js", takes_not)->get_header_value("ETag");
  EXPECT_NE(packed_tag, plain_tag);
  const auto again = [&](httplib::Headers headers, const std::string& tag) {
    headers.emplace("If-None-Match", tag);
    return get("/page.js", headers);
  };
  const auto same = again(takes, packed_tag);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->status, 304);
  EXPECT_EQ(same->body, "");
  EXPECT_FALSE(same->has_header("Content-Encoding"));
  EXPECT_EQ(same->get_header_value("Vary"), "Accept-Encoding");
  EXPECT_EQ(same->get_header_value("ETag"), packed_tag);
  EXPECT_EQ(same->get_header_value("Cache-Control"), "no-cache");
  EXPECT_EQ(again(takes_not, plain_tag)->status, 304);
  EXPECT_EQ(again(takes_not, packed_tag)->status, 200);

  test::write_text(s_.config.web / "page.js", kScript + "// edited");
  EXPECT_EQ(again(takes_not, plain_tag)->body, kScript + "// edited");
  EXPECT_EQ(again(takes, packed_tag)->body, kScript + "// edited");
}

TEST_F(ServiceWeb, NothingElseIsPacked) {
  const httplib::Headers takes{{"Accept-Encoding", "gzip"}};
  for (const char* path : {"/picture.png", "/v1/jobs", "/v1/scenes", "/openapi.json", "/nothing"}) {
    const auto answer = get(path, takes);
    ASSERT_TRUE(answer) << path;
    EXPECT_FALSE(answer->has_header("Content-Encoding")) << path;
    EXPECT_FALSE(answer->has_header("Vary")) << path;
  }
}

}  // namespace
}  // namespace qray::server
