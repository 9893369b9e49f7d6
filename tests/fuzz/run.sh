#!/usr/bin/env bash
# Runs one fuzz target of the `fuzz` preset, or all in turn: `run.sh TARGET|all [libFuzzer's
# arguments]`. README.md says more.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build="$here/../../build/fuzz"
name="$1"
shift

if [ "$name" = all ]; then
  for folder in "$here"/corpus/*/; do bash "$0" "$(basename "$folder")" "$@"; done
  exit 0
fi

found="$build/found/$name"
mkdir -p "$found"
arguments=("$found" "$here/corpus/$name" "-artifact_prefix=$build/found/$name-" -timeout=10
  -rss_limit_mb=1536)
[ "$name" != json_scene ] || arguments+=("$here/../schema/corpus")
dict="$here/${name/glb/gltf}.dict"
[ ! -f "$dict" ] || arguments+=("-dict=$dict")
UBSAN_OPTIONS=print_stacktrace=1 exec "$build/bin/${name}_fuzz" "${arguments[@]}" "$@"
