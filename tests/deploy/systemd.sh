#!/usr/bin/env bash
# The unit against systemd's own checks, and against what the server does: `systemd.sh BUILD`.
# No service manager runs here, so the filter of system calls is compared with a trace of a server
# that renders a job and reads an upload.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="${1:?expected the build folder}"
worst_exposure=12  # tenths; 100 is no protection at all
scratch="$(mktemp -d)"
server_pid=""
finish() {
  [ -z "$server_pid" ] || kill -KILL "$server_pid" 2> /dev/null || true
  rm -rf "$scratch"
}
trap finish EXIT
fail() {
  echo "systemd.sh: $*" >&2
  exit 1
}

# Step 1: systemd's checks, with the program where it is here.
bash "$root/docker/build.sh" "$scratch/prefix" "$build"
unit="$scratch/qrayd.service"
sed "s|/usr/local/bin/|$scratch/prefix/bin/|" "$root/docker/systemd/qrayd.service" > "$unit"
said="$(systemd-analyze verify "$unit" 2>&1)" || fail "verify: $said"
[ -z "$said" ] || fail "verify: $said"
systemd-analyze security --offline=yes --threshold="$worst_exposure" "$unit" \
  > "$scratch/security" || fail "exposure: $(tail -n 1 "$scratch/security")"
tail -n 1 "$scratch/security"

# Step 2: what the server calls; not as root, for whom SQLite does more.
mkdir "$scratch/data"
as_user=()
if [ "$(id -u)" -eq 0 ]; then
  chown nobody "$scratch/data"
  chmod 755 "$scratch"
  as_user=(-u nobody)
fi
: > "$scratch/out"  # the loop below may read it before the server's shell has opened it
strace -f -qq -e signal=none -o "$scratch/trace" "${as_user[@]}" \
  "$scratch/prefix/bin/qrayd" --data "$scratch/data" --port 0 > "$scratch/out" 2> "$scratch/log" &
server_pid=$!
port=""
for _ in $(seq 600); do
  port="$(sed -n 's/.*:\([0-9]*\)$/\1/p' "$scratch/out")"
  [ -z "$port" ] || break
  sleep 0.1
done
[ -n "$port" ] || fail "qrayd does not say where it listens: $(cat "$scratch/log")"
export QRAY_SERVER="http://127.0.0.1:$port"
for scene in furnace "$root/scenes/cornell-box"; do  # the second is uploaded
  job="$("$build/bin/qray" submit "$scene" --size 32x32 --spp 4)" || fail "$scene was refused"
  "$build/bin/qray" wait "$job" --timeout 100 > /dev/null || fail "$scene did not succeed"
done
traced="$(pgrep -P "$server_pid")"
kill -TERM "$traced"
wait "$server_pid" || fail "qrayd ended with $?"
server_pid=""

# Step 3: the filter, spelled out: @groups name groups and calls.
calls_of() {
  local name
  for name in "$@"; do
    if [[ "$name" == @* ]]; then
      # shellcheck disable=SC2046  # words are meant
      calls_of $(systemd-analyze syscall-filter "$name" | grep -v '#' | tail -n +2)
    else
      echo "$name"
    fi
  done
}
calls_of @default | sort -u > "$scratch/may"
while IFS== read -r _ words; do
  read -ra names <<< "${words#\~}"
  calls_of "${names[@]}" | sort -u > "$scratch/names"
  if [[ "$words" == \~* ]]; then
    comm -23 "$scratch/may" "$scratch/names" > "$scratch/next"
  else
    sort -u "$scratch/may" "$scratch/names" > "$scratch/next"
  fi
  mv "$scratch/next" "$scratch/may"
done < <(grep '^SystemCallFilter=' "$unit")
sed -n 's/^[0-9]* *\([a-z_0-9]*\)(.*/\1/p' "$scratch/trace" | sort -u > "$scratch/does"
refused="$(comm -13 "$scratch/may" "$scratch/does" | tr '\n' ' ')"
[ -z "$refused" ] || fail "the filter refuses what the server calls: $refused"
# MemoryDenyWriteExecute=
if grep -E 'PROT_WRITE\|PROT_EXEC|PROT_EXEC\|PROT_WRITE' "$scratch/trace" > "$scratch/wx"; then
  fail "memory that is written and run: $(head -n 3 "$scratch/wx")"
fi
echo "systemd.sh: $(wc -l < "$scratch/does") system calls, all allowed"
