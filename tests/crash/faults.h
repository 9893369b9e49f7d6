// Ends the process, or fails, at the k-th change of a file that the program makes: write, sync,
// rename, removal, creation. The functions of the C library that change files are defined again in
// faults.cpp, so that SQLite's calls and the C++ library's are counted too. Memory that parent and
// child share says what shall happen, so that a test arms it in a child from outside. What is sent
// to a database through a socket of this machine counts as a change too.
#pragma once

#include <atomic>
#include <cstdint>

namespace qray::test {

enum class Fault : int {
  kKill,      // in place of the change
  kTorn,      // likewise, after the first half of what a write writes; a statement is sent whole
  kError,     // this change alone fails: EIO; the line to the database is cut
  kFullDisk,  // this one and those after it fail where they need room: ENOSPC
};
inline constexpr const char* kFaultNames[] = {"kill", "torn", "EIO", "full disk"};

struct FaultPlan {
  std::atomic<bool> armed = false;
  std::atomic<int64_t> changes = 0;  // since it was armed
  std::atomic<int64_t> at = 0;       // the change that is meant; 0: none
  std::atomic<Fault> fault = Fault::kKill;
  std::atomic<int> port = 0;  // of the server in the child; -1: it does not start
  std::atomic<bool> stop = false;
};

// From now on changes that this process makes are counted: of the server's, not of the test's.
void count_changes_here();

// In memory that is shared with children; the same at every call.
FaultPlan& fault_plan();

}  // namespace qray::test
