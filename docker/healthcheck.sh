#!/usr/bin/env bash
# Exits 0 when qrayd answers: `bash docker/healthcheck.sh [HOST] [PORT] [PATH]`. Bash alone: an
# image of the server has no curl. PATH: /healthz, it lives; /readyz, it takes jobs.
set -euo pipefail

host="${1:-127.0.0.1}"
port="${2:-8080}"
path="${3:-/healthz}"

exec 3<> "/dev/tcp/$host/$port" || exit 1
printf 'GET %s HTTP/1.1\r\nHost: %s\r\nConnection: close\r\n\r\n' "$path" "$host:$port" >&3
IFS= read -r -t 4 status <&3 || { echo "no answer within 4 s" >&2; exit 1; }
if [[ "$status" != "HTTP/1.1 200 "* ]]; then
  echo "${status%$'\r'}" >&2
  exit 1
fi
