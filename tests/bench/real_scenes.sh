#!/usr/bin/env bash
# Renders real scenes against their reference pictures for docs/scenes.md:
#   SECONDS_EACH=600 bash tests/bench/real_scenes.sh BUILD_DIR TESTDATA_DIR OUT_DIR
# Prints a table of means and FLIP, and leaves in OUT_DIR a pair of pictures for each, ours above
# the reference, and one picture of each scene that has none. METHOD (adaptive) is from the
# environment.
set -euo pipefail
build=${1:?usage: real_scenes.sh BUILD_DIR TESTDATA_DIR OUT_DIR} data=${2:?} out=${3:?}
seconds=${SECONDS_EACH:-600} method=${METHOD:-adaptive}
qray="$build/bin/qray"
mkdir -p "$out"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

with_reference=(cornell-box/scene_v3.xml veach-ajar/scene_v3.xml veach-mis/scene_v3.xml
  living-room/scene_v0.5.xml staircase2/scene_v0.5.xml)
without=(cbox-bulb/scene_v0.6.xml many-lights-a/scene_v0.6.xml many-lights-a/many-lights-a.glb
  xf-cornell-box/cornell-box.glb xf-veach-ajar/veach-ajar.glb xf-staircase2/staircase2.glb
  gltf-bathroom/LAZIENKA.glb gltf-cornell-bevy/CornellBox.glb
  obj-cornell-dev/CornellBox-Original.obj)

echo "| scene | mean, ours over the reference | FLIP | samples a pixel | seconds |"
echo "|---|--:|--:|--:|--:|"
for scene in "${with_reference[@]}"; do
  [ -f "$data/$scene" ] || { echo "| $scene | not there | | | |"; continue; }
  name=${scene%%/*} reference="$data/${scene%%/*}/reference/TungstenRender.exr"
  file="$data/$scene"
  if [ "$name" = staircase2 ]; then  # its file is of a wide picture, its reference of a square one
    cp -r "$data/$name" "$scratch/"
    file="$scratch/$scene"
    sed -i '/"width"/s/1280/1024/; /"height"/s/720/1024/' "$file"
  fi
  "$qray" render "$file" --method "$method" --seconds "$seconds" -q -o "$out/$name.exr" \
    --json "$out/$name.json" 2> "$out/$name.log"
  "$qray" diff "$out/$name.exr" "$reference" --json > "$out/$name-diff.json"
  node -e 'const [name, ...files] = process.argv.slice(1);
    const [diff, run] = files.map((f) => JSON.parse(require("fs").readFileSync(f)));
    console.log(`| ${name} | ${diff.mean_ratio.toFixed(4)} | ${diff.flip.toFixed(4)} ` +
      `| ${run.samples} | ${Math.round(run.seconds)} |`);' \
    "$name" "$out/$name-diff.json" "$out/$name.json"
  oiiotool "$out/$name.exr" --resize 480x0 --tocolorspace sRGB -o "$out/ours.png" \
    "$reference" --resize 480x0 --tocolorspace sRGB -o "$out/theirs.png" 2> /dev/null
  oiiotool "$out/ours.png" "$out/theirs.png" --mosaic 1x2 -o "$out/$name.jpg"
  rm "$out/ours.png" "$out/theirs.png"
done
for scene in "${without[@]}"; do
  [ -f "$data/$scene" ] || { echo "| $scene | not there | | | |"; continue; }
  name=$(tr / - <<< "${scene%.*}")
  "$qray" render "$data/$scene" --method "$method" --seconds "$((seconds / 10 + 1))" -q \
    -o "$out/$name.png" 2> "$out/$name.log"
  oiiotool "$out/$name.png" --resize 320x0 -o "$out/$name.jpg"
done
