#include "core/base/process_name.h"

#include <sys/random.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>

#include "core/base/check.h"

namespace qray {
namespace {

std::string make_name() {
  uint64_t random = 0;
  QRAY_CHECK(::getrandom(&random, sizeof random, 0) == sizeof random);
  char text[48];
  std::snprintf(text, sizeof text, "%d-%016llx", static_cast<int>(::getpid()),
                static_cast<unsigned long long>(random));
  return text;
}

}  // namespace

const std::string& process_name() {
  static const std::string name = make_name();
  return name;
}

}  // namespace qray
