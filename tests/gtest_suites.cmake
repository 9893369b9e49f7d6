# Writes the ctest entries of a gtest program, one a suite (run after each build of the program):
#   cmake -DPROGRAM=FILE -DPREFIX=stat -DOUT=FILE "-DLABELS=a;b" -DTIMEOUT=S -P gtest_suites.cmake
# One a test would start a process a test, and each of them that touches a picture would load
# OpenImageIO's libraries: .2 s of processor time.
execute_process(COMMAND ${PROGRAM} --gtest_list_tests
  OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY TIMEOUT 60)
string(REGEX MATCHALL "(^|\n)[^ \n]+\\.[ \n]" lines "${listed}")
set(entries "")
foreach(line ${lines})
  string(STRIP "${line}" suite)
  string(REGEX REPLACE "\\.$" "" suite "${suite}")
  string(APPEND entries
    "add_test([=[${PREFIX}.${suite}]=] [=[${PROGRAM}]=] [=[--gtest_filter=${suite}.*]=])\n"
    "set_tests_properties([=[${PREFIX}.${suite}]=] PROPERTIES LABELS [=[${LABELS}]=] TIMEOUT ${TIMEOUT}\n"
    # Only where every test of the suite was skipped: this property rules over a failure.
    "  SKIP_REGULAR_EXPRESSION [=[PASSED  . 0 tests.[\r\n]+.  SKIPPED]=])\n")
endforeach()
file(WRITE ${OUT} "${entries}")
