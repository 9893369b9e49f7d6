#include "core/cmd/chart_file.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>

#include "core/base/file.h"
#include "core/cmd/files.h"
#include "core/laboratory/chart/chart_json.h"

namespace qray::cmd {
namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 30;

ChartRun run_of(const ChartRow& row) { return {row.scene, row.method, row.warm, row.seed}; }

std::string differing_flags(const ChartHeader& there, const ChartHeader& here) {
  std::map<std::string, std::pair<std::string, std::string>> values;  // there, here
  for (const auto& [name, value] : there.flags) values[name].first = value;
  for (const auto& [name, value] : here.flags) values[name].second = value;
  std::string out;
  for (const auto& [name, value] : values)
    if (value.first != value.second)
      out += (out.empty() ? "" : "; ") + name + " was '" + value.first + "', is '" + value.second +
             "'";
  return out;
}

}  // namespace

Result<ChartFile> ChartFile::open(const std::filesystem::path& path, const ChartHeader& header,
                                  bool fresh) {
  ChartFile file;
  file.path_ = path;
  file.header_ = header;
  if (std::error_code ignored; !fresh && std::filesystem::exists(path, ignored)) {
    if (Status s = file.load(); !s) return s.error();
    const std::string differing = differing_flags(file.header_, header);
    const bool empty = file.references_.empty() && file.rows_.empty();
    if (empty) {
      file.header_ = header;
    } else if (!differing.empty()) {
      return Error{
          ErrorCode::kConflict,
          "was made with other flags: " + differing + ". Give the same, another folder, or --fresh",
          path.string()};
    }
  }
  if (Status s = write_text(path, file.text()); !s) return s.error();
  return file;
}

Status ChartFile::load() {
  const Result<Bytes> bytes = read_file(path_, kMaxFileBytes);
  if (!bytes) return bytes.error();
  std::string_view rest(reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size());
  std::vector<ChartRow> rows;
  for (int number = 1; !rest.empty(); ++number) {
    const size_t end = rest.find('\n');
    if (end == std::string_view::npos && number > 1) break;  // half-written
    Result<ChartLine> line = parse_chart_line(rest.substr(0, end));
    const bool header = line.ok() && std::holds_alternative<ChartHeader>(line.value());
    if (!line || header != (number == 1)) {
      return Error{ErrorCode::kCorrupt,
                   header || number == 1 ? "expected a header, and in the first line alone"
                                         : line.error().text(),
                   path_.string() + ":" + std::to_string(number)};
    }
    if (header) header_ = std::get<ChartHeader>(std::move(line).value());
    if (auto* reference = std::get_if<ChartReference>(&line.value()))
      references_.push_back(std::move(*reference));
    if (auto* row = std::get_if<ChartRow>(&line.value())) rows.push_back(std::move(*row));
    rest.remove_prefix(std::min(end, rest.size() - 1) + 1);
  }
  for (const ChartRow& row : rows)
    if (std::any_of(rows.begin(), rows.end(), [&](const ChartRow& other) {
          return other.last && run_of(row) == run_of(other);
        }))
      rows_.push_back(row);
  return {};
}

std::string ChartFile::text() const {
  std::string out = chart_line(header_) + "\n";
  for (const ChartReference& reference : references_) out += chart_line(reference) + "\n";
  for (const ChartRow& row : rows_) out += chart_line(row) + "\n";
  return out;
}

const ChartReference* ChartFile::reference(const std::string& scene) const {
  const auto it = std::find_if(references_.begin(), references_.end(),
                               [&](const ChartReference& r) { return r.scene == scene; });
  return it == references_.end() ? nullptr : &*it;
}

bool ChartFile::has_run(const ChartRun& run) const {
  return std::any_of(rows_.begin(), rows_.end(),
                     [&](const ChartRow& r) { return run_of(r) == run; });
}

Status ChartFile::add(const ChartReference& reference) {
  references_.push_back(reference);
  return append(chart_line(reference) + "\n");
}

Status ChartFile::add(std::span<const ChartRow> run) {
  std::string text;
  for (const ChartRow& row : run) text += chart_line(row) + "\n";
  rows_.insert(rows_.end(), run.begin(), run.end());
  return append(text);
}

Status ChartFile::append(const std::string& text) const {
  std::FILE* file = std::fopen(path_.c_str(), "a");
  bool good = file != nullptr && std::fwrite(text.data(), 1, text.size(), file) == text.size() &&
              std::fflush(file) == 0 && ::fsync(fileno(file)) == 0;
  const int cause = errno;
  if (file != nullptr) good = std::fclose(file) == 0 && good;
  if (good) return {};
  return Error{ErrorCode::kIo, std::string("cannot write: ") + std::strerror(cause),
               path_.string()};
}

}  // namespace qray::cmd
