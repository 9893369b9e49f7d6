#include "server/http/router.h"

#include <gtest/gtest.h>

namespace qray::server {
namespace {

Router routes(std::string& called) {
  Router router;
  const auto handler = [&called](std::string name) {
    return [&called, name](const httplib::Request&, httplib::Response&, const std::string& id) {
      called = name + "(" + id + ")";
    };
  };
  router.add("GET", "/v1/jobs", handler("list"));
  router.add("POST", "/v1/jobs", handler("create"));
  router.add("GET", "/v1/jobs/{id}", handler("get"));
  router.add("GET", "/v1/jobs/{id}/image.png", handler("png"));
  return router;
}

TEST(Router, Finds) {
  std::string called;
  const Router router = routes(called);
  const auto call = [&](const char* method, const std::string& path) -> std::string {
    called.clear();
    const Router::Match match = router.find(method, path);
    httplib::Response res;
    if (match.handler) (*match.handler)({}, res, match.id);
    return match.handler ? called : "allow:" + match.allow;
  };
  EXPECT_EQ(call("GET", "/v1/jobs"), "list()");
  EXPECT_EQ(call("HEAD", "/v1/jobs"), "list()");
  EXPECT_EQ(call("POST", "/v1/jobs"), "create()");
  EXPECT_EQ(call("GET", "/v1/jobs/j000001"), "get(j000001)");
  EXPECT_EQ(call("GET", "/v1/jobs/a/image.png"), "png(a)");
  EXPECT_EQ(call("DELETE", "/v1/jobs"), "allow:GET, POST");
  EXPECT_EQ(call("POST", "/v1/jobs/x"), "allow:GET");
  for (const std::string& path :
       {std::string("/"), std::string(""), std::string("/v1"), std::string("/v1/jobs/a/b"),
        std::string("/v1/jobs/a/image.png/"), "/v1/jobs/" + std::string(1000, '/'),
        std::string("v1/jobs"), std::string("/V1/jobs")}) {
    EXPECT_EQ(call("GET", path), "allow:") << path;
  }
}

}  // namespace
}  // namespace qray::server
