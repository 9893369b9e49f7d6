#!/usr/bin/env bash
# Runs a program as its container would: `bash docker/confined.sh DATA PROGRAM [ARGS...]`. Root
# gives itself up (user nobody, no capabilities, none to be had) below a root file system that is
# read-only but for DATA; any other user only cannot gain rights. The process stays this one, so
# signals reach the program.
set -euo pipefail

data="${1:?expected the data folder}"
shift
if [ "$(id -u)" -ne 0 ]; then exec setpriv --no-new-privs "$@"; fi

chown -R nobody:nogroup "$data"
give_up=(setpriv --reuid nobody --regid nogroup --clear-groups --inh-caps=-all
  --bounding-set=-all --no-new-privs)
if ! unshare --mount true 2> /dev/null; then exec "${give_up[@]}" "$@"; fi
# The binding makes DATA a mount of its own, which the root's flag does not reach.
exec unshare --mount --propagation private bash -c \
  'mount --bind "$1" "$1" && mount -o remount,bind,ro / && shift && exec "$@"' \
  confined "$data" "${give_up[@]}" "$@"
