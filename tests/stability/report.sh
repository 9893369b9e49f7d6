#!/usr/bin/env bash
# Runs the stability suite of a build and prints what was measured as a document:
# `bash tests/stability/report.sh BUILD_DIR > docs/stability.md`. Fails if a test does; the tests'
# own output goes to stderr.
set -euo pipefail

said="$(mktemp)"
trap 'rm -f "$said"' EXIT
# One process, so that statements come in the order of the tests.
QRAY_STABILITY_REPORT="$said" "$1/bin/stability_tests" --gtest_brief=1 >&2

cat << 'EOF'
# Where methods fail

Each row is a failure mode with a scene or a table made to provoke it, what must hold there (a test
fails if it does not), and what each method does, measured. Made by
`bash tests/stability/report.sh BUILD_DIR > docs/stability.md`; checked by
`ctest --test-dir BUILD_DIR -L stability`. Pictures are small, seeds fixed, samples equal: the
figures are the same on every run.

*error x*: the method's relMSE over that of `none` at equal samples; below 1 it makes less noise.
*z*: how many standard errors its mean is from that of `none`.

| failure mode | what must hold | what each method does |
|---|---|---|
EOF
sort -s -n -k1,1 "$said" | awk -F'\t' '
  function flush_row(   i, cell) {
    if (title == "") return
    for (i = 1; i <= count; ++i)
      cell = cell (i > 1 ? "<br>" : "") (method[i] != "" ? "`" method[i] "`: " : "") says[i]
    print "| " title " | " must " | " cell " |"
  }
  $1 != order {
    flush_row()
    order = $1; title = $2; must = $3; count = 0
    delete place
  }
  {
    if (!($4 in place)) { place[$4] = ++count; method[count] = $4; says[count] = $5 }
    else says[place[$4]] = says[place[$4]] "; " $5
  }
  END { flush_row() }'
