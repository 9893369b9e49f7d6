#!/usr/bin/env bash
# Renders Mitsuba scenes with qray and with Mitsuba 3 and says how far they agree and how fast each
# is: `bash tests/bench/peers/mitsuba.sh BUILD_DIR SCENE.xml...`. From the environment: SPP (256),
# SIZE (256: the longer side, pixels), RUNS (4, of each, other seeds), KEEP (a folder for the
# pictures), DEPTH (paths of both meet at most so many surfaces and play no Russian roulette), FIRST
# (1: the time from each program's start to a picture of one sample, SIZE 64 pixels, RUNS times in
# turn), MITSUBA_VARIANT (scalar_rgb; llvm_ad_rgb shades waves of paths in vectors, and needs LLVM
# in DRJIT_LIBLLVM_PATH) and AVX2 (1: llvm_ad_rgb and its Embree make vectors of 8 at most, as on a
# processor without AVX-512). Mitsuba comes from PyPI into a scratch folder; where it cannot be had
# this says so and ends well.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build=${1:?usage: mitsuba.sh BUILD_DIR SCENE.xml...}
shift
peer="mitsuba numpy"
. "$here/with_peer.sh"
script=compare_mitsuba.py
if [ "${FIRST:-0}" = 1 ]; then script=first_pictures.py SIZE="${SIZE:-64}"; fi
if [ "${AVX2:-}" ]; then
  export HOME="$scratch"  # where Embree 3 looks for what it may use
  echo max_isa=avx2 > "$HOME/.embree3"
fi
"$venv/bin/python" "$here/$script" "$build/bin/qray" "${KEEP:-$scratch/kept}" "${SIZE:-256}" \
  "${SPP:-256}" "${RUNS:-4}" "$@"
