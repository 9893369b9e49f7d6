// A line between processes and a server on a socket of the file system, as bad networks have them:
// it delays what passes, is cut in the middle of a message, is closed one way only, or falls silent
// without a word.
#pragma once

#include <atomic>
#include <filesystem>
#include <map>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/scratch.h"

namespace qray::test {

class BadLine {
 public:
  // Listens in a folder of its own on a socket of the same name as `server` and carries to there.
  explicit BadLine(std::filesystem::path server);
  ~BadLine();  // cuts what it carries
  std::filesystem::path folder() const { return scratch_.path(); }

  // From now on; until then it is a good line. A connection that lies idle goes bad with its next
  // message.
  void go_bad(uint64_t seed);
  void be_good() { bad_ = false; }
  std::map<std::string, int> ends() const;  // of each kind so far

 private:
  enum class End { kCut, kClosedToServer, kClosedToClient, kSilent };
  // Of one connection: after so many bytes it ends so, and until then each message waits so long.
  struct Fate {
    size_t bytes;
    End end;
    std::chrono::milliseconds delay;
  };
  Fate draw();
  void accept();
  void carry(int client, int server);
  void note(End end);

  const std::filesystem::path server_;
  ScratchFolder scratch_;
  int listener_ = -1;
  std::atomic<bool> bad_ = false, over_ = false;
  mutable std::mutex mutex_;
  std::mt19937_64 random_;
  std::map<std::string, int> ends_;
  std::vector<std::thread> carriers_;
  std::thread acceptor_;
};

}  // namespace qray::test
