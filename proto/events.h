// Server-sent events (WHATWG HTML, section 9.2): their framing and their data. events.md says which
// there are. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "proto/messages.h"

namespace qray::proto {

// "id: 7\nevent: state\ndata: {...}\n\n". `data` is JSON on one line.
std::string sse_event(uint64_t id, std::string_view kind, std::string_view data);
std::string sse_comment(std::string_view text);

// The data of each kind of event.
std::string state_event(std::string_view job, std::string_view state,
                        const std::optional<JobError>& error);
// `step`: reading (its files), building (the tree for rays).
std::string loading_event(std::string_view job, std::string_view step, double fraction,
                          double seconds);
// `frame`: of a job of frames, the one under way, whose cursor it is.
std::string progress_event(std::string_view job, const JobProgress& progress, uint64_t cursor,
                           std::optional<int> frame = {});
std::string frame_event(std::string_view job, const FrameInfo& frame);
std::string table_event(std::string_view job, std::string_view table,
                        std::span<const std::string> parents);
std::string done_event(std::string_view job, std::string_view state);
std::string deleted_event(std::string_view job);

}  // namespace qray::proto
