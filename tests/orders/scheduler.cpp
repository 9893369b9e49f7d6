#include "tests/orders/scheduler.h"

#include <dlfcn.h>
#include <linux/futex.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <ctime>
#include <unordered_map>
#include <vector>

#include "tests/support/sanitized.h"

// Sanitizers define these themselves.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

constexpr int64_t kNever = INT64_MAX;
constexpr int64_t kSecond = 1'000'000'000;

struct Thread {
  enum class Is { kReady, kMutex, kCondition, kJoin, kDone };
  Is is = Is::kReady;
  const void* on = nullptr;  // what it waits for
  int64_t until = kNever;    // virtual ns: it waits no longer
  bool timed_out = false;
  int number = 0;
  uint64_t stalls_until = 0;  // by Schedule::choices
  sem_t turn;
  void* (*body)(void*) = nullptr;
  void* argument = nullptr;
  pthread_t handle{};
};

struct Held {
  Thread* owner = nullptr;
  int times = 0;
};

// The one thread whose turn it is reads and writes all this.
struct Schedule {
  std::vector<Thread*> threads;
  std::unordered_map<const void*, Held> mutexes;
  int64_t now = 1000 * kSecond;
  uint64_t random = 0, choices = 0;
  uint64_t switch_in = 4;  // at a point where it could go on, one of so many lets another
  std::function<void(const std::string&)> on_deadlock;

  uint64_t choice(uint64_t most) {  // splitmix64
    uint64_t z = random += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return (z ^ (z >> 31)) % most;
  }
};

Schedule* schedule = nullptr;  // lives as long as the process
thread_local Thread* self = nullptr;

template <class F>
F next_definition(const char* name, const char* version = nullptr) {
  void* found = version ? ::dlvsym(RTLD_NEXT, name, version) : nullptr;
  if (!found) found = ::dlsym(RTLD_NEXT, name);
  if (!found) std::abort();
  return reinterpret_cast<F>(found);
}

void wait_for_turn(Thread& thread) {
  while (::sem_wait(&thread.turn) != 0) {
  }
}

void wake(Thread& thread, bool timed_out = false) {
  thread.is = Thread::Is::kReady;
  thread.on = nullptr;
  thread.until = kNever;
  thread.timed_out = timed_out;
}

Thread* first_to_wake() {
  Thread* first = nullptr;
  for (Thread* thread : schedule->threads)
    if (thread->is == Thread::Is::kCondition && thread->until != kNever &&
        (!first || thread->until < first->until))
      first = thread;
  return first;
}

[[noreturn]] void deadlock() {
  std::string who;
  constexpr const char* kStates[] = {"ready", "mutex", "condition", "join", "done"};
  for (const Thread* thread : schedule->threads)
    if (thread->is != Thread::Is::kDone)
      who += " " + std::to_string(thread->number) + ":" + kStates[static_cast<int>(thread->is)];
  schedule->on_deadlock("all threads wait:" + who);
  ::_exit(3);
}

Thread* choose(bool other) {
  constexpr uint64_t kEarlyWakeIn = 100;
  if (schedule->choice(kEarlyWakeIn) == 0)
    if (Thread* early = first_to_wake()) {
      schedule->now = std::max(schedule->now, early->until);
      wake(*early, true);
    }
  ++schedule->choices;
  std::vector<Thread*> ready, stalled;
  for (Thread* thread : schedule->threads)
    if (thread->is == Thread::Is::kReady && !(other && thread == self))
      (thread->stalls_until > schedule->choices ? stalled : ready).push_back(thread);
  if (!ready.empty()) return ready[schedule->choice(ready.size())];
  // Time may pass while one stalls.
  constexpr uint64_t kStallEndsIn = 4;
  if (!stalled.empty() && (!first_to_wake() || schedule->choice(kStallEndsIn) == 0))
    return stalled[schedule->choice(stalled.size())];
  if (self->is == Thread::Is::kReady) return self;
  Thread* first = first_to_wake();
  if (!first) deadlock();
  schedule->now = std::max(schedule->now, first->until);
  wake(*first, true);
  return first;
}

// Another's turn; returns when it is this thread's again.
void pass_on(bool other) {
  Thread* next = choose(other);
  if (next == self) return;
  Thread& me = *self;
  ::sem_post(&next->turn);
  wait_for_turn(me);
}

// Where another may come between; now and then many do, as when the system takes the processor away
// at the worst moment.
void meet() {
  constexpr uint64_t kStallIn = 100, kLongestStall = 1000;
  if (schedule->choice(kStallIn) == 0) {
    self->stalls_until = schedule->choices + schedule->choice(kLongestStall);
    return pass_on(/*other=*/true);
  }
  if (schedule->choice(schedule->switch_in) == 0) pass_on(/*other=*/false);
}

bool is_recursive(const pthread_mutex_t* mutex) {
  return (mutex->__data.__kind & 3) == PTHREAD_MUTEX_RECURSIVE_NP;
}

int take(pthread_mutex_t* mutex) {
  for (;;) {
    Held& held = schedule->mutexes[mutex];
    if (!held.owner || (held.owner == self && is_recursive(mutex))) {
      held.owner = self;
      ++held.times;
      return 0;
    }
    self->is = Thread::Is::kMutex;
    self->on = mutex;
    pass_on(/*other=*/true);
  }
}

void give_back(pthread_mutex_t* mutex) {
  const auto found = schedule->mutexes.find(mutex);
  if (found == schedule->mutexes.end() || --found->second.times > 0) return;
  schedule->mutexes.erase(found);
  for (Thread* thread : schedule->threads)
    if (thread->is == Thread::Is::kMutex && thread->on == mutex) wake(*thread);
}

int wait_on(const void* condition, pthread_mutex_t* mutex, int64_t until) {
  if (mutex) give_back(mutex);
  self->is = Thread::Is::kCondition;
  self->on = condition;
  self->until = until;
  pass_on(/*other=*/true);
  const bool timed_out = self->timed_out;
  if (mutex) take(mutex);
  return timed_out ? ETIMEDOUT : 0;
}

int64_t real_time_offset() { return 1'700'000'000 * kSecond; }

int64_t virtual_ns(const timespec& time, clockid_t clock) {
  const int64_t ns = time.tv_sec * kSecond + time.tv_nsec;
  return clock == CLOCK_REALTIME ? ns - real_time_offset() : ns;
}

void* run_thread(void* of) {
  Thread& me = *static_cast<Thread*>(of);
  wait_for_turn(me);
  self = &me;
  void* result = me.body(me.argument);
  me.is = Thread::Is::kDone;
  for (Thread* thread : schedule->threads)
    if (thread->is == Thread::Is::kJoin && thread->on == &me) wake(*thread);
  Thread* next = choose(/*other=*/true);
  self = nullptr;
  ::sem_post(&next->turn);
  return result;
}

int sleep_for(const timespec* time) {
  wait_on(nullptr, nullptr, schedule->now + time->tv_sec * kSecond + time->tv_nsec);
  return 0;
}

}  // namespace

namespace qray::test {

// Threads that take turns hand over faster on one processor.
void stay_on_this_processor() {
  cpu_set_t here;
  CPU_ZERO(&here);
  CPU_SET(::sched_getcpu(), &here);
  ::sched_setaffinity(0, sizeof here, &here);
}

void run_one_at_a_time(uint64_t seed, std::function<void(const std::string&)> on_deadlock) {
  stay_on_this_processor();
  schedule = new Schedule;
  schedule->random = seed;
  schedule->on_deadlock = std::move(on_deadlock);
  constexpr uint64_t kPaces[] = {2, 8, 40};  // what is found differs with how often threads meet
  schedule->switch_in = kPaces[schedule->choice(std::size(kPaces))];
  Thread* me = new Thread;
  ::sem_init(&me->turn, 0, 0);
  schedule->threads.push_back(me);
  self = me;
}

void sleep_virtually(double seconds) {
  wait_on(nullptr, nullptr, schedule->now + static_cast<int64_t>(seconds * kSecond));
}

uint64_t scheduled_choice(uint64_t most) { return schedule->choice(most); }

}  // namespace qray::test

extern "C" {

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  static const auto real = next_definition<int (*)(pthread_mutex_t*)>("pthread_mutex_lock");
  if (!self) return real(mutex);
  meet();
  return take(mutex);
}

int pthread_mutex_trylock(pthread_mutex_t* mutex) noexcept {
  static const auto real = next_definition<int (*)(pthread_mutex_t*)>("pthread_mutex_trylock");
  if (!self) return real(mutex);
  meet();
  const auto held = schedule->mutexes.find(mutex);
  const bool free =
      held == schedule->mutexes.end() || (held->second.owner == self && is_recursive(mutex));
  return free ? take(mutex) : EBUSY;
}

int pthread_mutex_unlock(pthread_mutex_t* mutex) noexcept {
  static const auto real = next_definition<int (*)(pthread_mutex_t*)>("pthread_mutex_unlock");
  if (!self) return real(mutex);
  give_back(mutex);
  return 0;
}

int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  static const auto real = next_definition<int (*)(pthread_cond_t*, pthread_mutex_t*)>(
      "pthread_cond_wait", "GLIBC_2.3.2");
  return self ? wait_on(condition, mutex, kNever) : real(condition, mutex);
}

int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const timespec* until) {
  static const auto real =
      next_definition<int (*)(pthread_cond_t*, pthread_mutex_t*, clockid_t, const timespec*)>(
          "pthread_cond_clockwait");
  return self ? wait_on(condition, mutex, virtual_ns(*until, clock))
              : real(condition, mutex, clock, until);
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                           const timespec* until) {
  static const auto real =
      next_definition<int (*)(pthread_cond_t*, pthread_mutex_t*, const timespec*)>(
          "pthread_cond_timedwait", "GLIBC_2.3.2");
  return self ? wait_on(condition, mutex, virtual_ns(*until, CLOCK_REALTIME))
              : real(condition, mutex, until);
}

int pthread_cond_signal(pthread_cond_t* condition) noexcept {
  static const auto real =
      next_definition<int (*)(pthread_cond_t*)>("pthread_cond_signal", "GLIBC_2.3.2");
  if (!self) return real(condition);
  std::vector<Thread*> waiting;
  for (Thread* thread : schedule->threads)
    if (thread->is == Thread::Is::kCondition && thread->on == condition) waiting.push_back(thread);
  if (!waiting.empty()) wake(*waiting[schedule->choice(waiting.size())]);
  return 0;
}

int pthread_cond_broadcast(pthread_cond_t* condition) noexcept {
  static const auto real =
      next_definition<int (*)(pthread_cond_t*)>("pthread_cond_broadcast", "GLIBC_2.3.2");
  if (!self) return real(condition);
  for (Thread* thread : schedule->threads)
    if (thread->is == Thread::Is::kCondition && thread->on == condition) wake(*thread);
  return 0;
}

int pthread_create(pthread_t* handle, const pthread_attr_t* attributes, void* (*body)(void*),
                   void* argument) noexcept {
  static const auto real =
      next_definition<int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>(
          "pthread_create", "GLIBC_2.34");
  if (!self) return real(handle, attributes, body, argument);
  auto* thread = new Thread;
  ::sem_init(&thread->turn, 0, 0);
  thread->number = static_cast<int>(schedule->threads.size());
  thread->body = body;
  thread->argument = argument;
  const int made = real(&thread->handle, attributes, run_thread, thread);
  if (made != 0) return made;
  *handle = thread->handle;
  schedule->threads.push_back(thread);
  meet();
  return 0;
}

int pthread_join(pthread_t handle, void** result) {
  static const auto real =
      next_definition<int (*)(pthread_t, void**)>("pthread_join", "GLIBC_2.34");
  if (!self) return real(handle, result);
  for (auto it = schedule->threads.begin(); it != schedule->threads.end(); ++it) {
    Thread* thread = *it;
    if (!pthread_equal(thread->handle, handle) || thread == schedule->threads.front()) continue;
    if (thread->is != Thread::Is::kDone) {
      self->is = Thread::Is::kJoin;
      self->on = thread;
      pass_on(/*other=*/true);
    }
    std::erase(schedule->threads, thread);
    break;
  }
  return real(handle, result);
}

int sched_yield() noexcept {
  if (self) pass_on(/*other=*/true);
  return 0;
}

int nanosleep(const timespec* time, timespec* left) {
  static const auto real = next_definition<int (*)(const timespec*, timespec*)>("nanosleep");
  return self ? sleep_for(time) : real(time, left);
}

int clock_nanosleep(clockid_t clock, int flags, const timespec* time, timespec* left) {
  static const auto real =
      next_definition<int (*)(clockid_t, int, const timespec*, timespec*)>("clock_nanosleep");
  return self && flags == 0 ? sleep_for(time) : real(clock, flags, time, left);
}

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  if (!self || (clock != CLOCK_MONOTONIC && clock != CLOCK_REALTIME))
    return static_cast<int>(::syscall(SYS_clock_gettime, clock, time));
  schedule->now += 1000;
  const int64_t ns = schedule->now + (clock == CLOCK_REALTIME ? real_time_offset() : 0);
  *time = {ns / kSecond, ns % kSecond};
  return 0;
}

// Of a database. Long waits are for its answer, which comes soon unless another thread's statement
// must come first. Short ones are for news, and pass in virtual time.
int poll(pollfd* fds, nfds_t count, int milliseconds) {
  static const auto real = next_definition<int (*)(pollfd*, nfds_t, int)>("poll");
  constexpr int kForAnswers = 1000, kSoon = 2;
  if (!self || milliseconds <= 0) return real(fds, count, milliseconds);
  if (milliseconds < kForAnswers) {
    if (const int ready = real(fds, count, 0); ready != 0) return ready;
    wait_on(nullptr, nullptr, schedule->now + milliseconds * (kSecond / 1000));
    return real(fds, count, 0);
  }
  for (;;) {
    if (const int ready = real(fds, count, kSoon); ready != 0) return ready;
    pass_on(/*other=*/true);
  }
}

// std::atomic waits, and once-only initialisation, by futexes.
long syscall(long number, ...) noexcept {
  static const auto real =
      next_definition<long (*)(long, long, long, long, long, long, long)>("syscall");
  va_list rest;
  va_start(rest, number);
  long a[6];
  for (long& one : a) one = va_arg(rest, long);
  va_end(rest);
  const long command = a[1] & FUTEX_CMD_MASK;
  if (self && number == SYS_futex && (command == FUTEX_WAIT || command == FUTEX_WAIT_BITSET)) {
    pass_on(/*other=*/true);
    errno = EAGAIN;  // who waits looks again
    return -1;
  }
  return real(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}

}  // extern "C"

#endif
