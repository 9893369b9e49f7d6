// qray table info: what a table file says of itself.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/cmd/commands.h"
#include "core/cmd/files.h"
#include "core/cmd/report.h"
#include "proto/json_text.h"

namespace qray::cmd {
namespace {

struct Options {
  std::string file;
  bool json = false;
};

Status run(const Options& o) {
  Result<TableFile> read = read_table(o.file);
  if (!read) return read.error();
  const TableHeader& h = read.value().header;
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
      {"bytes", bytes},
      {"sections", sections},
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
  line("bytes", std::to_string(bytes) + " in sections " + joined(sections));
  line("geometry", h.geometry.hex());
  line("materials", h.materials.hex());
  line("lights", h.lights.hex());
  line("written by", h.program);
  return {};
}

}  // namespace

void add_table(CLI::App& app, int& exit_code) {
  auto o = std::make_shared<Options>();
  CLI::App* table = app.add_subcommand("table", "tables: what was learned about a scene's light");
  table->require_subcommand(1);
  CLI::App* info = table->add_subcommand("info", "check a table file and describe it");
  info->add_option("file", o->file)->required();
  info->add_flag("--json", o->json, "as JSON");
  info->callback([o, &exit_code] {
    if (Status s = run(*o); !s) exit_code = report(s.error());
  });
}

}  // namespace qray::cmd
