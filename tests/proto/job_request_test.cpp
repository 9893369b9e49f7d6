#include <gtest/gtest.h>

#include <cmath>

#include "proto/messages.h"

namespace qray::proto {
namespace {

JobRequest good(const std::string& json) {
  auto parsed = parse_job_request(json, RequestLimits());
  if (const Problem* problem = std::get_if<Problem>(&parsed)) {
    ADD_FAILURE() << json << ": " << problem_to_json(*problem);
    return {};
  }
  return std::get<JobRequest>(parsed);
}

Problem bad(const std::string& json) {
  auto parsed = parse_job_request(json, RequestLimits());
  if (!std::holds_alternative<Problem>(parsed)) {
    ADD_FAILURE() << "accepted: " << json.substr(0, 200);
    return {};
  }
  return std::get<Problem>(parsed);
}

TEST(JobRequest, SceneAloneGivesDefaults) {
  const JobRequest r = good(R"({"scene":"cornell-box"})");
  JobRequest expected;
  expected.set(field::kScene, "cornell-box");
  expected.set(field::kSamples, 64);
  EXPECT_EQ(r, expected);
  EXPECT_EQ(r.get(field::kMethod), "adaptive");
  EXPECT_EQ(r.get(field::kTable), "auto");
  EXPECT_TRUE(r.get(field::kNee));
}

TEST(JobRequest, EveryField) {
  const JobRequest r = good(R"({"scene":"a-1", "width":512, "height":256, "method":"huang",
      "nee":false, "seconds":2.5, "seed":18446744073709551615,
      "table":"0123456789abcdef0123456789abcdef", "max_depth":3, "learning_samples":0, "gate":false,
      "guide":{"alpha":0.5, "gamma":1, "grid":7}, "camera":{"position":[0,1,3], "target":[0,1,0],
      "up":[0,1,0], "vertical_fov_deg":40, "aperture_radius":0.1, "focus_distance":2,
      "projection":"orthographic", "height":3},
      "priority":-5, "labels":{"project":"lobby"}})");
  EXPECT_EQ(r.given(field::kWidth), 512);
  EXPECT_EQ(r.given(field::kHeight), 256);
  EXPECT_EQ(r.given(field::kMethod), "huang");
  EXPECT_FALSE(r.get(field::kNee));
  EXPECT_EQ(r.given(field::kSamples), std::nullopt);
  EXPECT_EQ(r.given(field::kSeconds), 2.5);
  EXPECT_EQ(r.given(field::kSeed), UINT64_MAX);
  EXPECT_EQ(r.given(field::kTable), "0123456789abcdef0123456789abcdef");
  EXPECT_EQ(r.given(field::kMaxDepth), 3);
  EXPECT_EQ(*r.find("learning_samples"), FieldValue(int64_t{0}));
  EXPECT_EQ(*r.find("gate"), FieldValue(false));
  EXPECT_EQ(*r.find("guide/alpha"), FieldValue(0.5));
  EXPECT_EQ(*r.find("guide/gamma"), FieldValue(1.0));
  EXPECT_EQ(*r.find("guide/grid"), FieldValue(int64_t{7}));
  EXPECT_EQ(*r.find("camera/position"), FieldValue(Vector3{0, 1, 3}));
  EXPECT_EQ(*r.find("camera/focus_distance"), FieldValue(2.0));
  EXPECT_EQ(*r.find("camera/projection"), FieldValue("orthographic"));
  EXPECT_EQ(*r.find("camera/height"), FieldValue(3.0));
  EXPECT_EQ(r.given(field::kPriority), -5);
  EXPECT_EQ(r.given(field::kLabels), (Labels{{"project", "lobby"}}));
}

TEST(JobRequest, WorkersAreANumberOrAuto) {
  EXPECT_EQ(good(R"({"scene":"a"})").given(field::kWorkers), std::nullopt);
  EXPECT_EQ(good(R"({"scene":"a","workers":4})").given(field::kWorkers), 4);
  const JobRequest any = good(R"({"scene":"a","workers":"auto"})");
  EXPECT_EQ(any.given(field::kWorkers), 0);
  EXPECT_NE(job_request_to_json(any).find(R"("workers":"auto")"), std::string::npos);
  EXPECT_EQ(bad(R"({"scene":"a","workers":0})").errors[0].pointer, "/workers");
  EXPECT_EQ(bad(R"({"scene":"a","workers":"all"})").errors[0].detail,
            "expected a whole number, 1..1000, or auto, got \"all\"");
}

TEST(JobRequest, SettingsOfAnotherMethodAreRefusedByName) {
  const Problem problem =
      bad(R"({"scene":"a","method":"ppg","guide":{"alpha":0.1,"split":100,"speed":1}})");
  ASSERT_EQ(problem.errors.size(), 3u);
  EXPECT_EQ(problem.errors[0].pointer, "/guide/alpha");
  EXPECT_EQ(problem.errors[0].detail,
            "the method ppg has no such setting: it belongs to huang, huang-published");
  EXPECT_EQ(problem.errors[1].pointer, "/guide/split");
  EXPECT_EQ(problem.errors[1].detail, "the method ppg has no such setting: it belongs to adaptive");
  EXPECT_EQ(problem.errors[2].pointer, "/guide/speed");
  EXPECT_EQ(problem.errors[2].detail, "unknown field");
  // The default method's, though it is not named.
  EXPECT_EQ(*good(R"({"scene":"a","guide":{"split":100}})").find("guide/split"), FieldValue(100.0));
}

TEST(StoredRequest, OlderVersionsHadSettingsOfGuidesBesideTheMethod) {
  const auto stored = [](const std::string& json) {
    auto parsed = parse_stored_request(json);
    const Problem* problem = std::get_if<Problem>(&parsed);
    EXPECT_EQ(problem, nullptr) << json << (problem ? problem_to_json(*problem) : "");
    return problem ? JobRequest() : std::get<JobRequest>(parsed);
  };
  const JobRequest huang = stored(R"({"scene":"a","method":"huang","nee":true,"samples":8,"seed":1,
      "table":"auto","pixels":"quarter","recover":"none","max_depth":5,"learning_samples":1000000,
      "alpha":0.5,"gamma":0.2,"grid":9,"priority":0})");
  EXPECT_EQ(*huang.find("guide/alpha"), FieldValue(0.5));
  EXPECT_EQ(*huang.find("guide/grid"), FieldValue(int64_t{9}));
  EXPECT_EQ(huang.given(field::kPixels), "quarter");
  EXPECT_EQ(stored(job_request_to_json(huang)), huang);
  const JobRequest none =
      stored(R"({"scene":"a","method":"none","samples":8,"alpha":0.02,"gamma":0.2,"grid":24})");
  EXPECT_EQ(none.find("guide/alpha"), nullptr);
  EXPECT_EQ(stored(R"({"scene":"a","samples":8,"pixels":"adaptive"})").given(field::kPixels),
            "by-noise");
  EXPECT_TRUE(std::holds_alternative<Problem>(parse_stored_request("[1]")));
  // What today's limits and methods refuse.
  const JobRequest other = stored(R"({"scene":"a","method":"gone","seconds":100000})");
  EXPECT_EQ(other.given(field::kMethod), "gone");
  EXPECT_EQ(other.given(field::kSeconds), 100000);
  EXPECT_TRUE(std::holds_alternative<Problem>(parse_stored_request(R"({"scene":7})")));
  EXPECT_TRUE(std::holds_alternative<Problem>(parse_stored_request(R"({"method":7,"alpha":1})")));
}

TEST(JobRequest, WholeNumbersMayBeWrittenWithAPoint) {
  EXPECT_EQ(good(R"({"scene":"a","samples":64.0,"width":1e2})").given(field::kSamples), 64);
}

TEST(JobRequest, RoundTrip) {
  for (const char* json :
       {R"({"scene":"a"})",
        R"({"scene":"b","seconds":0.1,"seed":18446744073709551615,"method":"huang",
           "guide":{"alpha":0.123456789012345}})",
        R"({"scene":"c","camera":{}})",
        R"({"scene":"c","width":3,"max_depth":2,"camera":{"up":[0.1,-1e-3,1e5]}})"}) {
    const JobRequest r = good(json);
    EXPECT_EQ(good(job_request_to_json(r)), r) << json;
  }
}

TEST(JobRequest, WritesWhatWasGivenAndNothingElse) {
  JobRequest request;
  request.set(field::kScene, "cornell-box");
  EXPECT_EQ(job_request_to_json(request), R"({"scene":"cornell-box"})");
  request.set(field::kSeed, UINT64_MAX);
  request.set(field::kNee, false);
  request.set(field::kSamples, 8);
  request.set("guide/alpha", FieldValue(0.2));
  EXPECT_EQ(job_request_to_json(request),
            R"({"scene":"cornell-box","nee":false,"samples":8,"seed":18446744073709551615,)"
            R"("guide":{"alpha":0.2}})");
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
      {R"({"scene":"a","method":"huang","guide":{"alpha":1.01}})", 422, "/guide/alpha"},
      {R"({"scene":"a","method":"huang","alpha":1})", 422, "/alpha"},
      {R"({"scene":"a","method":"huang","guide":{"gamma":"x"}})", 422, "/guide/gamma"},
      {R"({"scene":"a","method":"huang","gamma":1})", 422, "/gamma"},
      {R"({"scene":"a","method":"huang","guide":{"grid":513}})", 422, "/guide/grid"},
      {R"({"scene":"a","method":"huang","grid":1})", 422, "/grid"},
      {R"({"scene":"a","guide":7})", 422, "/guide"},
      {R"({"scene":"a","gate":0})", 422, "/gate"},
      {R"({"scene":"a","russian_roulette":true})", 422, "/russian_roulette"},
      {R"({"scene":"a","recover":"magic"})", 422, "/recover"},
      {R"({"scene":"a","priority":6})", 422, "/priority"},
      {R"({"scene":"a","labels":{"A":"x"}})", 422, "/labels"},
      {R"({"scene":"a","labels":{"a":1}})", 422, "/labels/a"},
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
  RequestLimits small;
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
