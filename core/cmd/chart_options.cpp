#include "core/cmd/chart_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>

#include "core/base/build_commit.h"
#include "core/cmd/render_options.h"
#include "core/settings/variant.h"

namespace qray::cmd {
namespace {

constexpr double kReferenceFactor = 20;  // reference's seconds over a run's

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

void fill_defaults(ChartOptions& o) {
  o.warm = o.warm || o.warm_turn != 0;
  if (o.methods.empty())
    for (std::string_view name : method_names())
      o.methods += (o.methods.empty() ? "" : ",") + std::string(name);
  if (!o.seconds) o.seconds = o.quick ? 1 : 60;
  if (!o.seeds) o.seeds = o.quick ? 2 : 5;
  if (o.size.empty() && o.quick) o.size = "64x64";
  if (!o.ref_seconds) o.ref_seconds = o.quick ? 2 : kReferenceFactor * *o.seconds;
}

// What a chart calls a scene: "cornell-box" of cornell-box, of its folder, or of its scene.json.
std::string scene_name(const std::string& argument) {
  std::error_code ignored;
  std::filesystem::path path = std::filesystem::weakly_canonical(argument, ignored);
  if (path.filename() == "scene.json") path = path.parent_path();
  return std::filesystem::is_regular_file(path, ignored) ? path.stem().string()
                                                         : path.filename().string();
}

// Single-quoted for a shell where it has to be.
std::string shell_word(const std::string& text) {
  const bool plain = text.find_first_of(" ;&|<>()$`\\\"'*?[]#~!{}") == std::string::npos;
  return plain ? text : "'" + text + "'";
}

std::string machine_text() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  std::string model = "unknown processor";
  for (std::string line; std::getline(cpuinfo, line);)
    if (line.starts_with("model name") && line.find(": ") != std::string::npos)
      model = line.substr(line.find(": ") + 2);
  return model + ", " + std::to_string(default_threads()) + " threads";
}

std::string today() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc)};
}

}  // namespace

void add_chart_options(CLI::App& app, ChartOptions& o) {
  app.add_option("scenes", o.scenes, "names of included scenes, folders or files")->required();
  app.add_option("--methods", o.methods,
                 "method[:key=value[;key=value]...], by commas; default: every method. Keys: " +
                     variant_keys() + "; those of a guide are its method's alone");
  app.add_option("--seconds", o.seconds, "of rendering, each run; default 60")
      ->check(CLI::Range(0.01, 86400.0));
  app.add_option("--seeds", o.seeds, "runs of each method; default 5")->check(CLI::Range(2, 1000));
  app.add_option("--size", o.size, "WIDTHxHEIGHT in pixels; default: each scene's");
  app.add_option("--threads", o.threads, "default: one a processor")->check(CLI::Range(1, 1024));
  app.add_flag("--warm", o.warm, "also start from the table that a job as long has left");
  app.add_option("--warm-turn", o.warm_turn, "that job's camera is turned; degrees, to the left")
      ->check(CLI::Range(-180.0, 180.0));
  auto* ref = app.add_option("--ref", o.ref, "the truth, instead of a reference of its own");
  app.add_option("--ref-seconds", o.ref_seconds, "for the reference; default: 20 runs'")
      ->check(CLI::Range(0.01, 864000.0))
      ->excludes(ref);
  std::vector<std::string> methods(method_names().begin(), method_names().end());
  app.add_option("--ref-method", o.ref_method, "for the reference; default none")
      ->check(CLI::IsMember(methods))
      ->excludes(ref);
  app.add_option("--ref-cache", o.ref_cache, "folder of references; default: DIR/references");
  app.add_flag("--quick", o.quick, "1 second, 2 seeds, 64x64, a reference of 2 seconds");
  app.add_flag("--fresh", o.fresh, "lose the results that DIR has, rather than going on");
  app.add_flag("-q,--quiet", o.quiet, "no progress");
  app.add_option("-o,--out", o.out, "DIR for results, pictures and the page")->required();
}

Result<ChartPlan> complete(ChartOptions& o) {
  fill_defaults(o);
  if (!o.ref.empty() && o.scenes.size() != 1)
    return Error{ErrorCode::kInvalid, "is one scene's, expected one scene", "--ref"};
  if (!method_traits(o.ref_method).unbiased)
    return Error{ErrorCode::kInvalid, "expected a method without bias, got " + o.ref_method,
                 "--ref-method"};
  ChartPlan plan;
  for (const std::string& scene : o.scenes) {
    plan.scenes.push_back(scene_name(scene));
    if (std::count(plan.scenes.begin(), plan.scenes.end(), plan.scenes.back()) > 1)
      return Error{ErrorCode::kInvalid, "another scene is called " + plan.scenes.back(), scene};
  }
  Result<std::vector<std::string>> methods = parse_variants(o.methods);
  if (!methods) return methods.error();
  plan.methods = std::move(methods).value();
  for (int i = 1; i <= *o.seeds; ++i) plan.seeds.push_back(static_cast<uint64_t>(i));
  plan.seconds = *o.seconds;
  plan.warm = o.warm;
  plan.warm_turn_deg = static_cast<float>(o.warm_turn);
  if (o.size.empty()) return plan;
  const Result<std::pair<int, int>> size = parse_size(o.size);
  if (!size) return size.error();
  std::tie(plan.width, plan.height) = size.value();
  return plan;
}

ChartHeader chart_header(const ChartOptions& o) {
  ChartHeader h;
  h.program = QRAY_VERSION;
  h.commit = build_commit();
  h.machine = machine_text();
  h.date = today();
  std::string scenes;
  for (const std::string& scene : o.scenes)
    scenes += (scenes.empty() ? "" : " ") + shell_word(scene);
  h.flags = {{"scenes", scenes},
             {"--methods", o.methods},
             {"--seconds", number_text(*o.seconds)},
             {"--seeds", std::to_string(*o.seeds)},
             {"--size", o.size},
             {"--threads", std::to_string(o.threads)},
             {"--warm", o.warm ? "on" : ""},
             {"--warm-turn", o.warm_turn != 0 ? number_text(o.warm_turn) : ""},
             {"--ref", o.ref},
             {"--ref-method", o.ref_method == "none" ? "" : o.ref_method},
             {"--ref-seconds", o.ref.empty() ? number_text(*o.ref_seconds) : ""}};
  h.command = "qray chart " + scenes;
  for (const auto& [name, value] : h.flags)
    if (name != "scenes" && !value.empty())
      h.command += " " + name + (value == "on" ? "" : " " + shell_word(value));
  h.command += " -o " + shell_word(o.out);
  return h;
}

}  // namespace qray::cmd
