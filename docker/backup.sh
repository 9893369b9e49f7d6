#!/usr/bin/env bash
# Copies a data folder while its server runs: `bash docker/backup.sh DATA DESTINATION`, a folder
# that is not there yet. The database first, as one consistent file: a record is written after the
# files that it names, so all of them are there to copy afterwards. Needs sqlite3. To restore, start
# a server on the copy, or on a copy of it.
set -euo pipefail

data="${1:?expected the data folder}"
to="${2:?expected the folder to make}"
fail() {
  echo "backup.sh: $*" >&2
  exit 1
}
[ -f "$data/qray.sqlite" ] || fail "$data has no qray.sqlite: expected a data folder"
[ ! -e "$to" ] || fail "$to is there already"
[[ "$to" != *\'* ]] || fail "expected a name without quotes"

umask 077
draft="$to.draft"
rm -rf "$draft"
mkdir -p "$draft"
sqlite3 -bail "$data/qray.sqlite" ".timeout 10000" "VACUUM INTO '$draft/qray.sqlite'" ||
  fail "the database cannot be copied"
[ "$(sqlite3 "$draft/qray.sqlite" 'PRAGMA integrity_check')" = ok ] ||
  fail "the copied database is damaged"
# Left out: the database itself, and what is half written. Code 1: a file went meanwhile.
code=0
tar -C "$data" --exclude='./qray.sqlite*' --exclude=./lock --exclude='*.tmp.*' \
  --exclude='*.part' --exclude='*.draft' -cf - . | tar -C "$draft" -xf - || code=$?
[ "$code" -le 1 ] || fail "the files cannot be copied"
sync -f "$draft"
mv "$draft" "$to"
echo "backup.sh: $(sqlite3 "$to/qray.sqlite" 'SELECT count(*) FROM jobs') jobs in $to"
