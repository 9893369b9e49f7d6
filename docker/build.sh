#!/usr/bin/env bash
# Builds qray and installs it: `bash docker/build.sh PREFIX [BUILD]`. With BUILD, a build tree of
# this source, installs from that and compiles nothing. QRAY_ARCH in the environment: -march, empty
# for any x86-64 processor. Says which shared libraries are missing, and fails when any are.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
prefix="${1:?expected the folder to install into}"
build="${2:-}"

if [ -z "$build" ]; then
  build="$root/build/package"
  cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DQRAY_TESTS=OFF \
    -DQRAY_ARCH="${QRAY_ARCH-}"
  cmake --build "$build" -j "${JOBS:-$(nproc)}" --target qray qrayd
fi
cmake --install "$build" --prefix "$prefix" --strip > /dev/null

for file in bin/qray bin/qrayd lib/qray/qray_openimageio.so; do
  missing="$(ldd "$prefix/$file" | grep 'not found' || true)"
  if [ -n "$missing" ]; then
    echo "build.sh: $file lacks: $missing" >&2
    exit 1
  fi
done
