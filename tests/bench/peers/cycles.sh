#!/usr/bin/env bash
# Renders glTF files with qray and with Blender's Cycles, which Blender's own importer reads them
# for, and says how far they agree: `bash tests/bench/peers/cycles.sh BUILD_DIR FILE...`. Of a file
# without light a copy is drawn that stands in a box which shines. From the environment: SPP (64),
# SIZE (160: the longer side, pixels), RUNS (4, of each, other seeds), KEEP (a folder for the
# pictures) and FACETS (GGX; MULTI_GGX is Blender's default). Blender comes from PyPI, for Python
# 3.11, into a scratch folder; where it cannot be had this says so and ends well.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build=${1:?usage: cycles.sh BUILD_DIR FILE...}
shift
peer="bpy==4.5.15 numpy"
. "$here/with_peer.sh"
kept="${KEEP:-$scratch/kept}"
mkdir -p "$kept"
"$venv/bin/python" "$here/compare_cycles.py" "$build/bin/qray" "$kept" "${SIZE:-160}" "${SPP:-64}" \
  "${RUNS:-4}" "$@"
