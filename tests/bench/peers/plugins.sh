#!/usr/bin/env bash
# Draws some seventy small scenes, one for each Mitsuba 3 plugin or parameter, with Mitsuba 3 and
# with qray, and says how far the means are apart: `bash tests/bench/peers/plugins.sh BUILD_DIR
# [NAME...]`; NAME is part of a plugin's. From the environment: RUNS (4, of each, other seeds).
# Mitsuba comes from PyPI into a scratch folder; where it cannot be had this says so and ends
# well.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build=${1:?usage: plugins.sh BUILD_DIR [NAME...]}
shift
peer="mitsuba numpy"
. "$here/with_peer.sh"
mkdir "$scratch/scenes"
"$venv/bin/python" "$here/plugins.py" "$build/bin/qray" "$scratch/scenes" "${RUNS:-4}" "$@"
