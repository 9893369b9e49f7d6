// Ctrl-C during `qray render`, in a process of its own.
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "core/cmd/commands.h"
#include "tests/support/places.h"
#include "tests/support/scratch.h"

extern char** environ;

namespace qray::test {
namespace {

TEST(RenderProcess, CancelsCleanlyOnCtrlC) {
  const ScratchFolder scratch;
  const std::string out = (scratch / "out.exr").string();
  const std::string program = test::program("qray").string();
  std::vector<std::string> arguments{program,   "render",    "cornell-box", "-q", "--spp",
                                     "1000000", "--threads", "1",           "-o", out};
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  ASSERT_EQ(posix_spawn(&child, program.c_str(), nullptr, nullptr, argv.data(), environ), 0);
  // Long enough to be rendering, not a bound on anything: an early signal would end it by itself.
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, WNOHANG), 0) << "it ended before the signal";
  ASSERT_EQ(kill(child, SIGINT), 0);
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status)) << "killed by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), cmd::kExitCanceled);
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
}

}  // namespace
}  // namespace qray::test
