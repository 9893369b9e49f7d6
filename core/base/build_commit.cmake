# Writes build_commit.cpp (OUT) for the commit of SOURCE; leaves the file alone when it is the same.
cmake_minimum_required(VERSION 3.25)
execute_process(
  COMMAND git --no-optional-locks -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT
"#include \"core/base/build_commit.h\"

namespace qray {
const char* build_commit() { return \"@commit@\"; }
}  // namespace qray
")
