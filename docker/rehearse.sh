#!/usr/bin/env bash
# What the image does, without an engine: `bash docker/rehearse.sh [BUILD]`. Builds with the
# Dockerfile's script into a scratch prefix (BUILD: installs from that build tree, compiles
# nothing), runs the server confined as in its container, waits for its health check, renders a job,
# checks that nothing but the data folder was written, and ends the server by SIGTERM. Says `good`
# and exits 0, or says what failed. `--packages` also asks whether group run covers every library.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
packages=no
if [ "${1:-}" = --packages ]; then
  packages=yes
  shift
fi
scratch="$(mktemp -d)"
server_pid=""
finish() {
  [ -z "$server_pid" ] || kill -KILL "$server_pid" 2> /dev/null || true
  chmod -R u+w "$scratch"
  rm -rf "$scratch"
}
trap finish EXIT
fail() {
  echo "rehearse.sh: $*" >&2
  [ ! -s "$scratch/log" ] || sed 's/^/  qrayd: /' "$scratch/log" >&2
  exit 1
}

# Step 1: the build stage.
prefix="$scratch/prefix"
bash "$here/build.sh" "$prefix" "$@" || fail "the build failed"
chmod -R a-w "$prefix"
chmod 755 "$scratch"  # the server's user goes through it

# Step 2: the libraries that the programs, and what they load, name belong to packages of group run,
# or to the system's.
if [ "$packages" = yes ]; then
  files=("$prefix"/bin/qray "$prefix"/bin/qrayd "$prefix"/lib/qray/*.so)
  wanted="$(readelf -d "${files[@]}" | sed -n 's/.*NEEDED.*\[\(.*\)\]/\1/p' | sort -u)"
  found="$(ldd "${files[@]}" | awk 'NF > 3 {print $1, $3}' | sort -u)"
  for library in $wanted; do
    file="$(awk -v l="$library" '$1 == l {print $2}' <<< "$found")"
    file="$(readlink -f "$file")"  # its package may know it without the /usr that /lib leads to
    package="$( (dpkg-query -S "$file" || dpkg-query -S "${file#/usr}") 2> /dev/null)"
    package="${package%%:*}"
    case "$package" in libc6 | libgcc-s1 | libstdc++6) continue ;; esac
    awk -v p="$package" '/^group:/ {run = $2 == "run"} run && $1 == p {found = 1}
      END {exit !found}' "$here/apt-packages.txt" ||
      fail "$library is of $package, which is not in group run of apt-packages.txt"
  done
fi

# Step 3: the container.
data="$scratch/data"
mkdir "$data"
QRAY_TOKEN="$("$prefix/bin/qrayd" token rehearsal submit 2>&1 > "$scratch/tokens" |
  sed -n 's/.*once: //p')"
export QRAY_TOKEN
: > "$scratch/out"  # the loop below may read it before the server's shell has opened it
bash "$here/confined.sh" "$data" "$prefix/bin/qrayd" --data "$data" --port 0 \
  --tokens "$scratch/tokens" \
  > "$scratch/out" 2> "$scratch/log" &
server_pid=$!
port=""
for _ in $(seq 300); do
  port="$(sed -n 's/.*:\([0-9]*\)$/\1/p' "$scratch/out")"
  [ -z "$port" ] || break
  kill -0 "$server_pid" 2> /dev/null || fail "qrayd ended"
  sleep 0.1
done
[ -n "$port" ] || fail "qrayd does not say where it listens"
bash "$here/healthcheck.sh" 127.0.0.1 "$port" || fail "the health check fails"
if [ "$(id -u)" -eq 0 ]; then
  [ "$(stat -c %U "/proc/$server_pid")" = nobody ] || fail "qrayd does not run as nobody"
fi

export QRAY_SERVER="http://127.0.0.1:$port"
qray="$prefix/bin/qray"
! QRAY_TOKEN="" "$qray" submit cornell-box 2> /dev/null || fail "a job without a token was taken"
job="$("$qray" submit cornell-box --size 64x64 --spp 4)" || fail "the job was refused"
"$qray" wait "$job" --timeout 60 > /dev/null || fail "the job did not succeed"
"$qray" fetch "$job" -o "$scratch/picture.png" || fail "no picture"
[ -s "$scratch/picture.png" ] || fail "the picture is empty"
[ -z "$(find "$prefix" -newer "$scratch/out" -print -quit)" ] || fail "the prefix was written to"

# Step 4: STOPSIGNAL.
kill -TERM "$server_pid"
code=0
wait "$server_pid" || code=$?
server_pid=""
[ "$code" -eq 0 ] || fail "qrayd ended with $code after SIGTERM"
! bash "$here/healthcheck.sh" 127.0.0.1 "$port" 2> /dev/null || fail "health without a server"
echo "rehearse.sh: good"
