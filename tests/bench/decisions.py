#!/usr/bin/env python3
"""How often `adaptive` decides wrongly whether its guide pays.

python3 tests/bench/decisions.py BIN SCENE ... [--sizes 64x48,192x144] [--spp 8,16,32] [--seeds 10] [--truth-seeds 6]

BIN: the folder of `qray`. SCENE: names of included scenes, or files. For every size and number of samples, error x
cost of `adaptive` with its gate open is measured first, and the same of `none` ("gain": over the open gate's), geometric means
over --truth-seeds seeds, relMSE without the worst .1 % of pixels. Cost is counted in rays; one of a guided path counts GUIDED,
with its share of the guide's work. The reference is of `adaptive`, with its gate open, a seed of its own and --reference times
the samples. Then `adaptive` decides, once a seed. Wrong is a guide that was left though the open gate has 1.2 times less
error x cost than that run, and one that was kept though it loses 1.05 or more to `none`.
"""
import argparse
import json
import math
import pathlib
import statistics
import subprocess
import tempfile

GUIDED = 1.3  # by time 1.17 (living-room) to 1.6 (ajar-door); cornell-box: 1.36


class Bench:
    def __init__(self, options, scratch):
        self.options, self.scratch, self.qray = options, scratch, options.bin / "qray"

    def render(self, scene, method, size, samples, seed, name="p"):
        picture, stats = self.scratch / f"{name}.exr", self.scratch / "p.json"
        subprocess.run(
            [self.qray, "render", scene, "--method", method, "--spp", str(samples), "--size", size, "--seed", str(seed),
             "--json", stats, "-q", "-o", picture], check=True, stderr=subprocess.DEVNULL)
        return picture, json.loads(stats.read_text())

    def run(self, scene, method, size, samples, seed, reference):
        """Error x cost, and whether the guide was kept."""
        picture, stats = self.render(scene, method, size, samples, seed)
        said = subprocess.run([self.qray, "diff", picture, reference, "--json"], text=True, capture_output=True).stdout
        kept = stats["parts"]["guide"] == "on" and any(
            part["guided"] and part["share"] == 1 for part in stats["guide_passes"])
        return json.loads(said)["relmse_trimmed"] * stats["rays"] * (GUIDED if kept else 1), kept

    def mean(self, *what):
        runs = [self.run(*what[:4], seed, what[4]) for seed in range(1001, 1001 + self.options.truth_seeds)]
        return math.exp(statistics.mean(math.log(run[0]) for run in runs))


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
                    plain, opened = (bench.mean(scene, method, size, samples, reference)
                                     for method in ("none", "adaptive:gate=off"))
                    runs = [bench.run(scene, "adaptive", size, samples, seed, reference)
                            for seed in range(1, options.seeds + 1)]
                    kept, gain = sum(keeps for _, keeps in runs), plain / opened
                    here = sum(gain <= 1 / 1.05 if keeps else error >= 1.2 * opened for error, keeps in runs)
                    decisions, wrong = decisions + options.seeds, wrong + here
                    print(f"{pathlib.Path(scene).stem:<14}{size:>9}{samples:>9}{gain:>7.2f}{kept:>5}/{options.seeds:<3}"
                          f"{here:>7}", flush=True)
    print(f"wrong: {wrong} of {decisions} ({100 * wrong / decisions:.1f} %)")


if __name__ == "__main__":
    main()
