#!/usr/bin/env bash
# Prints a hash for pictures and tables of every method in every included scene, so that two
# builds can be compared: `bash tests/bits/record.sh BIN > FILE` with the folder of qray and qrayd,
# then `diff` of two such files. The same build gives the same lines for any number of threads;
# other processors may give others, since recovery uses what vector instructions there are.
#   --quick: four scenes instead of seven, and no server.
set -euo pipefail

bin="$(cd "${1:?expected the folder of qray and qrayd}" && pwd)"
quick="${2:-}"
scenes="$(cd "$(dirname "${BASH_SOURCE[0]}")/../../scenes" && pwd)"
names=(ajar-door cornell-box glass-caustic lamp-room)
[ "$quick" = --quick ] || names+=(furnace many-lights thesis-room)
methods=(huang-published huang dahm-keller ppg adaptive)
scratch="$(mktemp -d)"
server_pid=""
trap '[ -z "$server_pid" ] || kill -9 "$server_pid" 2> /dev/null || true; rm -rf "$scratch"' EXIT

# Of a picture its pixels, since an EXR holds the time at which it was written.
hash_of() {
  case "$1" in
    *.exr) iinfo --hash "$1" | sed -n 's/.*SHA-1: //p' | cut -c1-24 ;;
    *) sha256sum < "$1" | cut -c1-24 ;;
  esac
}

# NAME ARGUMENTS: the hash of the picture, and of the table where TABLE names a file for it.
TABLE=""
render() {
  local name="$1" keeps=()
  shift
  [ -z "$TABLE" ] || keeps=(--table-out "$TABLE")
  "$bin/qray" render "$@" --size 48x48 --threads 2 "${keeps[@]}" -q -o "$scratch/p.exr" 2> /dev/null
  echo "$name: picture $(hash_of "$scratch/p.exr")${TABLE:+ table $(hash_of "$TABLE")}"
}

for scene in "${names[@]}"; do
  file="$scenes/$scene/scene.json"
  TABLE=""
  render "$scene none" "$file" --method none --spp 24 --seed 3
  render "$scene none, no nee" "$file" --method none --no-nee --spp 8
  render "$scene none, a quarter recovered" "$file" --method none --spp 2 --pixels quarter \
    --recover default
  for method in "${methods[@]}"; do
    TABLE="$scratch/cold.qrt"
    render "$scene $method cold" "$file" --method "$method" --spp 24 --seed 3
    TABLE="$scratch/warm.qrt"
    render "$scene $method warm" "$file" --method "$method" --spp 16 --seed 5 \
      --table-in "$scratch/cold.qrt"
  done
  TABLE="$scratch/other.qrt"
  render "$scene adaptive, no nee" "$file" --method adaptive --no-nee --spp 24
  render "$scene adaptive, gate off" "$file" --method 'adaptive:gate=off' --spp 24
  render "$scene adaptive, recovered" "$file" --method adaptive --spp 16 --recover default
  TABLE=""
  render "$scene adaptive, its gain" "$file" --view gain --table-in "$scratch/warm.qrt"
done
[ "$quick" != --quick ] || exit 0

# Jobs whose server is killed, and which go on.
start() {
  "$bin/qrayd" --port 0 --data "$scratch/data" --threads 2 > "$scratch/log" 2>&1 &
  server_pid=$!
  until QRAY_SERVER="$(grep -om1 'http://[0-9.]*:[0-9]*' "$scratch/log")"; do sleep 0.05; done
  export QRAY_SERVER
}
for method in none huang ppg adaptive; do
  start
  job="$("$bin/qray" submit cornell-box --method "$method" --spp 400 --size 128x128 --seed 9)"
  sleep 1.5
  kill -9 "$server_pid"
  wait "$server_pid" 2> /dev/null || true
  start
  "$bin/qray" wait "$job" > /dev/null
  "$bin/qray" fetch "$job" -o "$scratch/resumed.exr"
  echo "cornell-box $method, its server killed: picture $(hash_of "$scratch/resumed.exr")"
  kill -TERM "$server_pid"
  wait "$server_pid" 2> /dev/null || true
  rm -rf "$scratch/data"
done
