#!/usr/bin/env bash
# Builds qray, starts its server, posts a first job to look at, and stays up until Ctrl-C.
#   bash server/start.sh [--port N] [--data DIR] [--once [--out DIR]]
# --once waits for the job instead, writes its picture as PNG and EXR into --out (the current
# folder), stops the server and exits with 0. If anything fails, a message says what, and the exit
# code is not 0.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build="$root/build/start"
port=8080
data="$root/data"
out="$PWD"
once=no
scene=thesis-room
samples=64
server_pid=""

say() { echo "start.sh: $*"; }
fail() {
  echo "start.sh: $*" >&2
  exit 1
}

stop_server() {
  [ -n "$server_pid" ] || return 0
  kill -TERM "$server_pid" 2> /dev/null || true
  wait "$server_pid" 2> /dev/null || true
  server_pid=""
}
trap stop_server EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

while [ $# -gt 0 ]; do
  case "$1" in
    --port) port="${2:?--port: expected a number}"; shift ;;
    --data) data="${2:?--data: expected a folder}"; shift ;;
    --out) out="${2:?--out: expected a folder}"; shift ;;
    --once) once=yes ;;
    -h | --help) sed -n '2,6s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) fail "unknown option '$1': see --help" ;;
  esac
  shift
done
[[ "$port" =~ ^[0-9]{1,5}$ ]] || fail "--port: expected a number, got '$port'"
mkdir -p "$out" || fail "cannot make the folder $out"

# Step 1: what is needed, and the build.
bash "$root/docker/install.sh" build || fail "the packages above could not be installed"
options=(-DCMAKE_BUILD_TYPE=Release -DQRAY_TESTS=OFF -DCMAKE_UNITY_BUILD=ON)
grep -q avx2 /proc/cpuinfo || options+=(-DQRAY_ARCH=)
say "building into $build"
cmake -S "$root" -B "$build" -G Ninja "${options[@]}" > /dev/null || fail "cmake failed"
cmake --build "$build" -j "$(nproc)" --target qray qrayd || fail "the build failed"

# Step 2: the server. It prints where it listens once it does. Its log shows warnings and errors
# alone, unless QRAYD_LOG_LEVEL asks for more: `info` has jobs, `debug` requests and options too.
export QRAYD_LOG_LEVEL="${QRAYD_LOG_LEVEL:-warn}"
log="$(mktemp)"
"$build/bin/qrayd" --port "$port" --data "$data" > "$log" &
server_pid=$!
url=""
for _ in $(seq 300); do
  url="$(grep -om1 'http://[0-9.]*:[0-9]*' "$log" || true)"
  [ -z "$url" ] || break
  kill -0 "$server_pid" 2> /dev/null || break
  sleep 0.1
done
rm -f "$log"
if [ -z "$url" ]; then
  if ! kill -0 "$server_pid" 2> /dev/null; then
    server_pid=""
    fail "qrayd ended: see its message above"
  fi
  fail "qrayd does not say where it listens after 30 s"
fi

# Step 3: a job to look at, with the default method.
export QRAY_SERVER="$url"
job="$("$build/bin/qray" submit "$scene" --spp "$samples")" || fail "the job was refused"
say "the page:      $url"
say "its first job: $url/#job=$job ($scene, $samples samples a pixel)"
[ "$once" = yes ] || say "Ctrl-C stops the server; what it has is kept in $data"
code=0
"$build/bin/qray" watch "$job" || code=$?

if [ "$once" = yes ]; then
  [ "$code" -eq 0 ] || fail "job $job did not succeed (code $code)"
  for format in png exr; do
    "$build/bin/qray" fetch "$job" -o "$out/$scene.$format" || fail "no picture of job $job"
    say "wrote $out/$scene.$format"
  done
  stop_server
  exit 0
fi
[ "$code" -eq 0 ] && end="is done" || end="did not succeed (code $code)"
say "job $job $end; the server stays up at $url until Ctrl-C"
code=0
wait "$server_pid" || code=$?
server_pid=""
fail "qrayd ended by itself (code $code)"
