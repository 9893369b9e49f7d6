#!/usr/bin/env bash
# Checks the house rules that a compiler does not: `lint.sh ROOT`. Prints each violation as
# file:line: rule, and exits 1 when there is one. The tables are includes.txt and walls.txt.
set -euo pipefail

rules="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
cd "$1"
export LC_ALL=C.UTF-8
found="$(mktemp)"
units="$(mktemp -d)"  # files for clang-tidy
trap 'rm -rf "$found" "$units"' EXIT

files() { # of the project, by extension
  local names=()
  for extension in "$@"; do names+=(-o -name "*.$extension"); done
  find . \( -path ./build -o -path './build-*' -o -name node_modules -o -path ./.git \
    -o -path ./data \) -prune -o -type f \( "${names[@]:1}" \) -print | sed 's|^\./||' | sort
}
mapfile -t headers < <(files h)
mapfile -t sources < <(files h cpp)
mapfile -t code < <(files h cpp js mjs css sh)
mapfile -t texts < <(files h cpp js mjs css sh html md json yaml yml txt cmake)

# `grep` over many files, which may find nothing.
each_match() { grep -HnE "$@" < /dev/null || true; }

check_includes() {
  each_match '^ *#include "' "${sources[@]}" | awk -v table="$rules/includes.txt" '
    BEGIN {
      while ((getline line < table) > 0) {
        if (line ~ /^#/ || split(line, part, ":") < 2) continue
        allowed[part[1]] = part[2]
      }
    }
    {
      split($0, place, ":"); file = place[1]
      split($0, quoted, "\""); header = quoted[2]
      owner = file
      while (!(owner in allowed)) if (!sub(/\/[^\/]*$/, "", owner)) break
      if (!(owner in allowed)) { print file ":" place[2] ": folder is not in includes.txt"; next }
      count = split(owner " " allowed[owner], list, " "); good = 0
      for (i = 1; i <= count; ++i)
        if (header == list[i] || index(header, list[i] "/") == 1) good = 1
      if (!good) print file ":" place[2] ": " owner " may not include " header
    }'
}

check_walls() {
  local pattern allowed place file glob good
  while IFS= read -r rule; do
    [[ "$rule" == *" : "* && "$rule" != "#"* ]] || continue
    pattern="${rule%% : *}" allowed="${rule#* : }"
    while IFS= read -r place; do
      [ -n "$place" ] || continue
      file="${place%%:*}" good=no
      set -f
      for glob in $allowed; do
        # shellcheck disable=SC2053  # a pattern is meant
        [[ "$file" == $glob ]] && good=yes
      done
      set +f
      [ $good = yes ] || echo "${place%%:#*}: wall: only $allowed may include this library"
    done < <(each_match "^ *#include [<\"]$pattern[>\"]" "${sources[@]}")
  done < "$rules/walls.txt"
}

check_headers() {
  local file
  for file in "${headers[@]}"; do
    [[ "$(head -n 1 "$file")" == "// "* ]] || echo "$file:1: a header starts with its purpose"
    grep -q '^#pragma once$' "$file" || echo "$file:1: no #pragma once"
  done
}

check_sizes() {
  each_match '^.{101,}' "${code[@]}" | sed -E 's/^([^:]*:[0-9]+):.*/\1: over 100 columns/'
  awk 'FNR == 501 { print FILENAME ":501: a file of over 500 lines" }' "${code[@]}"
}

check_words() {
  # Split so that this file does not find itself.
  local machine='(^|[^A-Za-z0-9_.~*])/(ho''me|ro''ot|wo''rk|Us''ers)/' later='TO''DO|FIX''ME|X''XX'
  each_match "$machine" "${texts[@]}" | sed -E 's/^([^:]*:[0-9]+):.*/\1: a path of one machine/'
  each_match "\\b($later)\\b" "${code[@]}" | sed -E 's/^([^:]*:[0-9]+):.*/\1: left for later/'
}

check_readmes() {
  local folder file
  for folder in core/* proto server web scenes docker tests tests/bench; do
    [ ! -d "$folder" ] || [ -f "$folder/README.md" ] || echo "$folder:1: no README.md"
  done
  for folder in scenes/*/; do
    [ ! -d "$folder" ] || [ -f "${folder}SOURCE.md" ] || echo "$folder:1: no SOURCE.md"
  done
  while IFS= read -r file; do
    [ "$(wc -l < "$file")" -le 60 ] || echo "$file:61: a README of over 60 lines"
  done < <(files md | grep '/README\.md$' || true)
}

check_format() {
  command -v clang-format > /dev/null || return 0
  clang-format --dry-run "${sources[@]}" 2>&1 | grep -E '^[^ ]+:[0-9]+:[0-9]+: ' |
    sed -E 's/^([^:]*:[0-9]+):.*/\1: not as clang-format writes it/' | sort -u || true
}

# Files are read many at once, since what they include costs more than they do. In the copies that
# are read, unnamed namespaces have names, so that two files may use the same one. A header that is
# not found would end the check early.
check_names() {
  command -v clang-tidy > /dev/null && [ -f .clang-tidy ] || return 0
  local file count=0 files_a_unit=140
  while IFS= read -r file; do
    if [[ "$file" == *.cpp ]]; then
      mkdir -p "$units/${file%/*}"
      sed "s/^namespace {/inline namespace file_$count {/" "$file" > "$units/$file"
    fi
    echo "#include \"$file\"" >> "$units/$((count++ / files_a_unit)).cpp"
  done < <(printf '%s\n' "${sources[@]}" | grep -E '^(core|proto|server)/')
  find "$units" -maxdepth 1 -name '*.cpp' -print0 | xargs -0 -r -n 1 -P "$(nproc)" sh -c '
    clang-tidy --quiet --config-file=.clang-tidy "$0" -- -std=c++20 -I"${0%/*}" -I. -w \
      -ferror-limit=0 > "$0.said" 2> /dev/null' || true
  find "$units" -maxdepth 1 -name '*.said' -exec cat {} + |
    sed -E "s#^($PWD/|$units/)?(\./)?##" |
    sed -nE \
      -e 's/^([^:]+:[0-9]+):.*: invalid case style for (.*) \[readability.*/\1: name of \2/p' \
      -e "s/^([^:]+:[0-9]+):.* error: ('.*' file not found).*/\1: names are not checked: \2/p" |
    sort -u
}

{
  check_includes
  check_walls
  check_headers
  check_sizes
  check_words
  check_readmes
  check_format
  check_names
} > "$found"
cat "$found"
[ ! -s "$found" ] || { echo "lint: $(wc -l < "$found") violations"; exit 1; }
echo "lint: ${#sources[@]} C++ files are good"
