#!/usr/bin/env bash
# What `adaptive` gains and costs where there is little to gain, and on many triangles: efficiency
# (docs/charts/README.md) and rays per second over those of `none`. Takes about 15 minutes; nothing
# else should run meanwhile.
#   bash tests/bench/guide_cost.sh BUILD_DIR [DIR]
# DIR keeps the chart (default: a scratch folder, gone afterwards).
set -euo pipefail
build=${1:?usage: guide_cost.sh BUILD_DIR [DIR]}
if [ $# -gt 1 ]; then dir=$2; else dir=$(mktemp -d); trap 'rm -rf "$dir"' EXIT; fi
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
scenes=(cornell-box furnace "$here"/scenes/{sky,mirrors,fine-ball}.json)

"$build/bin/qray" chart "${scenes[@]}" --methods none,adaptive --size 256x256 --seconds 10 \
  --seeds 5 --ref-seconds 60 --ref-method adaptive -o "$dir" 1>&2
node -e '
const fs = require("fs"), dir = process.argv[1];
const lines = fs.readFileSync(dir + "/results.jsonl", "utf8").trim().split("\n");
const rows = lines.map((line) => JSON.parse(line));
const median = (a) => a.sort((x, y) => x - y)[a.length >> 1];
console.log("| scene | efficiency | the same, trimmed | rays/s | table |\n|---|---|---|---|---|");
for (const scene of JSON.parse(fs.readFileSync(dir + "/summary.json")).scenes) {
  const m = scene.methods.find((m) => m.method === "adaptive");
  const last = (method) => rows.filter((r) => r.line === "picture" && r.last &&
    r.scene === scene.scene && r.method === method);
  const rate = (method) => median(last(method).map((r) => r.rays / r.seconds));
  const says = (e) => `${e.value.toFixed(2)} (${e.low.toFixed(2)} to ${e.high.toFixed(2)})`;
  console.log(`| ${scene.scene.replace(/.*\/|\.json/g, "")} | ${says(m.efficiency)} | ` +
    `${says(m.efficiency_trimmed)} | ${(rate("adaptive") / rate("none")).toFixed(2)} | ` +
    `${(median(last("adaptive").map((r) => r.table_bytes)) / 2 ** 20).toFixed(2)} MiB |`);
}' "$dir"
