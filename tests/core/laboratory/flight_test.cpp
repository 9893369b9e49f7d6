#include "core/laboratory/flight.h"

#include <gtest/gtest.h>

#include "core/base/file.h"
#include "tests/support/scratch.h"

namespace qray {
namespace {

Result<Flight> flight_of(const std::string& text) {
  const test::ScratchFolder folder;
  const auto path = folder.path() / "flight.json";
  EXPECT_TRUE(
      write_file_atomic(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()}).ok());
  return load_flight(path, Camera{});
}

TEST(Flight, PassesThroughItsKeysAndCuts) {
  const Flight flight = flight_of(R"({"keys": [
      {"seconds": 0, "position": [0, 0, 5]},
      {"seconds": 1, "position": [1, 0, 5]},
      {"seconds": 2, "position": [2, 0, 5]},
      {"seconds": 3, "position": [9, 0, 5], "cut": true, "lights": [0, 1]}]})")
                            .value();
  EXPECT_EQ(flight.seconds(), 3);
  EXPECT_FLOAT_EQ(flight.at(-1).position.x, 0);
  for (const double t : {0.0, 1.0, 2.0}) EXPECT_NEAR(flight.at(t).position.x, t, 1e-5);
  EXPECT_NEAR(flight.at(1.5).position.x, 1.5, 0.1);
  EXPECT_FLOAT_EQ(flight.at(2.99).position.x, 2);
  EXPECT_FLOAT_EQ(flight.at(3).position.x, 9);
  EXPECT_TRUE(flight.lights_at(2.9).empty());
  EXPECT_EQ(flight.lights_at(3), (std::vector<float>{0, 1}));
  EXPECT_EQ(flight.events(), (std::vector<double>{3}));
}

TEST(Flight, ErrorsNameTheKey) {
  const std::pair<const char*, const char*> bad[] = {
      {R"({"keys": []})", "/keys"},
      {R"({"keys": [{"seconds": 1}]})", "/keys/0/seconds"},
      {R"({"keys": [{"seconds": 0}, {"seconds": 0}]})", "/keys/1/seconds"},
      {R"({"keys": [{"seconds": 0, "target": [0, 0, 0]}]})", "/keys/0"},
      {R"({"keys": [{"seconds": 0, "speed": 2}]})", "/keys/0"},
  };
  for (const auto& [text, place] : bad) {
    const Result<Flight> flight = flight_of(text);
    ASSERT_FALSE(flight.ok()) << text;
    EXPECT_NE(flight.error().where.find(place), std::string::npos) << flight.error().text();
  }
}

}  // namespace
}  // namespace qray
