// What a job or a live session begins with: the guide of the table that it asks for. Any thread.
#pragma once

#include <functional>
#include <string>

#include "core/job/run_job.h"
#include "server/store/table_store.h"

namespace qray::server {

struct TableWish {
  std::string table;  // an id; "auto": of those that serve, the one that has seen the most; "none"
  // A table that is named must be of this very scene; else what it knows is doubted.
  bool must_fit = true;
};

// Of those that "auto" finds, one that cannot be read goes to quarantine, and one of another grid
// or too large is passed over; `warn` is told of each. kConflict: a table that is named is of
// another scene; and what loading it says.
Result<StartingGuide> choose_table(TableStore& tables, const PreparedScene& scene,
                                   const RenderSettings& settings, const TableWish& wish,
                                   const std::function<void(std::string)>& warn);

}  // namespace qray::server
