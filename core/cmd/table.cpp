// qray table: info, verify and merge of table files.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "core/base/file.h"
#include "core/cmd/commands.h"
#include "core/cmd/files.h"
#include "core/cmd/report.h"
#include "core/guide/open_table.h"
#include "core/import/load_scene.h"
#include "core/job/run_job.h"
#include "proto/json_text.h"

namespace qray::cmd {
namespace {

struct TableOptions {
  std::vector<std::string> files;
  std::string scene, out;
  bool json = false;
};

// An error of a table as one of its file.
Error at_file(const Error& error, const std::string& file) {
  return {error.code, error.message, file + (error.where.empty() ? "" : ":" + error.where)};
}

Status info(const TableOptions& o) {
  Result<TableFile> read = read_table(o.files[0]);
  if (!read) return read.error();
  const TableHeader& h = read.value().header;
  const Result<std::unique_ptr<Guide>> guide = open_table(read.value(), kAnyTableBytes);
  if (!guide) return at_file(guide.error(), o.files[0]);
  const GuideStats stats = guide.value()->stats();
  const double gain = guide.value()->worth().efficiency_gain;
  uint64_t bytes = 0;
  std::vector<std::string> sections;
  for (const TableSection& section : read.value().sections) {
    bytes += section.bytes.size();
    sections.push_back(section.tag);
  }
  const proto::JsonField fields[] = {
      {"id", h.id},
      {"method", h.method},
      {"parents", h.parents},
      {"samples_seen", h.samples_seen},
      {"states", uint64_t{stats.states}},
      {"bytes", bytes},
      {"memory_bytes", uint64_t{stats.bytes}},
      {"sections", sections},
      {"efficiency_gain", gain > 0 ? gain : std::nan("")},
      {"geometry", h.geometry.hex()},
      {"materials", h.materials.hex()},
      {"lights", h.lights.hex()},
      {"program", h.program},
  };
  if (o.json) {
    std::fputs(proto::json_object(fields).c_str(), stdout);
    return {};
  }
  const auto line = [](const char* name, const std::string& value) {
    std::printf("%-13s %s\n", name, value.c_str());
  };
  const auto joined = [](const std::vector<std::string>& parts) {
    std::string text;
    for (const std::string& part : parts) text += (text.empty() ? "" : " ") + part;
    return text.empty() ? std::string("none") : text;
  };
  line("id", h.id);
  line("method", h.method);
  line("parents", joined(h.parents));
  line("samples seen", std::to_string(h.samples_seen));
  line("states", std::to_string(stats.states));
  line("bytes", std::to_string(bytes) + " in sections " + joined(sections) + "; " +
                    std::to_string(stats.bytes) + " of memory");
  char worth[64] = "not known";
  if (gain > 0) std::snprintf(worth, sizeof worth, "%.3g times plain path tracing", gain);
  line("worth", worth);
  line("geometry", h.geometry.hex());
  line("materials", h.materials.hex());
  line("lights", h.lights.hex());
  line("written by", h.program);
  return {};
}

Status verify(const TableOptions& o) {
  const std::string& file = o.files[0];
  Result<TableFile> read = read_table(file);
  if (!read) return read.error();
  const Result<TableCheck> check = check_table(read.value());
  if (!check) return at_file(check.error(), file);
  if (!o.scene.empty()) {
    const Result<std::filesystem::path> path = find_scene_path(o.scene);
    if (!path) return path.error();
    const Result<LoadedScene> scene = load_scene(path.value());
    if (!scene) return scene.error();
    if (Status fits = table_fits(read.value().header, scene.value().hash); !fits)
      return at_file(fits.error(), file);
  }
  std::printf("%s: good\n", file.c_str());
  std::printf("states        %zu\n", check.value().guide->stats().states);
  if (check.value().densities > 0)
    std::printf("densities     %zu integrated, the farthest from 1 gives %.5f\n",
                check.value().densities, check.value().worst);
  if (!o.scene.empty()) std::printf("scene         %s's\n", o.scene.c_str());
  return {};
}

Status merge(const TableOptions& o) {
  if (Status s = check_writable(o.out); !s) return s;
  std::vector<TableFile> tables;
  for (const std::string& file : o.files) {
    Result<TableFile> read = read_table(file);
    if (!read) return read.error();
    tables.push_back(std::move(read).value());
  }
  const Result<MergedTable> merged = merge_tables(tables, kDefaultTableBytes);
  if (!merged) return merged.error();
  return write_file_atomic(o.out, encode_table(merged.value().file));
}

}  // namespace

void add_table(CLI::App& app, int& exit_code) {
  auto o = std::make_shared<TableOptions>();
  CLI::App* table = app.add_subcommand("table", "tables: what was learned about a scene's light");
  table->require_subcommand(1);
  const auto add = [&](const char* name, const char* what, Status (*run)(const TableOptions&)) {
    CLI::App* sub = table->add_subcommand(name, what);
    sub->callback([o, run, &exit_code] {
      if (Status s = run(*o); !s) exit_code = report(s.error());
    });
    return sub;
  };
  CLI::App* sub = add("info", "check a table file and describe it", info);
  sub->add_option("file", o->files)->required()->expected(1);
  sub->add_flag("--json", o->json, "as JSON");
  sub =
      add("verify", "check all that a table says: sums, order, values, densities, its id", verify);
  sub->add_option("file", o->files)->required()->expected(1);
  sub->add_option("--scene", o->scene, "and that it was learned in this scene");
  sub = add("merge", "make one table of what several learned in one scene", merge);
  sub->add_option("files", o->files)->required()->expected(2, kMaxTableParents);
  sub->add_option("-o,--out", o->out, "merged.qrt")->required();
}

}  // namespace qray::cmd
