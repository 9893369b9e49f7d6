#!/usr/bin/env python3
"""Recovered pictures of ours and of Open Image Denoise, from the same samples, against the truth.

    LD_LIBRARY_PATH=FOLDER compare_oidn.py QRAY WORK SCENE [SCENE ...]

FOLDER has libOpenImageDenoise.so.2: that of a release, or pyoidn/oidn/lib of PyPI's wheel of version 2.5.1, which
`pip download --no-deps pyoidn` fetches and `unzip` opens. QRAY is the command, SCENE an included name or a file. WORK keeps
references, which are rendered once, and pictures. Prints a row for each scene and count of samples
and, last, geometric means of ours over theirs.
"""

import argparse
import json
import math
import pathlib
import subprocess


def run(*command):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True).stdout


def name_of(scene):
    path = pathlib.Path(scene)
    return path.parent.name if path.suffix else path.name


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("qray")
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--size", default="512x512")
    parser.add_argument("--spp", default="1,4,16,64")
    parser.add_argument("--seed", default="17", help="of the samples")
    parser.add_argument("--reference-spp", default="640", help="of references, by 'adaptive'")
    parser.add_argument("--network", default="default", help="ours: a name or a file of weights")
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)

    def render(out, scene, *more):
        run(options.qray, "render", scene, "--size", options.size, "-q", "-o", out, *more)

    def difference(picture, truth):
        return json.loads(run(options.qray, "diff", "--json", picture, truth))

    ratios = {}
    print(f"{'scene':<16} {'spp':>4}  " + "  ".join(
        f"{who:>7}: {'mean':>6} {'trimmed':>8} {'FLIP':>5}" for who in ("samples", "ours", "oidn")))
    for scene in options.scenes:
        name = name_of(scene)
        truth = options.work / f"{name}-{options.size}-truth.exr"
        if not truth.exists():
            render(truth, scene, "--method", "adaptive", "--spp", options.reference_spp,
                   "--seed", "1000003")
        for spp in options.spp.split(","):
            found = {}
            for who, network in (("ours", options.network), ("oidn", "oidn")):
                picture = options.work / f"{name}-{spp}-{who}.exr"
                samples = options.work / f"{name}-{spp}-samples.exr"
                render(picture, scene, "--method", "none", "--spp", spp, "--seed", options.seed,
                       "--recover", network,
                       "--sampled-out", samples)
                found["samples"] = difference(samples, truth)
                found[who] = difference(picture, truth)
            print(f"{name:<16} {spp:>4}  " + "  ".join(
                f"{who:>7}: {d['mean_ratio']:6.3f} {d['relmse_trimmed']:8.4f} {d['flip']:5.3f}"
                for who, d in found.items()), flush=True)
            for measure in ("relmse_trimmed", "flip"):
                ratios.setdefault((spp, measure), []).append(
                    found["ours"][measure] / found["oidn"][measure])
    for (spp, measure), values in ratios.items():
        mean = math.exp(sum(map(math.log, values)) / len(values))
        print(f"ours over oidn, {spp:>3} spp, {measure:<14} {mean:5.2f}, at most {max(values):.2f}")


if __name__ == "__main__":
    main()
