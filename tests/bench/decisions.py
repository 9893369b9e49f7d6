#!/usr/bin/env python3
"""How often `adaptive` decides wrongly whether its guide pays.

python3 tests/bench/decisions.py BIN SCENE ... [--sizes 64x48,192x144] [--spp 8,16,32] [--seeds 10] [--truth-seeds 6]

BIN: the folder of `qray`. SCENE: names of included scenes, or files. For every size and number of samples, what is right
is measured first: error x rays of `none` over the same of `adaptive` with its gate open, geometric means over
--truth-seeds seeds, relMSE without the worst .1 % of pixels. The reference is of `adaptive`, with its
gate open, a seed of its own and --reference times the samples. Then `adaptive` decides, once a seed. Wrong is a guide that was left though it
wins 1.2 or more, and one that was kept though it loses 1.05 or more.
"""
import argparse
import json
import math
import pathlib
import statistics
import subprocess
import tempfile


class Bench:
    def __init__(self, options, scratch):
        self.options, self.scratch, self.qray = options, scratch, options.bin / "qray"

    def render(self, scene, method, size, samples, seed, name="p"):
        picture, stats = self.scratch / f"{name}.exr", self.scratch / "p.json"
        subprocess.run(
            [self.qray, "render", scene, "--method", method, "--spp", str(samples), "--size", size, "--seed", str(seed),
             "--json", stats, "-q", "-o", picture], check=True, stderr=subprocess.DEVNULL)
        return picture, json.loads(stats.read_text())

    def error_times_rays(self, scene, method, size, samples, seed, reference):
        picture, stats = self.render(scene, method, size, samples, seed)
        said = subprocess.run([self.qray, "diff", picture, reference, "--json"], text=True, capture_output=True).stdout
        return json.loads(said)["relmse_trimmed"] * stats["rays"]

    def gain(self, scene, size, samples, reference):
        ratios = [
            math.log(self.error_times_rays(scene, "none", size, samples, seed, reference) /
                     self.error_times_rays(scene, "adaptive:gate=off", size, samples, seed, reference))
            for seed in range(1001, 1001 + self.options.truth_seeds)]
        return math.exp(statistics.mean(ratios))

    def keeps(self, scene, size, samples, seed):
        stats = self.render(scene, "adaptive", size, samples, seed)[1]
        return stats["parts"]["guide"] == "on" and any(
            part["guided"] and part["share"] == 1 for part in stats["guide_passes"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--sizes", default="64x48,192x144")
    parser.add_argument("--spp", default="8,16,32")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--truth-seeds", type=int, default=6)
    parser.add_argument("--reference", type=int, default=16)
    options = parser.parse_args()
    decisions = wrong = 0
    print(f"{'scene':<14}{'size':>9}{'samples':>9}{'gain':>7}{'kept':>9}{'wrong':>7}")
    with tempfile.TemporaryDirectory() as scratch:
        bench = Bench(options, pathlib.Path(scratch))
        for scene in options.scenes:
            for size in options.sizes.split(","):
                counts = [int(word) for word in options.spp.split(",")]
                reference = bench.render(
                    scene, "adaptive:gate=off", size, options.reference * max(counts), 991, "reference")[0]
                for samples in counts:
                    gain = bench.gain(scene, size, samples, reference)
                    kept = sum(bench.keeps(scene, size, samples, seed) for seed in range(1, options.seeds + 1))
                    here = options.seeds - kept if gain >= 1.2 else kept if gain <= 1 / 1.05 else 0
                    decisions, wrong = decisions + options.seeds, wrong + here
                    print(f"{pathlib.Path(scene).stem:<14}{size:>9}{samples:>9}{gain:>7.2f}{kept:>5}/{options.seeds:<3}"
                          f"{here:>7}", flush=True)
    print(f"wrong: {wrong} of {decisions} ({100 * wrong / decisions:.1f} %)")


if __name__ == "__main__":
    main()
