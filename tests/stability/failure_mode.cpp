#include "tests/stability/failure_mode.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <iterator>

#include "core/base/check.h"

namespace qray::test {
namespace {

struct Text {
  std::string_view name, title, must_hold;
};

// In the order of docs/stability.md.
constexpr Text kModes[] = {
    {"published-method", "The thesis' method as published",
     "In the rooms `huang-published` is brighter than `none` by more than 5 standard errors, and "
     "without direct light sampling at least 1.3 times as bright. On a Lambert patch under one "
     "direction that is 2, 10 or 100 times as bright as the rest it is 1.7, 3.8 and 5.1 times too "
     "bright. Every other method has the mean of `none`."},
    {"max-backup", "Max backup against expected backup",
     "In a room of albedo 0.2 the right discount is gamma 0.2. With it `huang` still values "
     "directions without a lamp at over 2 times the light that comes from them. With gamma 1 it "
     "values them at over 20 times that light. The mean equals the mean of `none` all the same."},
    {"gamma-one", "gamma = 1 with albedo 1",
     "Four jobs in a chain learn in a closed white room with alpha 0.2. No sample is NaN and all "
     "values are finite. At depth 3 the mean equals the mean of `none`. If the lamp reflects "
     "nothing, the values of `huang` stay below the lamp's radiance. If the lamp is white too, "
     "the values of `huang` grow with every job, each update adding at most alpha times the "
     "lamp's radiance."},
    {"alpha-and-gamma-ends", "alpha and gamma at 0 and at 1",
     "The mean equals the mean of `none`. With alpha 0 no value of a table changes. With alpha 1 "
     "and gamma 0 each value is the last reward and nothing else."},
    {"no-light", "No light at all",
     "The picture is black and has no NaN. No ray is traced and nothing is learned."},
    {"unseen-light", "Light that the table has never seen",
     "The table was learned while one light was off. Jobs that start from it with that light on "
     "have the mean of `none`."},
    {"firefly-in-a-table", "A value of 1e6 in a table",
     "The mean equals the mean of `none` and no sample is NaN. A chain of jobs forgets the value."},
    {"stale-table", "A table from before a change of the scene",
     "The mean equals the mean of `none`. After four passes `adaptive` makes at most 1.05 times "
     "the noise of a job that began without a table, with its gate and with its guide open."},
    {"thin-wall", "A thin wall, bright on one side",
     "The table is learned on the bright side. No light passes the wall: the other side is black "
     "if it has no lamp. Both sides have the mean of `none` if it has one."},
    {"flipped-normals", "Flipped and two-sided normals",
     "A surface that does not emit looks the same from behind, whatever its winding and its "
     "vertex normals say. A flipped lamp is dark. A two-sided lamp is not."},
    {"parallax", "A small lamp close to a large state",
     "One state holds all points around the lamp, although each point sees it in another "
     "direction. The mean equals the mean of `none`."},
    {"roughness", "Roughness from 0.01 to 1",
     "With conductor, plastic and dielectric no sample is dropped and the mean equals the mean of "
     "`none`."},
    {"glass", "Glass and caustics",
     "No sample is dropped and the mean equals the mean of `none`, also for a lamp inside glass."},
    {"ten-thousand-lights", "10,000 lights",
     "The lights' powers span four decades. No sample is dropped and the mean equals the mean of "
     "`none`."},
    {"camera-inside", "A camera inside an object",
     "Inside a closed opaque block the picture is black. Inside a block of glass the mean is that "
     "of `none`."},
    {"degenerate-triangles", "Degenerate triangles, lights without area, NaN vertices",
     "Triangles without area are left out with a warning, and the picture's bits do not change. A "
     "vertex that is not finite is an error that names its place. With slivers no sample is "
     "dropped and the mean equals the mean of `none`."},
    {"huge-and-tiny", "Scenes of 1e6 m and of 1e-4 m",
     "The mean equals the mean of `none` on the same scene of 2 m. The median error is within 25 "
     "% of the same method's on the scene of 2 m."},
    {"far-from-origin", "Coordinates up to 1e6 m from the origin",
     "The picture is as bright as at the origin, within 1 % at 1e3 m and within 10 % at 1e5 m. At "
     "1e6 m, where neighbouring floats are 6 cm apart, no sample is NaN and the brightness is "
     "within 50 %. From 1e3 m on, a warning says what precision is left."},
    {"one-pixel-one-row", "Pictures of 1x1, 8192x1 and 1x8192 pixels",
     "No sample is dropped and the mean equals the mean of `none`."},
    {"one-sample", "One sample a pixel",
     "The mean equals the mean of `none`, both without a table and from a learned one."},
    {"job-cut-short", "A job of an hour that ends after a second",
     "A job that is stopped ends as canceled, and the film holds the tiles that were finished. A "
     "job that its time limit ends has the statistics of what was rendered, and these statistics "
     "replay it bit for bit."},
    {"table-cap", "A table at its memory cap",
     "A table never takes more than its cap, and the job's statistics say that it refused events. "
     "The mean equals the mean of `none`. The bits are the same for any number of threads. A "
     "table that is larger than a job's cap is refused, and the message names both sizes."},
    {"damaged-table", "A damaged table, or one of another scene",
     "A damaged file is refused, and the message says what is wrong and where. A file whose "
     "checksums are right over wrong values is refused or gives finite densities. The command and "
     "the server take no table of another scene (`table_fits`)."},
    {"extreme-emission", "Emission of 1e10 and of 1e-10",
     "Each method's picture is scaled and nothing else changes: after scaling back, the mean is "
     "the same and the error is the same within 2 %."},
    {"concurrent-jobs", "Concurrent jobs on one table",
     "All jobs succeed. Each leaves a table of its own with the same parent. Pictures and tables "
     "have the bits of jobs that run one after the other."},
};

// A field is one line without tabs, and fits into a cell of a Markdown table.
std::string field(std::string_view text) {
  std::string safe(text);
  for (char& c : safe)
    if (c == '\t' || c == '\n' || c == '|') c = ' ';
  return safe;
}

// The source of the running test, from "tests/" on.
std::string test_file() {
  const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
  QRAY_CHECK(info);
  const std::string path = info->file();
  return path.substr(path.rfind("tests/"));
}

}  // namespace

FailureMode::FailureMode(std::string_view name) {
  const Text* text = std::ranges::find(kModes, name, &Text::name);
  QRAY_CHECK(text != std::end(kModes));
  place_ = static_cast<size_t>(text - kModes);
}

bool FailureMode::reports() { return std::getenv("QRAY_STABILITY_REPORT") != nullptr; }

void FailureMode::write(std::string_view kind, std::string_view method, std::string_view scene,
                        std::string_view text) const {
  const char* path = std::getenv("QRAY_STABILITY_REPORT");
  if (!path) return;
  const Text& mode = kModes[place_];
  std::string line = std::to_string(place_);
  const std::string file_name = test_file();
  for (std::string_view part : {mode.name, mode.title, mode.must_hold, std::string_view(file_name),
                                kind, method, scene, text})
    line += '\t' + field(part);
  line += '\n';
  // One write at the file's end is not torn by those of other processes.
  const int file = ::open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0 || ::write(file, line.data(), line.size()) != static_cast<ssize_t>(line.size()))
    ADD_FAILURE() << "cannot write to " << path;
  if (file >= 0) ::close(file);
}

std::string formatted(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

}  // namespace qray::test
