// Which sources this program was built from. Any thread.
#pragma once

namespace qray {

// The git commit, with "-dirty" where files differed from it; "unknown" outside git.
const char* build_commit();

}  // namespace qray
