#!/usr/bin/env python3
"""Error per ray of `adaptive` with its gate open over `none`, on materials that are written otherwise.

python3 tests/bench/per_ray.py BIN [SCENE ...] [--size 192x144] [--spp 96] [--seeds 4]

BIN: the folder of `qray`. SCENE: included scenes, ajar-door if none is named. Each is rendered as it is, with all
its diffuse materials as `principled` of roughness .8, and as `plastic` of roughness .6. The reference is a render of
`adaptive` with another seed and 16 times the samples. Prints 1 / (relMSE x rays) over that of `none`, for relMSE and
for relMSE without the worst .1 % of pixels, and the same with seconds in place of rays.
"""
import argparse
import json
import pathlib
import re
import shutil
import statistics
import subprocess
import tempfile

SCENES = pathlib.Path(__file__).parents[2] / "scenes"
VARIANTS = {"as it is": None, "principled": ("principled", 0.8), "plastic": ("plastic", 0.6)}


def write_variant(name, change, folder):
    shutil.copytree(SCENES / name, folder)
    scene = json.loads((folder / "scene.json").read_text())
    for material in scene["materials"]:
        if change and material["type"] == "diffuse" and "emission" not in material:
            material["type"], material["roughness"] = change
    (folder / "scene.json").write_text(json.dumps(scene))


class Bench:
    def __init__(self, options, scratch):
        self.options, self.scratch, self.qray = options, scratch, options.bin / "qray"

    def render(self, folder, method, seed, samples):
        picture, stats = self.scratch / "p.exr", self.scratch / "p.json"
        subprocess.run(
            [self.qray, "render", folder / "scene.json", "--method", method, "--spp", str(samples), "--size",
             self.options.size, "--seed", str(seed), "--json", stats, "-q", "-o", picture],
            check=True, stderr=subprocess.DEVNULL)
        return picture, json.loads(stats.read_text())

    def measure(self, folder, method, reference):
        rows = []
        for seed in range(1, self.options.seeds + 1):
            picture, stats = self.render(folder, method, seed, self.options.spp)
            said = subprocess.run([self.qray, "diff", picture, reference], text=True, capture_output=True).stdout
            error, trimmed = (float(re.search(rf"^{key}\s+(\S+)", said, re.M)[1])
                              for key in ("relmse", "relmse_trimmed"))
            rows.append((error, trimmed, stats["rays"], stats["seconds"]))
        return [statistics.mean(column) for column in zip(*rows)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", default=["ajar-door"])
    parser.add_argument("--size", default="192x144")
    parser.add_argument("--spp", type=int, default=96)
    parser.add_argument("--seeds", type=int, default=4)
    options = parser.parse_args()
    print(f"{'scene':<14}{'materials':<12}{'per ray':>9}{'trimmed':>9}{'per s':>9}{'trimmed':>9}")
    with tempfile.TemporaryDirectory() as scratch:
        bench = Bench(options, pathlib.Path(scratch))
        for name in options.scenes:
            for variant, change in VARIANTS.items():
                folder = bench.scratch / f"{name}-{variant}"
                write_variant(name, change, folder)
                reference = folder / "reference.exr"
                shutil.move(bench.render(folder, "adaptive:gate=off", 991, 16 * options.spp)[0], reference)
                plain = bench.measure(folder, "none", reference)
                guided = bench.measure(folder, "adaptive:gate=off", reference)
                gains = [plain[e] * plain[c] / (guided[e] * guided[c]) for c in (2, 3) for e in (0, 1)]
                print(f"{name:<14}{variant:<12}" + "".join(f"{gain:>9.2f}" for gain in gains), flush=True)


if __name__ == "__main__":
    main()
