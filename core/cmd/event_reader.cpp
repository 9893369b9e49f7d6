#include "core/cmd/event_reader.h"

namespace qray::cmd {
namespace {

constexpr size_t kMaxLineBytes = 64 * 1024;

}  // namespace

std::vector<ServerEvent> EventReader::feed(std::string_view bytes) {
  std::vector<ServerEvent> out;
  buffer_.append(bytes);
  size_t start = 0;
  for (size_t end; (end = buffer_.find('\n', start)) != std::string::npos; start = end + 1) {
    std::string_view line(buffer_.data() + start, end - start);
    if (line.ends_with('\r')) line.remove_suffix(1);
    take_line(line, out);
  }
  buffer_.erase(0, start);
  if (buffer_.size() > kMaxLineBytes) buffer_.clear();
  return out;
}

void EventReader::take_line(std::string_view line, std::vector<ServerEvent>& out) {
  if (line.empty()) {
    if (!event_.data.empty()) {
      if (event_.type.empty()) event_.type = "message";
      out.push_back(event_);
    }
    event_.type.clear();
    event_.data.clear();
    return;
  }
  const size_t colon = line.find(':');
  const std::string_view field = line.substr(0, colon);
  std::string_view value = colon == std::string_view::npos ? "" : line.substr(colon + 1);
  if (value.starts_with(' ')) value.remove_prefix(1);
  if (field == "id") event_.id = value;
  if (field == "event") event_.type = value;
  if (field == "data") {
    if (!event_.data.empty()) event_.data += '\n';
    event_.data += value;
  }
}

}  // namespace qray::cmd
