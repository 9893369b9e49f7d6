// What a server that was killed leaves in the data folder: files of which the database knows
// nothing. At a start, before jobs are recovered.
#pragma once

#include <filesystem>

#include "server/store/job_store.h"
#include "server/store/table_store.h"

namespace qray::server {

// Removes half-written files, and what belongs to jobs and tables that were deleted. Where the
// database is the one that forgot (it is new, or its newest part was lost, so that files bear ids
// it never gave), what it does not know is moved to <data>/quarantine instead, and no new job gets
// such an id. Records of tables whose file is gone are removed,
// where nobody else can have written one.
// What was written less than `left` ago stays: where other servers use the folder, it may be
// theirs.
Status tidy_data_folder(const std::filesystem::path& data, JobStore& jobs, TableStore& tables,
                        std::chrono::seconds left = {});

}  // namespace qray::server
