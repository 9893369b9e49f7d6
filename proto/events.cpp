#include "proto/events.h"

#include <nlohmann/json.hpp>

namespace qray::proto {
namespace {

using OrderedJson = nlohmann::ordered_json;

std::string line_of(const OrderedJson& json) {
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

}  // namespace

std::string sse_event(uint64_t id, std::string_view kind, std::string_view data) {
  std::string out = "id: " + std::to_string(id) + "\nevent: ";
  out.append(kind).append("\ndata: ").append(data).append("\n\n");
  return out;
}

std::string sse_comment(std::string_view text) { return ": " + std::string(text) + "\n\n"; }

std::string state_event(std::string_view job, std::string_view state,
                        const std::optional<JobError>& error) {
  OrderedJson out = {{"job", job}, {"state", state}, {"error", nullptr}};
  if (error) out["error"] = {{"message", error->message}, {"where", error->where}};
  return line_of(out);
}

std::string loading_event(std::string_view job, std::string_view step, double fraction,
                          double seconds) {
  return line_of({{"job", job}, {"step", step}, {"fraction", fraction}, {"seconds", seconds}});
}

std::string progress_event(std::string_view job, const JobProgress& progress, uint64_t cursor,
                           std::optional<int> frame) {
  OrderedJson out = {{"job", job},
                     {"fraction", progress.fraction},
                     {"samples", progress.samples},
                     {"seconds", progress.seconds},
                     {"cursor", cursor}};
  if (frame) out["frame"] = *frame;
  return line_of(out);
}

std::string frame_event(std::string_view job, const FrameInfo& frame) {
  return line_of(
      {{"job", job}, {"frame", frame.frame}, {"state", frame.state}, {"samples", frame.samples}});
}

std::string table_event(std::string_view job, std::string_view table,
                        std::span<const std::string> parents) {
  OrderedJson list = OrderedJson::array();
  for (const std::string& parent : parents) list.push_back(parent);
  return line_of({{"job", job}, {"table", table}, {"parents", std::move(list)}});
}

std::string done_event(std::string_view job, std::string_view state) {
  return line_of({{"job", job}, {"state", state}});
}

std::string deleted_event(std::string_view job) { return line_of({{"job", job}}); }

}  // namespace qray::proto
