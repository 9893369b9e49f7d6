// What a chart measures and concludes: plain data, written to results.jsonl and summary.json by
// chart_json.h. Errors are relMSE unless said otherwise (core/image/metrics.h); seconds are of
// rendering and, where a picture is recovered, of recovering that one: loading, developing and
// comparing pictures do not count.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace qray {

// What made a results file: its first line. `flags` are those that decide what is measured, in the
// order of the command's help; runs are only added to a file that has the same.
struct ChartHeader {
  std::string command, program, commit, machine, date;
  std::vector<std::pair<std::string, std::string>> flags;
};

// One picture of one run, compared with the reference: a line of results.jsonl.
struct ChartRow {
  std::string scene;   // its name
  std::string method;  // with what is set otherwise, such as "huang:grid=12"; see variant.h
  bool warm = false;   // started from the table of an earlier job
  uint64_t seed = 0;
  int point = 0;      // which of the run's times, 0 the first
  bool last = false;  // the run's final picture
  double seconds = 0;
  uint64_t samples_per_pixel = 0;
  uint64_t rays = 0;
  uint64_t dropped_samples = 0;
  double relmse = 0, relmse_trimmed = 0, flip = 0;
  double mean_ratio = 0;  // of mean luminance to the reference's
  uint64_t states = 0, table_bytes = 0;
};

// The picture that errors are measured against, and its own error, from its two halves a and b of
// equal size and independent seeds: the mean of (a-b)^2/4 / (r^2 + 0.01) estimates what a perfect
// picture's relMSE would be measured at against r = (a+b)/2.
struct ChartReference {
  std::string scene, scene_hash;  // of the whole scene, hex
  int width = 0, height = 0;
  std::string method;
  uint64_t samples_per_pixel = 0;
  double seconds = 0;
  std::string path;                // of the picture
  double floor_relmse = 0;         // no error below this is claimed
  double floor_trimmed = 0;        // the same of the trimmed error
  double mean_standard_error = 0;  // of the reference's mean luminance, relative to it
  bool floor_known = true;  // false: a picture from outside (--ref), whose halves are not known
};

struct Interval {
  double value = 0, low = 0, high = 0;  // 95 %
};

// The median run of a method at one time, over seeds.
struct ChartPoint {
  double seconds = 0, samples_per_pixel = 0;
  double relmse = 0, low = 0, high = 0;  // median and the seeds' extremes, never below the floor
  double relmse_trimmed = 0, flip = 0;   // medians
  double table_bytes = 0;
  bool at_floor = false;
};

struct MethodSummary {
  std::string method;
  bool warm = false, unbiased = true;  // what the method claims
  int seeds = 0;
  std::vector<ChartPoint> points;
  // Of 1/(relMSE x seconds) over that of `none` with nee, at the last time, paired by seed
  // (Student's t on the logarithms). None without such a method, or at the floor.
  std::optional<Interval> efficiency, efficiency_trimmed;
  // Seconds until the median error is what `none` with nee ends with, over the seconds that it took
  // (log-log interpolation). None: not reached.
  std::optional<double> time_to_equal_error;
  std::optional<double> slope;  // of log error over log seconds, last half: -1 where all is well
  double brightness = 1;        // mean over seeds of mean_ratio at the last time
  double bias_z = 0;            // (brightness - 1) over its standard error, the reference's counted
  bool biased = false;          // does not claim to be unbiased, or |bias_z| says it is not
};

struct SceneSummary {
  ChartReference reference;
  std::vector<MethodSummary> methods;
};

struct ChartSummary {
  std::string command, commit, machine, date;  // what made it
  int threads = 0, width = 0, height = 0;      // 0: each scene's own size
  double seconds = 0;
  std::vector<uint64_t> seeds;
  std::vector<SceneSummary> scenes;
};

}  // namespace qray
