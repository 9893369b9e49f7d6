// Group commit: of the threads that come while one works, the next does the work of all. None waits
// longer than for the work under way and for its own. Any thread.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace qray::server {

template <class In, class Out>
class Gather {
 public:
  // `work`: an answer for each, in their order; by one thread at a time, of those that run() calls.
  explicit Gather(std::function<std::vector<Out>(std::span<const In>)> work)
      : work_(std::move(work)) {}

  Out run(In in) {
    Entry mine{std::move(in), std::nullopt};
    std::unique_lock lock(mutex_);
    waiting_.push_back(&mine);
    done_.wait(lock, [&] { return mine.out || !working_; });
    if (!mine.out) work_for_all(lock, mine);
    return *std::move(mine.out);
  }

 private:
  struct Entry {
    In in;
    std::optional<Out> out;
  };
  void work_for_all(std::unique_lock<std::mutex>& lock, const Entry& mine) {
    working_ = true;
    const std::vector<Entry*> entries = std::exchange(waiting_, {});
    lock.unlock();
    std::vector<In> ins;
    for (Entry* entry : entries) ins.push_back(entry->in);
    std::vector<Out> outs;
    const auto end = [&] {
      lock.lock();
      working_ = false;
      done_.notify_all();
    };
    try {
      outs = work_(ins);
    } catch (...) {  // this caller's; the others try for themselves
      end();
      for (Entry* entry : entries)
        if (entry != &mine) waiting_.push_back(entry);
      throw;
    }
    end();
    for (size_t i = 0; i < entries.size(); ++i) entries[i]->out = std::move(outs[i]);
  }

  const std::function<std::vector<Out>(std::span<const In>)> work_;
  std::mutex mutex_;
  std::condition_variable done_;
  bool working_ = false;
  std::vector<Entry*> waiting_;
};

}  // namespace qray::server
