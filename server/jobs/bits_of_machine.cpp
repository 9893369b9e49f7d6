#include "server/jobs/bits_of_machine.h"

#include <gnu/libc-version.h>

#include "core/base/build_identity.h"

namespace qray::server {

std::string bits_of_machine() {
  std::string text =
      std::string(build_identity()).substr(0, 12) + " glibc-" + gnu_get_libc_version();
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) text += " avx2";
  if (__builtin_cpu_supports("fma")) text += " fma";
  if (__builtin_cpu_supports("avx512f")) text += " avx512f";
#endif
  return text;
}

}  // namespace qray::server
