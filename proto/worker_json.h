// The processes of a farm as JSON. Pure functions.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "proto/messages.h"

namespace qray::proto {

struct WorkerMessage {
  std::string id, host, kind, build, bits;
  int threads = 0;
  bool draining = false;
  uint64_t samples = 0;
  double samples_a_second = 0, age_seconds = 0, silent_seconds = 0;
  std::vector<std::string> jobs;
  std::string helps, aside;  // a job's id; a reason
};

std::string worker_list_to_json(std::span<const WorkerMessage> workers);

}  // namespace qray::proto
