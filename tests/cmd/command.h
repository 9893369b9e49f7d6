// Runs a command line of qray inside the test and catches what it prints.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/cmd/commands.h"

namespace qray::test {

struct Outcome {
  int code = 0;
  std::string out, err;
};

inline Outcome qray_command(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv{"qray"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Outcome outcome;
  outcome.code = cmd::run_command_line(static_cast<int>(argv.size()), argv.data());
  std::fflush(stdout);
  outcome.out = ::testing::internal::GetCapturedStdout();
  outcome.err = ::testing::internal::GetCapturedStderr();
  return outcome;
}

}  // namespace qray::test
