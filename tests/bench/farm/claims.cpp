// How long claims take: `qray_claims URL [--jobs N] [--claimers N] [--work MS] [--every SECONDS]`.
// Queues so many jobs on a PostgreSQL, and lets so many workers (a thread each, with a store of its
// own) take them to their ends, each after so long a time that stands for rendering on machines of
// their own. Says how long claims and whole jobs took, and what became of the tables, at the end
// and, if asked, every so many seconds.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <thread>

#include "server/postgres/pg_job_store.h"

namespace qray::server {
namespace {

using Clock = std::chrono::steady_clock;

int64_t now_ms() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

double percentile(std::vector<double>& values, double p) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const auto at = static_cast<size_t>(p / 100 * static_cast<double>(values.size() - 1));
  return values[at];
}

struct Process {
  Process(const std::string& url, bool publishes)
      : db(PgDatabase::open(url).value()),
        store(*db, events, now_ms, PgOptions{publishes, std::chrono::seconds(15)}) {}
  EventLog events;
  std::unique_ptr<PgDatabase> db;
  PgJobStore store;
};

void print_tables(PgDatabase& db) {
  PgDatabase::Session session(db);
  const auto rows = session.run(
      "SELECT relname, n_live_tup, n_dead_tup, n_tup_upd, n_tup_hot_upd, "
      "pg_total_relation_size(relid) / 1024, autovacuum_count FROM pg_stat_user_tables WHERE "
      "schemaname=current_schema() AND pg_total_relation_size(relid) > 100000 ORDER BY 6 DESC");
  if (!rows.ok()) return;
  std::printf("table            live    dead  updates     hot     KiB vacuums\n");
  for (int row = 0; row < rows.value().size(); ++row) {
    std::printf("%-14s", rows.value().text(row, 0).c_str());
    for (int column = 1; column < 7; ++column)
      std::printf(" %7lld", static_cast<long long>(rows.value().integer(row, column)));
    std::printf("\n");
  }
}

int run(const std::string& url, int jobs, int claimers, int work_ms, int every_seconds) {
  Process front(url, true);
  if (!front.store.recover().ok()) return 1;
  JobStore::Posted posted;
  posted.request.set(field::kScene, "box");
  posted.request.set(field::kSamples, 1);
  const std::vector<JobStore::Posted> batch(100, posted);
  auto begin = Clock::now();
  for (int done = 0; done < jobs; done += 100)
    for (const auto& one : front.store.insert(batch, batch.size()))
      if (!one.ok()) return std::fprintf(stderr, "%s\n", one.error().text().c_str()), 1;
  std::printf("%d jobs queued in %.1f s\n", jobs, ms_since(begin) / 1000);

  std::mutex mutex;
  std::vector<double> claims, lives;
  std::atomic<int> ended = 0, failed = 0;
  std::vector<std::thread> threads;
  begin = Clock::now();
  for (int i = 0; i < claimers; ++i)
    threads.emplace_back([&] {
      Process worker(url, false);
      if (!worker.store.recover().ok()) ++failed;
      std::vector<double> my_claims, my_lives;
      for (;;) {
        const auto at = Clock::now();
        const auto job = worker.store.claim(false);
        if (!job.ok()) {
          std::fprintf(stderr, "%s\n", job.error().text().c_str());
          ++failed;
          continue;
        }
        if (!job.value()) break;
        my_claims.push_back(ms_since(at));
        std::this_thread::sleep_for(std::chrono::milliseconds(work_ms));
        JobStore::Change mine;
        mine.claim = job.value()->claim;
        for (const JobState to :
             {JobState::kRendering, JobState::kFinalizing, JobState::kSucceeded})
          if (const auto moved = worker.store.move(job.value()->id, to, mine); !moved.ok()) {
            std::fprintf(stderr, "%s\n", moved.error().text().c_str());
            ++failed;
          }
        my_lives.push_back(ms_since(at));
        ++ended;
      }
      std::lock_guard lock(mutex);
      claims.insert(claims.end(), my_claims.begin(), my_claims.end());
      lives.insert(lives.end(), my_lives.begin(), my_lives.end());
    });
  std::atomic<bool> over = false;
  std::thread watch([&] {
    for (int s = 1; every_seconds > 0 && !over; ++s) {
      std::this_thread::sleep_for(std::chrono::seconds(1));
      if (s % every_seconds != 0) continue;
      std::printf("after %d s, %d jobs\n", s, ended.load());
      print_tables(*front.db);
      std::fflush(stdout);
    }
  });
  for (std::thread& thread : threads) thread.join();
  over = true;
  watch.join();
  const double seconds = ms_since(begin) / 1000;
  std::printf("%d claimers, %d ms of work: %d jobs in %.1f s, %.0f a second; %d errors\n", claimers,
              work_ms, ended.load(), seconds, ended.load() / seconds, failed.load());
  std::printf("claim: median %.2f ms, p99 %.2f ms, most %.2f ms; a whole job: median %.1f ms\n",
              percentile(claims, 50), percentile(claims, 99), percentile(claims, 100),
              percentile(lives, 50));
  print_tables(*front.db);
  return failed > 0 || ended != jobs ? 1 : 0;
}

}  // namespace
}  // namespace qray::server

int main(int argc, char** argv) {
  std::map<std::string, int> options{
      {"--jobs", 10'000}, {"--claimers", 32}, {"--work", 0}, {"--every", 0}};
  bool good = argc >= 2 && argc % 2 == 0;
  for (int i = 2; good && i + 1 < argc; i += 2) {
    const auto found = options.find(argv[i]);
    good = found != options.end();
    if (good) found->second = std::atoi(argv[i + 1]);
  }
  if (!good) {
    std::fprintf(stderr, "qray_claims URL [--jobs N] [--claimers N] [--work MS] [--every S]\n");
    return 2;
  }
  return qray::server::run(argv[1], options["--jobs"], options["--claimers"], options["--work"],
                           options["--every"]);
}
