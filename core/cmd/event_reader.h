// Cuts a text/event-stream (HTML Living Standard, section 9.2) into events, however it arrives.
// One thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace qray::cmd {

struct ServerEvent {
  std::string id;    // the last id seen so far
  std::string type;  // "message" when the stream does not say
  std::string data;
};

class EventReader {
 public:
  // Events that `bytes` completes. A line of over 64 KiB empties the buffer: it is no event of
  // ours.
  std::vector<ServerEvent> feed(std::string_view bytes);
  const std::string& last_id() const { return event_.id; }

 private:
  void take_line(std::string_view line, std::vector<ServerEvent>& out);

  std::string buffer_;  // of a line that has not ended
  ServerEvent event_;
};

}  // namespace qray::cmd
