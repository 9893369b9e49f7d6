// What an installed program does before all else, compiled for any processor (processor_test.mjs).
#include <cstdio>

#include "core/base/installed.h"

int main(int, char** argv) {
  qray::run_program_of_processor(argv);
  std::printf("%s\n", qray::version_for_processor().c_str());
}
