#!/usr/bin/env bash
# `bash tests/stability/report.sh BUILD_DIR` runs the stability suite of a build and writes what was
# measured into the documents: the second half of each page docs/stability/<mode>.md, below its
# marker, and the table of docs/stability.md, which repeats the labelled paragraphs of the pages.
# Prose is edited in the pages. Fails if a test does, or if a failure mode has no page.
set -euo pipefail
shopt -s inherit_errexit

docs="$(cd "$(dirname "$0")/../.." && pwd)/docs"
marker='<!-- What follows is written by tests/stability/report.sh. -->'
said="$(mktemp)"
trap 'rm -f "$said"' EXIT
# One process, so that statements come in the order of the tests.
QRAY_STABILITY_REPORT="${QRAY_STABILITY_REPORT:-$said}"
export QRAY_STABILITY_REPORT
if [ "$QRAY_STABILITY_REPORT" = "$said" ]; then "$1/bin/stability_tests" --gtest_brief=1 >&2; fi

# The paragraph of a page that begins with **LABEL.**, on one line.
paragraph() {
  awk -v start="**$2.**" 'index($0, start) == 1 { on = 1; sub(/^\*\*[^*]*\*\* */, "") }
    on && /^$/ { exit }
    on { printf "%s%s", between, $0; between = " " }' "$1"
}

# The statements about one failure mode as Markdown.
measured() {
  sort -s -n -k1,1 "$QRAY_STABILITY_REPORT" | awk -F'\t' -v mode="$1" '
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
    $2 != mode { next }
    {
      must = $4; place = $7 == "" ? 0 : number[$7]
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
      print "**What must hold.** " must "\n\n**Tested by** " tests "."
      table("mean", "mean: its value; distance in standard errors (z); or times as bright")
      table("error", "error: relMSE; over that of `none` (and the median of it)")
      if (notes) print ""
      for (n = 1; n <= notes; ++n) print "- " (said[n] ? said[n] ": " : "") text[n]
    }'
}

modes="$(sort -s -n -k1,1 "$QRAY_STABILITY_REPORT" | cut -f2,3,5 | awk -F'\t' '!seen[$1]++')"
while IFS=$'\t' read -r mode title test; do
  page="$docs/stability/$mode.md"
  if ! [ -f "$page" ]; then
    echo "report.sh: $page is missing: write its title and its three paragraphs" >&2
    exit 1
  fi
  prose="$(sed "/^<!-- What follows/,\$d" "$page")"
  { printf '%s\n\n%s\n\n' "$prose" "$marker"; measured "$mode"; } > "$said.page"
  mv "$said.page" "$page"
done <<< "$modes"

{
  sed '/^| failure mode/,$d' "$docs/stability.md"
  echo '| failure mode | what happens | methods | verdict | test |'
  echo '|---|---|---|---|---|'
  while IFS=$'\t' read -r mode title test; do
    page="$docs/stability/$mode.md"
    printf '| [%s](stability/%s.md) | %s | %s | %s | [%s](../%s) |\n' "$title" "$mode" \
      "$(paragraph "$page" 'What happens')" "$(paragraph "$page" Methods)" \
      "$(paragraph "$page" Verdict)" "$(basename "$test" _test.cpp)" "$test"
  done <<< "$modes"
} > "$said.index"
mv "$said.index" "$docs/stability.md"
