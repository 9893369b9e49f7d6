#!/usr/bin/env bash
# Installs what is missing of docker/apt-packages.txt: `bash docker/install.sh build [test]`; its
# groups are build, run, test and soak. Needs root or sudo only when something is missing. `--list`
# prints the missing names instead; `--clean` drops apt's lists afterwards, as images want.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
list_only=no
clean=no
groups=" "
for arg in "$@"; do
  case "$arg" in
    --list) list_only=yes ;;
    --clean) clean=yes ;;
    build | run | test | soak) groups+="$arg " ;;
    *)
      echo "install.sh: expected build, run, test, soak, --list or --clean, got '$arg'" >&2
      exit 1
      ;;
  esac
done
[ "$groups" != " " ] || groups=" build "

missing=()
group=""
while read -r name condition command _; do
  case "$name" in
    "") continue ;;
    group:) group="$condition"; continue ;;
  esac
  [[ "$groups" == *" $group "* ]] || continue
  if [ "$condition" = if-no ] && command -v "$command" > /dev/null; then continue; fi
  status="$(dpkg-query -W -f '${db:Status-Status}' "$name" 2> /dev/null || true)"
  [ "$status" = installed ] || missing+=("$name")
done < <(sed 's/#.*//' "$here/apt-packages.txt")

if [ "$list_only" = yes ]; then
  [ ${#missing[@]} -eq 0 ] || printf '%s\n' "${missing[@]}"
  exit 0
fi
[ ${#missing[@]} -gt 0 ] || exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo > /dev/null; then
    echo "install.sh: missing packages: ${missing[*]}" >&2
    echo "install.sh: run as root, or install sudo, or install these packages yourself" >&2
    exit 1
  fi
  as_root=(sudo)
fi
echo "install.sh: installing ${missing[*]}"
"${as_root[@]}" apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -q --no-install-recommends "${missing[@]}"
[ "$clean" = no ] || "${as_root[@]}" rm -rf /var/lib/apt/lists
