#!/usr/bin/env bash
# Makes docs/measurements/complexity.md: what each part of the renderer is worth on each scene, and
# the error against the table's size. Takes about 20 minutes; nothing else should run meanwhile.
#   bash tests/bench/complexity.sh BUILD_DIR [DIR] > docs/measurements/complexity.md
# DIR keeps the results (default: a scratch folder, gone afterwards).
set -euo pipefail
build=${1:?usage: complexity.sh BUILD_DIR [DIR]}
if [ $# -gt 1 ]; then dir=$2; else dir=$(mktemp -d); trap 'rm -rf "$dir"' EXIT; fi
scenes="cornell-box ajar-door lamp-room thesis-room furnace many-lights glass-caustic"
methods="none,none:nee=off,none:roulette=off,none:light-table=off"
methods+=",huang:grid=6,huang:grid=24,dahm-keller,ppg"
methods+=",adaptive:split=1000,adaptive:split=4000,adaptive:split=16000,adaptive:levels=3"
flags=(--methods "$methods" --size 256x256 --seconds 3 --seeds 3 --ref-seconds 60
  --ref-method adaptive
  ${REF_CACHE:+--ref-cache "$REF_CACHE"})  # REF_CACHE: references that a chart has left

# shellcheck disable=SC2086
"$build/bin/qray" chart $scenes "${flags[@]}" -o "$dir" 1>&2
for scene in $scenes; do
  "$build/bin/qray" render "$scene" --method adaptive --spp 64 --size 128x128 -q \
    -o "$dir/parts.exr" --json "$dir/$scene-parts.json"
done

cat <<EOF
# Measurements: how much model a scene needs

Made by \`bash tests/bench/complexity.sh BUILD_DIR\`, which runs

    qray chart $scenes \\
      --methods $methods \\
      --size 256x256 --seconds 3 --seeds 3 --ref-seconds 60 --ref-method adaptive -o DIR

What follows from it is in [../complexity.md](../complexity.md). Each part of the renderer is
measured on and off: next event estimation (\`nee\`), Russian roulette (\`roulette\`), and
picking lights by a tree (\`light-table\`). Tables are measured from coarse to fine: the thesis'
(\`grid\`: cells along the scene's longest side; a state has 26 directions) and those of
\`adaptive\` (\`split\`: a place that more samples of a pass hit is cut in two, 4000 by default;
\`levels\`: how often the square of directions may be cut in four, 6 by default).

Efficiency is over that of \`none\` with all parts on;
[../charts/README.md](../charts/README.md) explains the words. With three seeds of three
seconds, differences of a tenth are noise.

A part that cannot matter, or does not pay, is off by itself, and \`stats.json\` says so under
\`parts\`. Here of jobs of \`adaptive\` with 64 samples a pixel at 128 x 128 pixels:

| scene | $(node -e '
const p = JSON.parse(require("fs").readFileSync(process.argv[1])).parts;
console.log(Object.keys(p).join(" | ") + " |\n|---|" + "---|".repeat(Object.keys(p).length));
' "$dir/cornell-box-parts.json")
EOF
for scene in $scenes; do
  node -e '
const p = JSON.parse(require("fs").readFileSync(process.argv[1])).parts;
console.log("| " + process.argv[2] + " | " + Object.values(p).join(" | ") + " |");
' "$dir/$scene-parts.json" "$scene"
done
echo
cat "$dir/table.md"
