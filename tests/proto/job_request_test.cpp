#include <gtest/gtest.h>

#include <cmath>

#include "proto/messages.h"

namespace qray::proto {
namespace {

RequestLimits limits() {
  RequestLimits limits;
  limits.methods = {"none", "huang", "adaptive"};
  limits.max_grid = 512;
  return limits;
}

JobRequest good(const std::string& json) {
  auto parsed = parse_job_request(json, limits());
  if (const Problem* problem = std::get_if<Problem>(&parsed)) {
    ADD_FAILURE() << json << ": " << problem_to_json(*problem);
    return {};
  }
  return std::get<JobRequest>(parsed);
}

Problem bad(const std::string& json) {
  auto parsed = parse_job_request(json, limits());
  if (!std::holds_alternative<Problem>(parsed)) {
    ADD_FAILURE() << "accepted: " << json.substr(0, 200);
    return {};
  }
  return std::get<Problem>(parsed);
}

TEST(JobRequest, SceneAloneGivesDefaults) {
  const JobRequest r = good(R"({"scene":"cornell-box"})");
  JobRequest expected;
  expected.scene = "cornell-box";
  expected.samples = 64;
  EXPECT_EQ(r, expected);
}

TEST(JobRequest, EveryField) {
  const JobRequest r = good(R"({"scene":"a-1", "width":512, "height":256, "method":"none",
      "nee":false, "seconds":2.5, "seed":18446744073709551615,
      "table":"0123456789abcdef0123456789abcdef", "max_depth":3, "learning_samples":0,
      "alpha":0.5, "gamma":1, "grid":7, "camera":{"position":[0,1,3], "target":[0,1,0],
      "up":[0,1,0], "vertical_fov_deg":40, "aperture_radius":0.1, "focus_distance":2}})");
  EXPECT_EQ(r.width, 512);
  EXPECT_EQ(r.height, 256);
  EXPECT_EQ(r.method, "none");
  EXPECT_FALSE(r.nee);
  EXPECT_EQ(r.samples, std::nullopt);
  EXPECT_EQ(r.seconds, 2.5);
  EXPECT_EQ(r.seed, UINT64_MAX);
  EXPECT_EQ(r.table, "0123456789abcdef0123456789abcdef");
  EXPECT_EQ(r.max_depth, 3);
  EXPECT_EQ(r.learning_samples, 0);
  EXPECT_EQ(r.alpha, 0.5);
  EXPECT_EQ(r.gamma, 1);
  EXPECT_EQ(r.grid, 7);
  ASSERT_TRUE(r.camera);
  EXPECT_EQ(r.camera->position, (std::array<double, 3>{0, 1, 3}));
  EXPECT_EQ(r.camera->focus_distance, 2);
}

TEST(JobRequest, WholeNumbersMayBeWrittenWithAPoint) {
  EXPECT_EQ(good(R"({"scene":"a","samples":64.0,"width":1e2})").samples, 64);
}

TEST(JobRequest, RoundTrip) {
  for (const char* json :
       {R"({"scene":"a"})",
        R"({"scene":"b","seconds":0.1,"seed":18446744073709551615,"alpha":0.123456789012345})",
        R"({"scene":"c","camera":{}})",
        R"({"scene":"c","width":3,"max_depth":2,"camera":{"up":[0.1,-1e-3,1e5]}})"}) {
    const JobRequest r = good(json);
    EXPECT_EQ(good(job_request_to_json(r)), r) << json;
  }
}

struct Wrong {
  const char* json;
  int status;
  const char* pointer;  // null: no field
};

TEST(JobRequest, WrongOnesNameTheField) {
  const Wrong cases[] = {
      {"", 400, nullptr},
      {"nonsense", 400, nullptr},
      {R"({"scene":"a"} x)", 400, nullptr},
      {R"({"scene":"a",})", 400, nullptr},
      {R"({"scene":"a","scene":"b"})", 400, nullptr},
      {R"({"scene":"a","samples":NaN})", 400, nullptr},
      {R"({"scene":"a","seconds":Infinity})", 400, nullptr},
      {"{\"scene\":\"\xff\xfe\"}", 400, nullptr},
      {"{\"scene\":\"a\0b\"}", 400, nullptr},
      {R"({"scene":"a","seconds":1e999})", 400, nullptr},
      {"[]", 422, ""},
      {"null", 422, ""},
      {"7", 422, ""},
      {"{}", 422, "/scene"},
      {R"({"scene":null})", 422, "/scene"},
      {R"({"scene":7})", 422, "/scene"},
      {R"({"scene":""})", 422, "/scene"},
      {R"({"scene":"../etc/passwd"})", 422, "/scene"},
      {R"({"scene":"a\u0000b"})", 422, "/scene"},
      {R"({"scene":"\ud83d\ude00"})", 422, "/scene"},
      {R"({"scene":"a","width":0})", 422, "/width"},
      {R"({"scene":"a","width":-1})", 422, "/width"},
      {R"({"scene":"a","width":1.5})", 422, "/width"},
      {R"({"scene":"a","width":"512"})", 422, "/width"},
      {R"({"scene":"a","width":8192,"height":8192})", 422, "/width"},
      {R"({"scene":"a","height":100000})", 422, "/height"},
      {R"({"scene":"a","height":18446744073709551616})", 422, "/height"},
      {R"({"scene":"a","method":"magic"})", 422, "/method"},
      {R"({"scene":"a","nee":1})", 422, "/nee"},
      {R"({"scene":"a","samples":0})", 422, "/samples"},
      {R"({"scene":"a","samples":1000001})", 422, "/samples"},
      {R"({"scene":"a","samples":true})", 422, "/samples"},
      {R"({"scene":"a","samples":null})", 422, "/samples"},
      {R"({"scene":"a","seconds":0})", 422, "/seconds"},
      {R"({"scene":"a","seconds":-1e-300})", 422, "/seconds"},
      {R"({"scene":"a","seconds":1e308})", 422, "/seconds"},
      {R"({"scene":"a","seconds":1,"samples":1})", 422, "/seconds"},
      {R"({"scene":"a","seed":-1})", 422, "/seed"},
      {R"({"scene":"a","seed":1.5})", 422, "/seed"},
      {R"({"scene":"a","seed":1e30})", 422, "/seed"},
      {R"({"scene":"a","table":"../x"})", 422, "/table"},
      {R"({"scene":"a","table":"0123456789ABCDEF0123456789abcdef"})", 422, "/table"},
      {R"({"scene":"a","max_depth":0})", 422, "/max_depth"},
      {R"({"scene":"a","learning_samples":-1})", 422, "/learning_samples"},
      {R"({"scene":"a","alpha":1.01})", 422, "/alpha"},
      {R"({"scene":"a","gamma":"x"})", 422, "/gamma"},
      {R"({"scene":"a","grid":513})", 422, "/grid"},
      {R"({"scene":"a","camera":[]})", 422, "/camera"},
      {R"({"scene":"a","camera":{"position":[0,1]}})", 422, "/camera/position"},
      {R"({"scene":"a","camera":{"position":[0,1,"2"]}})", 422, "/camera/position/2"},
      {R"({"scene":"a","camera":{"position":[0,1e30,0]}})", 422, "/camera/position/1"},
      {R"({"scene":"a","camera":{"up":[0,0,0]}})", 422, "/camera/up"},
      {R"({"scene":"a","camera":{"position":[1,1,1],"target":[1,1,1]}})", 422, "/camera/target"},
      {R"({"scene":"a","camera":{"vertical_fov_deg":180}})", 422, "/camera/vertical_fov_deg"},
      {R"({"scene":"a","camera":{"aperture_radius":-1}})", 422, "/camera/aperture_radius"},
      {R"({"scene":"a","camera":{"roll":1}})", 422, "/camera/roll"},
      {R"({"scene":"a","spp":64})", 422, "/spp"},
      {R"({"scene":"a","a/b~c":64})", 422, "/a~1b~0c"},
  };
  for (const Wrong& c : cases) {
    const Problem problem = bad(c.json);
    EXPECT_EQ(problem.status, c.status) << c.json;
    EXPECT_FALSE(problem.title.empty()) << c.json;
    if (!c.pointer) continue;
    ASSERT_FALSE(problem.errors.empty()) << c.json;
    EXPECT_EQ(problem.errors[0].pointer, c.pointer) << c.json;
    EXPECT_FALSE(problem.errors[0].detail.empty()) << c.json;
  }
}

TEST(JobRequest, EveryWrongFieldIsNamed) {
  const Problem problem = bad(R"({"width":0,"nee":"yes","camera":{"up":1},"bogus":1})");
  std::vector<std::string> pointers;
  for (const FieldError& e : problem.errors) pointers.push_back(e.pointer);
  EXPECT_EQ(pointers,
            (std::vector<std::string>{"/scene", "/width", "/nee", "/camera/up", "/bogus"}));
}

TEST(JobRequest, DeepNestingIsRefused) {
  for (const char* open : {"[", "{\"a\":", "[{\"a\":"}) {
    std::string json = R"({"scene":)";
    for (int i = 0; i < 100'000; ++i) json += open;
    EXPECT_EQ(bad(json).status, 400) << open;
  }
  // Brackets in text do not nest.
  const Problem problem = bad(R"({"scene":")" + std::string(1000, '[') + R"("})");
  EXPECT_EQ(problem.status, 422);
}

TEST(JobRequest, LongTextIsNotEchoedWhole) {
  const Problem problem = bad(R"({"scene":"a","method":")" + std::string(100'000, 'x') + R"("})");
  EXPECT_LT(problem_to_json(problem).size(), 1000u);
  const Problem unknown = bad(R"({"scene":"a",")" + std::string(100'000, 'y') + R"(":1})");
  EXPECT_LT(problem_to_json(unknown).size(), 1000u);
}

TEST(JobRequest, ManyUnknownFieldsGiveABoundedAnswer) {
  std::string json = R"({"scene":"a")";
  for (int i = 0; i < 10'000; ++i) json += ",\"f" + std::to_string(i) + "\":1";
  EXPECT_LE(bad(json + "}").errors.size(), 40u);
}

TEST(JobRequest, TooManyBytes) {
  RequestLimits small = limits();
  small.max_bytes = 10;
  const auto parsed = parse_job_request(R"({"scene":"cornell-box"})", small);
  ASSERT_TRUE(std::holds_alternative<Problem>(parsed));
  EXPECT_EQ(std::get<Problem>(parsed).status, 413);
}

TEST(JobRequest, AnyCutOfAGoodRequestIsRefused) {
  const std::string whole =
      R"({"scene":"a","seconds":1.5,"camera":{"position":[0,1,3],"up":[0,1,0]},"nee":true})";
  good(whole);
  for (size_t n = 0; n < whole.size(); ++n) EXPECT_EQ(bad(whole.substr(0, n)).status, 400) << n;
}

TEST(MergeRequest, IdsAndNothingElse) {
  const std::string a(32, 'a'), b(32, '0');
  const auto parse = [](const std::string& json) { return parse_merge_request(json, {}); };
  const auto good = parse(R"({"tables":[")" + a + R"(",")" + b + R"("]})");
  ASSERT_TRUE(std::holds_alternative<std::vector<std::string>>(good));
  EXPECT_EQ(std::get<std::vector<std::string>>(good), (std::vector{a, b}));
  const auto pointers = [&](const std::string& json) {
    const auto parsed = parse(json);
    std::vector<std::string> result;
    if (const auto* problem = std::get_if<Problem>(&parsed)) {
      EXPECT_EQ(problem->status, 422) << json;
      for (const FieldError& e : problem->errors) result.push_back(e.pointer);
    }
    return result;
  };
  using Pointers = std::vector<std::string>;
  EXPECT_EQ(pointers("[]"), Pointers{""});
  EXPECT_EQ(pointers("{}"), Pointers{"/tables"});
  EXPECT_EQ(pointers(R"({"tables":[")" + a + R"("]})"), Pointers{"/tables"});
  EXPECT_EQ(pointers(R"({"tables":[7,"xyz"],"order":1})"),
            (Pointers{"/tables/0", "/tables/1", "/order"}));
  EXPECT_EQ(pointers(R"({"tables":[")" + a + R"(",")" + a + R"("]})"), Pointers{"/tables/1"});
  EXPECT_EQ(std::get<Problem>(parse("{")).status, 400);
}

}  // namespace
}  // namespace qray::proto
