// Runs the threads of this process one at a time and chooses by a seed whose turn it is, so that
// threads meet in the same order each time. The functions of the C library by which threads wait
// for each other (mutexes, conditions, joins, sleeps, futexes) are defined again in scheduler.cpp:
// the code under test is the server's own, unchanged. Time is virtual: a sleep ends when nobody
// else can go on, or now and then before, as under load. Threads that all wait for each other end
// the process, with a word about it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace qray::test {

// From now on, for the calling thread and those that it starts. Once in a process.
// `on_deadlock`: is told who waits; then the process ends.
void run_one_at_a_time(uint64_t seed, std::function<void(const std::string&)> on_deadlock);

// Lets others run, for so many seconds of virtual time.
void sleep_virtually(double seconds);
// A number below `most`, of the schedule's own.
uint64_t scheduled_choice(uint64_t most);

}  // namespace qray::test
