#include "proto/worker_json.h"

#include <nlohmann/json.hpp>

namespace qray::proto {

std::string worker_list_to_json(std::span<const WorkerMessage> workers) {
  nlohmann::ordered_json out = {{"workers", nlohmann::ordered_json::array()}};
  for (const WorkerMessage& w : workers)
    out["workers"].push_back(
        {{"id", w.id},
         {"host", w.host},
         {"kind", w.kind},
         {"build", w.build},
         {"bits", w.bits},
         {"threads", w.threads},
         {"draining", w.draining},
         {"aside", w.aside},
         {"jobs", w.jobs},
         {"helps", w.helps.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(w.helps)},
         {"samples", w.samples},
         {"samples_per_second", w.samples_a_second},
         {"age_seconds", w.age_seconds},
         {"silent_seconds", w.silent_seconds}});
  return out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace qray::proto
