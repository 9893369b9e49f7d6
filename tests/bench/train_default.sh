#!/usr/bin/env bash
# Makes the network of core/recover/default.qrw anew, from the one that is there on:
# `bash tests/bench/train_default.sh BUILD_DIR WORK TESTDATA`. TESTDATA: a folder with staircase2
# and obj-cornell-dev. WORK keeps the views, and gets default.qrw. It takes an hour on 2 idle cores;
# the environment's ROOMS and STEPS make it shorter. `peers/compare_oidn.py` says what it is worth.
set -euo pipefail

qray=${1:?usage: train_default.sh BUILD_DIR WORK TESTDATA}/bin/qray
work=${2:?}
data=${3:?}
rooms=${ROOMS:-25}
steps=${STEPS:-10000}
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
mkdir -p "$work"/{rooms,rare,other,included}

last="$here/../../core/recover/default.qrw"

train() {
  "$qray" recover train "$@" --held-out 1 --guided-targets --first "$last"
}
# Keeps views of these scenes.
take() {
  local folder=$1
  shift
  train "$@" --keep-views "$work/$folder" --steps 0 -o "$work/unused.qrw"
}

# Where light is rare, pictures of few samples have most to learn from.
take rare ajar-door lamp-room --views 20 --inputs 3 --most-spp 16 --target-spp 160
take rooms cornell-box --generated "$rooms" --seed 901 --views 12 --inputs 2 --target-spp 128
take other "$data/staircase2/scene_v0.5.xml" --views 24 --inputs 2 --target-spp 160
take other studio glass-caustic many-lights "$data"/obj-cornell-dev/CornellBox-{Sphere,Mirror}.obj \
  --views 6 --inputs 2 --target-spp 128

# Of the scenes named here views are kept apart, and tell the error while it trains.
train thesis-room cornell-box ajar-door --views 12 --inputs 3 --target-spp 128 \
  --keep-views "$work/included" --more-views "$work"/{rooms,rare,other}/*.views \
  --steps "$steps" --keep mean -o "$work/default.qrw"
