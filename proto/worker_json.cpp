#include "proto/worker_json.h"

#include <nlohmann/json.hpp>

namespace qray::proto {

std::string worker_list_to_json(std::span<const WorkerMessage> workers) {
  nlohmann::ordered_json out = {{"workers", nlohmann::ordered_json::array()}};
  for (const WorkerMessage& w : workers)
    out["workers"].push_back({{"id", w.id},
                              {"host", w.host},
                              {"kind", w.kind},
                              {"build", w.build},
                              {"threads", w.threads},
                              {"draining", w.draining},
                              {"jobs", w.jobs},
                              {"samples", w.samples},
                              {"samples_per_second", w.samples_a_second},
                              {"age_seconds", w.age_seconds},
                              {"silent_seconds", w.silent_seconds}});
  return out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace qray::proto
