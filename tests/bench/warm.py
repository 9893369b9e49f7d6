#!/usr/bin/env python3
"""What a table is worth to short jobs, and that it costs nothing where it is worth nothing.

python3 tests/bench/warm.py BIN WORK SCENE ... [--seconds .25,.5,1,2] [--seeds 5] [--size 256x256]
python3 tests/bench/warm.py BIN WORK SCENE ... --views 12 --seconds 2

BIN: the folder of `qray`. WORK: a folder that keeps references and tables between calls. SCENE: names of included
scenes, or files. The table is of a job of --teacher-seconds whose camera is turned by 20 degrees. `none`, a job
without a table ("cold") and one with it ("warm") take turns, seed by seed. Prints relMSE (trimmed: without the worst
.1 % of pixels), medians, and the error of `none` over that of the others, geometric means over the seeds.

--views N: the camera turns round where it stands, in N steps, and each view is a job of its own. Cold jobs take turns
with jobs of which each starts from the table that the one before has left. Prints the total error of both.
"""
import argparse
import json
import math
import pathlib
import re
import statistics
import subprocess

MODES = ("none", "cold", "warm")


def turned(centre, point, degrees):
    """`point`, turned about the vertical axis through `centre`."""
    sine, cosine = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    x, z = point[0] - centre[0], point[2] - centre[2]
    return [centre[0] + cosine * x + sine * z, point[1], centre[2] - sine * x + cosine * z]


class Scene:
    def __init__(self, options, scene):
        self.options, self.scene, self.qray = options, scene, options.bin / "qray"
        self.name = re.sub(r"\W+", "-", scene.removeprefix("/")[-40:])
        said = subprocess.run([self.qray, "scene", "check", scene], text=True, capture_output=True, check=True).stdout
        at, target = re.search(r"^camera .*\bat (\S+), target (\S+)", said, re.M).groups()
        self.position, self.target = ([float(x) for x in words.split(",")] for words in (at, target))

    def render(self, out, method, seconds, seed, *more, camera=None):
        position, target = camera or (self.position, self.target)
        subprocess.run(
            [self.qray, "render", self.scene, "--method", method, "--seconds", str(seconds), "--size",
             self.options.size, "--threads", str(self.options.threads), "--seed", str(seed), "--camera-position",
             ",".join(map(str, position)), "--camera-target", ",".join(map(str, target)), "-q", "-o", out, *more],
            check=True, stderr=subprocess.DEVNULL)

    def reference(self, name="", camera=None):
        path = self.options.work / f"{self.name}{name}-{self.options.size}.exr"
        if not path.exists():
            self.render(path, self.options.reference_method, self.options.reference_seconds, 777, camera=camera)
        return path

    def table(self):
        path = self.options.work / f"{self.name}.qrt"
        if not path.exists():
            away = turned(self.position, self.target, 20)
            self.render(self.options.work / "x.exr", "adaptive", self.options.teacher_seconds, 11, "--table-out", path,
                        camera=(self.position, away))
        return path

    def error(self, picture, reference):
        said = subprocess.run([self.qray, "diff", picture, reference, "--json"], text=True, capture_output=True).stdout
        diff = json.loads(said)
        return diff["relmse"], diff["relmse_trimmed"]

    def views(self, count):
        return [(self.position, turned(self.position, self.target, 360 * k / count)) for k in range(count)]


def geometric_mean(values):
    return math.exp(statistics.mean(math.log(value) for value in values))


def short_jobs(scene, options):
    reference, table, picture = scene.reference(), scene.table(), options.work / "p.exr"
    for seconds in options.seconds:
        errors = {mode: [] for mode in options.modes}
        for seed in range(1, options.seeds + 1):
            for mode in options.modes:
                more = ["--table-in", table] if mode == "warm" else []
                scene.render(picture, "none" if mode == "none" else "adaptive", seconds, seed, *more)
                errors[mode].append(scene.error(picture, reference))
        line = f"{scene.name:<24}{seconds:>6}"
        for mode in options.modes:
            line += "".join(f"{statistics.median(column):>10.3g}" for column in zip(*errors[mode]))
        for over, under in (("none", "cold"), ("none", "warm"), ("cold", "warm")):
            if over in errors and under in errors:
                line += "  " + over + "/" + under + "".join(
                    f"{geometric_mean(a[k] / b[k] for a, b in zip(errors[over], errors[under])):>7.2f}" for k in (0, 1))
        print(line, flush=True)


def turntable(scene, options):
    picture, table, seconds = options.work / "p.exr", options.work / "turntable.qrt", options.seconds[0]
    totals = {"cold": [0, 0], "warm": [0, 0]}
    table.unlink(missing_ok=True)
    for k, camera in enumerate(scene.views(options.views)):
        reference = scene.reference(f"-{k}-of-{options.views}", camera)
        for mode in totals:
            more = ["--table-out", table] if mode == "warm" else []
            if mode == "warm" and table.exists():
                more += ["--table-in", table]
            scene.render(picture, "adaptive", seconds, k + 1, *more, camera=camera)
            for column, error in enumerate(scene.error(picture, reference)):
                totals[mode][column] += error
    cold, warm = totals["cold"], totals["warm"]
    print(f"{scene.name:<24}{options.views} views of {seconds} s: cold {cold[0]:.4g} ({cold[1]:.4g}), warm "
          f"{warm[0]:.4g} ({warm[1]:.4g}), cold/warm {cold[0] / warm[0]:.2f} ({cold[1] / warm[1]:.2f})", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--seconds", default=".25,.5,1,2")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--size", default="256x256")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--modes", default=",".join(MODES))
    parser.add_argument("--teacher-seconds", type=float, default=100)
    parser.add_argument("--reference-seconds", type=float, default=60)
    parser.add_argument("--reference-method", default="adaptive")
    parser.add_argument("--views", type=int, default=0)
    options = parser.parse_args()
    options.seconds = [float(word) for word in options.seconds.split(",")]
    options.modes = options.modes.split(",")
    options.work.mkdir(parents=True, exist_ok=True)
    for name in options.scenes:
        (turntable if options.views else short_jobs)(Scene(options, name), options)


if __name__ == "__main__":
    main()
