#!/usr/bin/env python3
"""Two builds of qray at equal wall time: tests/bench/builds.py OLD/bin/qray NEW/bin/qray SCENE...

Renders each scene with both builds in turn, seed by seed, and prints the medians of their errors
against a reference that the second build makes with another seed. The ratio is OLD over NEW: above
1, NEW has less error in the same time.
"""
import argparse
import pathlib
import statistics
import subprocess
import tempfile

KEYS = ("relmse", "relmse_trimmed", "mean_ratio")


def render(qray, scene, out, size, method, seed, budget):
    command = [qray, "render", scene, "--size", size, "--method", method, "--seed", str(seed),
               "-q", "-o", str(out), *budget]
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)


def errors(qray, reference, picture):
    told = subprocess.run([qray, "diff", str(reference), str(picture)], capture_output=True,
                          text=True).stdout
    lines = [line.split() for line in told.splitlines()]
    return {line[0]: float(line[1]) for line in lines if line and line[0] in KEYS}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--seconds", type=float, default=4)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--size", default="256x256")
    parser.add_argument("--method", default="none")
    parser.add_argument("--ref-seconds", type=float, default=60)
    args = parser.parse_args()
    print("scene | old relMSE, trimmed | new relMSE, trimmed | old / new, trimmed | new mean")
    with tempfile.TemporaryDirectory() as folder:
        reference, picture = (pathlib.Path(folder) / name for name in ("ref.exr", "p.exr"))
        for scene in args.scenes:
            render(args.new, scene, reference, args.size, args.method, 9001,
                   ["--seconds", str(args.ref_seconds)])
            found = {args.old: [], args.new: []}
            for seed in range(1, args.seeds + 1):
                for build, of in found.items():
                    render(build, scene, picture, args.size, args.method, seed,
                           ["--seconds", str(args.seconds)])
                    of.append(errors(args.new, reference, picture))
            old, new = ({key: statistics.median(e[key] for e in of) for key in KEYS}
                        for of in found.values())
            print(f"{scene} | {old['relmse']:.4g}, {old['relmse_trimmed']:.4g} | "
                  f"{new['relmse']:.4g}, {new['relmse_trimmed']:.4g} | "
                  f"{old['relmse'] / new['relmse']:.2f}, "
                  f"{old['relmse_trimmed'] / new['relmse_trimmed']:.2f} | "
                  f"{new['mean_ratio']:.4f}", flush=True)


if __name__ == "__main__":
    main()
