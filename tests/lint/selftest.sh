#!/usr/bin/env bash
# Plants one violation after the other in a small scratch tree: lint.sh must name each of them, and
# nothing in the good tree.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
tree="$(mktemp -d)"
trap 'rm -rf "$tree"' EXIT
failures=0

write_good_tree() {
  rm -rf "${tree:?}"/* "$tree/.clang-tidy"
  mkdir -p "$tree/core/math" "$tree/core/accel" "$tree/proto"
  for folder in core/math core/accel proto; do echo "# $folder" > "$tree/$folder/README.md"; done
  printf '// A good header.\n#pragma once\n\n#include "core/base/check.h"\n' \
    > "$tree/core/math/good.h"
  printf '#include "core/math/good.h"\n\n#include <embree3/rtcore.h>\n' \
    > "$tree/core/accel/good.cpp"
  printf '#include <nlohmann/json.hpp>\n\n#include "core/base/check.h"\n' > "$tree/proto/good.cpp"
}

expect() { # NAME TEXT...: lint.sh must complain with each TEXT
  local said refused=yes
  if said="$(bash "$here/lint.sh" "$tree")"; then refused=no; fi
  while [ $# -gt 1 ]; do
    if [[ $refused = no || "$said" != *"$2"* ]]; then
      echo "selftest: '$1' was not found; lint.sh said: $said"
      failures=$((failures + 1))
    fi
    shift 2
  done
  write_good_tree
}

write_good_tree
bash "$here/lint.sh" "$tree" || { echo "selftest: the good tree was refused"; exit 1; }

echo '#include "core/scene/scene.h"' > "$tree/core/math/bad.cpp"
expect "a forbidden include" "core/math may not include core/scene/scene.h"
echo '#include "core/render/path.h"' > "$tree/proto/bad.cpp"
expect "a folder above" "proto may not include core/render/path.h"
echo '#include <embree3/rtcore.h>' > "$tree/core/math/bad.cpp"
expect "a wall" "core/math/bad.cpp:1: wall"
printf '// Purpose.\n#pragma once\n#include <nlohmann/json.hpp>\n' > "$tree/proto/bad.h"
expect "a wall for headers" "proto/bad.h:3: wall"
printf '// Purpose.\nint f();\n' > "$tree/core/math/bad.h"
expect "no pragma once" "core/math/bad.h:1: no #pragma once"
printf '#pragma once\nint f();\n' > "$tree/core/math/bad.h"
expect "no purpose" "core/math/bad.h:1: a header starts with its purpose"
printf '// %0100d\n' 0 > "$tree/core/math/bad.cpp"
expect "a long line" "core/math/bad.cpp:1: over 100 columns"
printf '//\n%.0s' {1..501} > "$tree/core/math/bad.cpp"
expect "a long file" "core/math/bad.cpp:501: a file of over 500 lines"
printf 'see /ho''me/someone/notes\n' > "$tree/core/math/README.md"
expect "a machine's path" "core/math/README.md:1: a path of one machine"
printf '// TO''DO: more\n' > "$tree/core/math/bad.cpp"
expect "something left for later" "core/math/bad.cpp:1: left for later"
rm "$tree/core/math/README.md"
expect "no README" "core/math:1: no README.md"
printf 'line\n%.0s' {1..61} > "$tree/core/math/README.md"
expect "a long README" "core/math/README.md:61: a README of over 60 lines"
if command -v clang-format > /dev/null; then
  cp "$here/../../.clang-format" "$tree/.clang-format"
  printf 'int  f( );\n' > "$tree/core/math/bad.cpp"
  expect "bad format" "core/math/bad.cpp:1: not as clang-format writes it"
fi
if command -v clang-tidy > /dev/null; then
  # In one tree: reading the headers of a library takes a second each time.
  cp "$here/../../.clang-tidy" "$tree/.clang-tidy"
  printf '%s\n' '#include "core/math/bad.h"' 'int BadFunction() { return 0; }' \
    'constexpr int wrong = 1;' 'namespace { struct Twice { int BadMember; }; }' \
    > "$tree/core/math/bad.cpp"
  printf 'namespace {\nstruct Twice {};\n}\n' > "$tree/core/math/another.cpp"
  printf '// Purpose.\n#pragma once\nstruct bad_type {};\nclass Good { int member; };\n' \
    > "$tree/core/math/bad.h"
  expect \
    "a type's name" "core/math/bad.h:3: name of struct 'bad_type'" \
    "a private member's name" "core/math/bad.h:4: name of private member 'member'" \
    "a function's name" "core/math/bad.cpp:2: name of function 'BadFunction'" \
    "a constant's name" "core/math/bad.cpp:3: name of constexpr variable 'wrong'" \
    "a name in a struct that two files have" "core/math/bad.cpp:4: name of member 'BadMember'" \
    "a header that is not there" "core/math/good.h:4: names are not checked"
fi

[ "$failures" -eq 0 ] || exit 1
echo "selftest: lint.sh finds every planted violation"
