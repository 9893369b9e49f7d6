#!/usr/bin/env bash
# The table of docs/scenes.md: which scene files of a folder of folders load, with how many
# warnings, and the mean of qray's picture over the published one where a folder has one.
#   SPP=16 bash tests/bench/folders.sh BUILD_DIR TESTDATA_DIR [FOLDER...]
# Without folders, all. A published picture is reference/TungstenRender.exr; of a copy of the file
# whose film has the picture's size. METHOD (none) is from the environment.
set -euo pipefail
build=${1:?usage: folders.sh BUILD_DIR TESTDATA_DIR [FOLDER...]} data=${2:?}
shift 2
qray="$build/bin/qray"
[ $# -gt 0 ] || mapfile -t folders < <(cd "$data" && ls -d */)
[ $# -eq 0 ] || folders=("$@")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# Prints "RATIO | FLIP" of a Mitsuba file and the picture beside it.
against_published() { # FILE PICTURE
  local width height copy="$scratch/copy"
  read -r width height < <(oiiotool --info "$2" |
    sed -n 's/.*: *\([0-9]*\) x *\([0-9]*\),.*/\1 \2/p')
  rm -rf "$copy"
  cp -r "$(dirname "$1")" "$copy"
  sed -i "/name=\"width\"/s/value=\"[0-9]*\"/value=\"$width\"/
    /name=\"height\"/s/value=\"[0-9]*\"/value=\"$height\"/" "$copy/$(basename "$1")"
  "$qray" render "$copy/$(basename "$1")" --method "${METHOD:-none}" --spp "${SPP:-16}" -q \
    -o "$scratch/ours.exr" 2> /dev/null
  "$qray" diff "$scratch/ours.exr" "$2" --json | node -e '
    const { mean_ratio, flip } = JSON.parse(require("fs").readFileSync(0));
    console.log(`${mean_ratio.toFixed(4)} | ${flip.toFixed(3)}`);'
}

echo "| file | loads | triangles | warnings | mean over the published picture | FLIP |"
echo "|---|---|--:|--:|--:|--:|"
for folder in "${folders[@]}"; do
  folder=${folder%/}
  files=0
  while IFS= read -r file; do
    case "$file" in */include_*) continue ;; esac  # a part of another file
    files=$((files + 1))
    if ! "$qray" scene check "$data/$file" > "$scratch/check" 2> "$scratch/error"; then
      echo "| $file | no: $(head -n 1 "$scratch/error") | | | | |"
      continue
    fi
    triangles=$(awk '/^instances/ {n = $3} /^meshes/ && !n {n = $3} END {print n}' "$scratch/check")
    warnings=$(grep -c '^warning' "$scratch/check" || true)
    published="$data/$folder/reference/TungstenRender.exr" figures="- | -"
    [ ! -f "$published" ] || figures=$(against_published "$data/$file" "$published")
    echo "| $file | yes | $triangles | $warnings | $figures |"
  done < <(cd "$data" && find "$folder" \( -path '*/models' -o -path '*/meshes' \) -prune -o \
    \( -name '*.xml' -o -name '*.gltf' -o -name '*.glb' -o -name '*.obj' \) -print | sort)
  [ $files -gt 0 ] || echo "| $folder | no scene file | | | | |"
done
