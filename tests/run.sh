#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test: `bash tests/run.sh [ctest arguments]`, such
# as `-L fast` or `-R Huang`. The unit tests run a second time, built with ASan and UBSan; so do the
# fuzz targets, a moment each, where there is clang. Ends with ctest's summary; its exit code is
# ctest's.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
jobs="$(nproc)"
bash "$root/docker/install.sh" build test
cd "$root"

options=(-DQRAY_WERROR=ON -DQRAY_UNITY=ON)
grep -q avx2 /proc/cpuinfo || options+=(-DQRAY_ARCH=)

cmake --preset asan "${options[@]}"
cmake --build --preset asan -j "$jobs" --target core_tests proto_tests server_tests
fuzz_bin=""
if command -v clang++ > /dev/null; then
  cmake --preset fuzz "${options[@]}"
  cmake --build --preset fuzz -j "$jobs"
  fuzz_bin="$root/build/fuzz/bin"
else
  echo "run.sh: no clang++, so the fuzz targets are left out"
fi
cmake --preset release "${options[@]}" "-DQRAY_SANITIZED_BIN=$root/build/asan/bin" \
  "-DQRAY_FUZZ_BIN=$fuzz_bin"
cmake --build --preset release -j "$jobs"
exec ctest --test-dir "$root/build/release" --output-on-failure -j "$jobs" "$@"
