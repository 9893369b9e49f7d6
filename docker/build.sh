#!/usr/bin/env bash
# Builds qray and installs it: `bash docker/build.sh PREFIX [BUILD]`. On x86-64 it builds twice: for
# any processor, and for those with AVX2 into lib/qray/x86-64-v3, as which the programs of bin go on
# where they can (core/base/installed.h). With BUILD, a build tree of this source, installs from
# that and compiles nothing. Says which shared libraries are missing, and fails when any are.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
prefix="${1:?expected the folder to install into}"
build="${2:-}"

compile() { # the build tree, -march
  cmake -S "$root" -B "$1" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON \
    -DQRAY_TESTS=OFF -DQRAY_ARCH="$2"
  cmake --build "$1" -j "${JOBS:-$(nproc)}" --target qray qrayd
}

if [ -z "$build" ]; then
  build="$root/build/package"
  compile "$build" ""
  if [ "$(uname -m)" = x86_64 ]; then
    compile "$build-x86-64-v3" x86-64-v3
    newer="$prefix/lib/qray/x86-64-v3"
    mkdir -p "$newer"
    install -s "$build-x86-64-v3"/bin/qray{,d} "$newer"
  fi
fi
cmake --install "$build" --prefix "$prefix" --strip > /dev/null

for file in bin/qray bin/qrayd lib/qray/qray_openimageio.so; do
  missing="$(ldd "$prefix/$file" | grep 'not found' || true)"
  if [ -n "$missing" ]; then
    echo "build.sh: $file lacks: $missing" >&2
    exit 1
  fi
done
