#!/usr/bin/env bash
# `bash tests/stability/report.sh BUILD_DIR` runs the stability suite of a build and writes what was
# measured into the documents: the second half of each page docs/stability/<mode>.md, below its
# marker, and the table of docs/stability.md, which repeats the first sentence of the labelled
# paragraphs of the pages.
# Prose is edited in the pages. Fails if a test does, or if a failure mode has no page. If
# QRAY_STABILITY_REPORT names a file of statements (failure_mode.h), no test is run.
set -euo pipefail
shopt -s inherit_errexit

docs="$(cd "$(dirname "$0")/../.." && pwd)/docs"
marker='<!-- What follows is written by tests/stability/report.sh. -->'
scratch="$(mktemp -d)"
trap 'rm -rf "$scratch"' EXIT
statements="${QRAY_STABILITY_REPORT:-$scratch/statements}"
if [ -z "${QRAY_STABILITY_REPORT:-}" ]; then
  # One process, so that statements come in the order of the tests.
  QRAY_STABILITY_REPORT="$statements" "$1/bin/stability_tests" --gtest_brief=1 >&2
fi

# The first sentence of a page's paragraph that begins with **LABEL.**
sentence() {
  awk -v start="**$2.**" 'index($0, start) == 1 { on = 1; sub(/^\*\*[^*]*\*\* */, "") }
    on && /^$/ { exit }
    on { printf "%s%s", between, $0; between = " " }' "$1" | sed 's/\. .*/./'
}

# The smallest and largest error of METHOD over that of `none`, over the scenes of a failure mode.
errors() {
  awk -F'\t' -v mode="$1" -v method="$2" '
    $2 == mode && $6 == "error" && $7 == method && $9 ~ /^[0-9.]+ \(/ {
      e = $9 + 0
      if (!n++ || e < low) low = e
      if (e > high) high = e
    }
    END {
      if (n) printf low == high ? "%.2f" : "%.2f to %.2f", low, high
    }' "$statements"
}

must_hold() {
  awk -F'\t' -v mode="$1" '$2 == mode { print "**What must hold.** " $4 "\n"; exit }' \
    "$statements" | fold -s -w 100 | sed 's/ *$//'
}

# The statements about one failure mode as Markdown.
measured() {
  sort -s -n -k1,1 "$statements" | awk -F'\t' -v mode="$1" '
    function table(kind, heading,   m, s, line, rule) {
      if (!scenes[kind]) return
      line = "| " heading; rule = "|---"
      for (m = 1; m <= methods; ++m)
        if ((kind, m) in used) { line = line " | `" method[m] "`"; rule = rule "|--:" }
      print "\n" line " |\n" rule "|"
      for (s = 1; s <= scenes[kind]; ++s) {
        line = "| " (scene[kind, s] == "" ? "the scene" : scene[kind, s])
        for (m = 1; m <= methods; ++m)
          if ((kind, m) in used) line = line " | " figure[kind, s, m]
        print line " |"
      }
    }
    BEGIN { method[number["none"] = ++methods] = "none" }  # the first column
    $2 != mode { next }
    {
      place = $7 == "" ? 0 : number[$7]
      if ($7 != "" && !place) { method[place = number[$7] = ++methods] = $7 }
      if (!($5 in seen)) { seen[$5]; tests = tests (tests ? ", " : "") "[" $5 "](../../" $5 ")" }
    }
    $6 == "says" {
      if (!($9 in note)) { note[$9] = ++notes; text[notes] = $9 }
      if ($7 != "") said[note[$9]] = said[note[$9]] (said[note[$9]] ? ", " : "") "`" $7 "`"
      next
    }
    {
      if (!(($6, $8) in row)) { row[$6, $8] = ++scenes[$6]; scene[$6, scenes[$6]] = $8 }
      figure[$6, row[$6, $8], place] = $9
      used[$6, place]
    }
    END {
      print "**Tested by** " tests "."
      table("mean", "mean (z: standard errors from `none`; x: times as bright)")
      table("error", "error (relMSE of `none`; the others divided by it, and by medians)")
      if (notes) print ""
      for (n = 1; n <= notes; ++n) print "- " (said[n] ? said[n] ": " : "") text[n]
    }'
}

modes="$(sort -s -n -k1,1 "$statements" | cut -f2,3,5 | awk -F'\t' '!seen[$1]++')"
while IFS=$'\t' read -r mode title test; do
  page="$docs/stability/$mode.md"
  if ! [ -f "$page" ]; then
    echo "report.sh: $page is missing: write its title and its three paragraphs" >&2
    exit 1
  fi
  prose="$(sed "/^<!-- What follows/,\$d" "$page")"
  { printf '%s\n\n%s\n\n' "$prose" "$marker"; must_hold "$mode"; measured "$mode"; } \
    > "$scratch/page"
  mv "$scratch/page" "$page"
done <<< "$modes"

{
  sed '/^| failure mode/,$d' "$docs/stability.md"
  echo '| failure mode | what happens | methods | verdict | error of `adaptive` |' \
    'with its guide open | test |'
  echo '|---|---|---|---|---|---|---|'
  while IFS=$'\t' read -r mode title test; do
    page="$docs/stability/$mode.md"
    printf '| [%s](stability/%s.md) | %s | %s | %s | %s | %s | [%s](../%s) |\n' "$title" "$mode" \
      "$(sentence "$page" 'What happens')" "$(sentence "$page" Methods)" \
      "$(sentence "$page" Verdict)" "$(errors "$mode" adaptive)" \
      "$(errors "$mode" adaptive:gate=off)" "$(basename "$test" _test.cpp)" "$test"
  done <<< "$modes"
} > "$scratch/index"
mv "$scratch/index" "$docs/stability.md"
