#!/usr/bin/env bash
# Makes the network for all pixels of core/recover/default.qrw anew, from the one that is there on:
# `bash tests/bench/train_default.sh BUILD_DIR WORK TESTDATA`. TESTDATA: a folder with staircase2
# and obj-cornell-dev. WORK keeps the views, and gets default.qrw. It takes an hour on 2 idle cores;
# the environment's ROOMS and STEPS make it shorter. `peers/compare_oidn.py` says what it is worth.
set -euo pipefail

qray=${1:?usage: train_default.sh BUILD_DIR WORK TESTDATA}/bin/qray
work=${2:?}
data=${3:?}
rooms=${ROOMS:-50}
steps=${STEPS:-22000}
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
mkdir -p "$work"/{rooms,other,included}

last="$here/../../core/recover/default.qrw"

train() {
  "$qray" recover train "$@" --held-out 1 --guided-targets --blocks "$last"
}
# Keeps views of these scenes.
take() {
  local folder=$1
  shift
  train "$@" --keep-views "$work/$folder" --pyramid-steps 0 -o "$work/unused.qrw"
}

take rooms cornell-box --generated "$rooms" --seed 501 --views 12 --inputs 2 --target-spp 128
take other "$data/staircase2/scene_v0.5.xml" --views 24 --inputs 2 --target-spp 160
take other studio glass-caustic many-lights "$data"/obj-cornell-dev/CornellBox-{Sphere,Mirror}.obj \
  --views 6 --inputs 2 --target-spp 128

# Of the scenes named here views are kept apart, and tell the error while it trains.
train thesis-room cornell-box ajar-door --views 12 --inputs 3 --target-spp 128 \
  --keep-views "$work/included" --more-views "$work"/rooms/*.views "$work"/other/*.views \
  --pyramid-steps "$steps" -o "$work/default.qrw"
