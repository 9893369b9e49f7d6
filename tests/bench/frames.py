#!/usr/bin/env python3
"""What one table for all frames is worth to a job of many, how much frames flicker, and whether kills change bits.

python3 tests/bench/frames.py worth BIN WORK SCENE [--count 36] [--size 256x256] [--spp 64] [--arc 360] [-- OPTIONS]
python3 tests/bench/frames.py moves BIN WORK SCENE [--fps 4] [--size 256x256] [--spp 64] [--move NAMES --by X,Y,Z]
python3 tests/bench/frames.py flicker BIN WORK SCENE [--seconds 2] [--repeats 6] [-- OPTIONS]
python3 tests/bench/frames.py kill BIN WORK SCENE [--count 6] [--size 128x128] [--spp 64] [--kills 50] [--request JSON]

BIN: the folder of `qray` and `qrayd`. WORK: a scratch folder. OPTIONS: what `qray render` is given beside, such as
`--camera-position 3.6,1.4,3.2`. --request: more of what a job is asked for, such as '{"passes": ["all"]}'.

worth: a turntable, rendered as one job, as so many jobs each cold, as jobs in a chain of which each takes over the
table of the one before, and without learning. Each twice: half of how much the two differ is the relMSE (trimmed: without the
worst .1 % of pixels). Time is that of the processor, without loading the scene: it hardly depends on what else the
machine does.
moves: the same for an animation as the scene's file has it, without the chain. --move: in a copy of an included scene,
the meshes whose names begin with one of these move in 3 s.
flicker: the same still camera again and again for --seconds each, by `none` and by `adaptive` as one job of frames:
how much neighbours differ, as the root of half of their relMSE, and how much so with one pattern of noise.
kill: a job of frames on a server that is killed (SIGKILL) at random, once it has written a state; its pictures, and its
layers where passes are asked for, against those of one let alone.
"""
import argparse
import itertools
import json
import math
import os
import pathlib
import random
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import time
import urllib.request


def turned(centre, point, degrees):
    """`point`, turned about the vertical axis through `centre`, as qray's turntable turns."""
    sine, cosine = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    x, z = point[0] - centre[0], point[2] - centre[2]
    return [centre[0] + cosine * x + sine * z, point[1], centre[2] - sine * x + cosine * z]


def render(o, *more):
    """Its statistics, and processor seconds."""
    process = subprocess.Popen([o.bin / "qray", "render", o.scene, "-q", *map(str, more), *o.options],
                               stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"qray render {o.scene} fails")
    return json.loads((o.work / "stats.json").read_text()), usage.ru_utime + usage.ru_stime


def camera_of(o):
    """Position and target: those of the options, else the scene's."""
    said = subprocess.run([o.bin / "qray", "scene", "check", o.scene], text=True, capture_output=True,
                          check=True).stdout
    line = next(line for line in said.splitlines() if line.startswith("camera"))
    at, target = line.split(" at ")[1].split(", target ")
    given = dict(itertools.pairwise(o.options))
    return [[float(v) for v in given.get(name, fallback).split(",")]
            for name, fallback in (("--camera-position", at), ("--camera-target", target))]


def worth(o):
    position, target = camera_of(o)
    step = o.arc / o.count if abs(o.arc) >= 360 else o.arc / (o.count - 1)
    stats = o.work / "stats.json"
    plain = argparse.Namespace(**{**vars(o), "options": strip(o.options)})
    load = min(render(o, "--method", "none", "--spp", 1, "--size", "16x16", "--json", stats, "-o", o.work / "x.exr")[1]
               for _ in range(3))
    seconds = {"none": 0, "one job": 0, "cold jobs": 0, "chain": 0}
    for seed in (11, 12):
        asked = ["--size", o.size, "--spp", o.spp, "--seed", seed, "--json", stats]
        frames = ["--turntable", o.count, "--turntable-degrees", o.arc, "--frame-format", "exr"]
        for name, more in (("one job", []), ("none", ["--method", "none"])):
            seconds[name] += render(o, *asked, *frames, *more, "-o", o.work / f"{name}-{seed}")[1] - load
        table = o.work / "chain.qrt"
        table.unlink(missing_ok=True)
        for i in range(o.count):
            at = ["--camera-position", ",".join(map(str, turned(target, position, i * step))), "--camera-target",
                  ",".join(map(str, target))]
            handed = ["--table-in", table] if table.exists() else []
            for name, more in (("cold jobs", []), ("chain", [*handed, "--table-out", table])):
                folder = o.work / f"{name}-{seed}"
                folder.mkdir(exist_ok=True)
                seconds[name] += render(plain, *asked, *at, *more, "-o", folder / f"frame-{i:04d}.exr")[1] - load
    compare(o, seconds, o.count)


def with_motion(o):
    """A copy of the scene, in which what --move names moves."""
    folder = o.work / "moved"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(pathlib.Path(__file__).parents[2] / "scenes" / o.scene, folder)
    scene = json.loads((folder / "scene.json").read_text())
    for mesh in scene["meshes"]:
        if mesh.get("name", "").startswith(tuple(o.move.split(","))):
            mesh["motion"] = {"seconds": [0, 3], "translate": [[0, 0, 0], [float(v) for v in o.by.split(",")]]}
    (folder / "scene.json").write_text(json.dumps(scene))
    return folder / "scene.json"


def moves(o):
    o.scene = with_motion(o) if o.move else o.scene
    stats, path = o.work / "stats.json", o.work / "frames.json"
    load = min(render(o, "--method", "none", "--spp", 1, "--size", "16x16", "--json", stats, "-o", o.work / "x.exr")[1]
               for _ in range(3))
    seconds = {"none": 0, "one job": 0, "cold jobs": 0}
    for seed in (11, 12):
        asked = ["--size", o.size, "--spp", o.spp, "--seed", seed, "--json", stats, "--frame-format", "exr"]
        for name, more in (("one job", []), ("none", ["--method", "none"])):
            folder = o.work / f"{name}-{seed}"
            shutil.rmtree(folder, ignore_errors=True)
            seconds[name] += render(o, *asked, "--animation", o.fps, *more, "-o", folder)[1]
        count = len(list(folder.glob("frame-*.exr")))
        for i in range(count):
            path.write_text(json.dumps({"animation": o.fps, "from": i / o.fps, "to": i / o.fps}))
            alone, folder = o.work / "alone", o.work / f"cold jobs-{seed}"
            folder.mkdir(exist_ok=True)
            seconds["cold jobs"] += render(o, *asked, "--frames", path, "-o", alone)[1] - load
            (alone / "frame-0000.exr").replace(folder / f"frame-{i:04d}.exr")
    compare(o, seconds, count)


def compare(o, seconds, count):
    variance = {name: [differ(o, *(o.work / f"{name}-{seed}" / f"frame-{i:04d}.exr" for seed in (11, 12))) ** 2
                       for i in range(count)] for name in seconds}
    print(f"{o.scene}, {count} frames of {o.size}, {o.spp} samples a pixel")
    for name, values in variance.items():
        times = [a * seconds[name] / (b * seconds["one job"]) for a, b in zip(values, variance["one job"]) if b > 0]
        print(f"{name}: {seconds[name] / 2:.1f} processor seconds, relMSE {statistics.median(values):.4f} (median of "
              f"the frames); time to equal error over that of one job: {statistics.median(times):.2f} (median), "
              f"{statistics.geometric_mean(times):.2f} (geometric mean)", flush=True)


def strip(options):
    """Without the camera's place, which each frame says itself."""
    out, skip = [], False
    for word in options:
        skip, drop = word in ("--camera-position", "--camera-target"), skip
        if not skip and not drop:
            out.append(word)
    return out


def differ(o, a, b):
    said = subprocess.run([o.bin / "qray", "diff", a, b, "--json"], text=True, capture_output=True).stdout
    return math.sqrt(json.loads(said)["relmse_trimmed"] / 2)


def flicker(o):
    camera = json.dumps({"vertical_fov_deg": 45})
    still = list(itertools.chain.from_iterable(["--camera", camera] for _ in range(o.repeats)))
    for method, seeds in (("none", "independent"), ("adaptive", "independent"), ("adaptive", "one")):
        folder = o.work / f"{method}-{seeds}"
        render(o, "--size", o.size, *still, "--method", method, "--frame-seeds", seeds, "--seconds", o.seconds,
               "--frame-format", "exr", "--json", o.work / "stats.json", "-o", folder)
        frames = sorted(folder.glob("frame-*.exr"))
        apart = [differ(o, a, b) for a, b in itertools.pairwise(frames)]
        print(f"{o.scene}, {o.seconds} s a frame, {method}, seeds {seeds}: neighbours differ by "
              f"{statistics.median(apart):.4f}", flush=True)


class Server:
    def __init__(self, o, data):
        self.log = open(o.work / "qrayd.log", "a")
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.process = subprocess.Popen([o.bin / "qrayd", "--port", str(port), "--data", data], stdout=self.log,
                                        stderr=self.log)
        self.started = time.time()
        self.url = f"http://127.0.0.1:{port}"
        deadline = time.time() + 30
        while time.time() < deadline:
            try:
                urllib.request.urlopen(self.url + "/readyz").read()
                return
            except OSError:
                time.sleep(.02)
        raise SystemExit("the server does not start")

    def get(self, path):
        with urllib.request.urlopen(self.url + path) as answer:
            return answer.read()

    def post(self, path, body):
        request = urllib.request.Request(self.url + path, json.dumps(body).encode(),
                                         {"Content-Type": "application/json"})
        with urllib.request.urlopen(request) as answer:
            return json.loads(answer.read())

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()


def kill(o):
    width, height = map(int, o.size.split("x"))
    request = {"scene": o.scene, "width": width, "height": height, "samples": o.spp, "table": "none",
               "frames": {"turntable": o.count, "degrees": o.arc}, **json.loads(o.request)}
    files = ["image.png", "passes.exr"] if "passes" in request else ["image.png"]
    data = o.work / "data"
    shutil.rmtree(data, ignore_errors=True)

    def pictures(server, job):
        return [server.get(f"/v1/jobs/{job}/{file}?frame={i}") for i in range(o.count) for file in files]

    def ended(server, job):
        return json.loads(server.get(f"/v1/jobs/{job}?wait=1"))["state"] in ("succeeded", "failed", "canceled")

    server = Server(o, data)
    start = time.time()
    job = server.post("/v1/jobs", request)["id"]
    while not ended(server, job):
        pass
    took, expected = time.time() - start, pictures(server, job)
    rng, kills, jobs = random.Random(o.seed), 0, 0
    while kills < o.kills:
        job, jobs = server.post("/v1/jobs", request)["id"], jobs + 1
        state_file = data / "checkpoints" / job
        while True:
            # A job that gets nowhere in three runs fails, as it should: each run writes a state first.
            while not ended(server, job) and not (state_file.exists() and state_file.stat().st_mtime > server.started):
                time.sleep(.02)
            time.sleep(rng.uniform(0, 1) * min(took / 3, 6))
            if kills < o.kills and not ended(server, job):
                server.kill()
                kills += 1
                server = Server(o, data)
            elif ended(server, job):
                break
        state = json.loads(server.get(f"/v1/jobs/{job}"))["state"]
        same = state == "succeeded" and pictures(server, job) == expected
        print(f"{kills} kills, {jobs} jobs: {job} {state}, {'the same bits' if same else 'OTHER BITS'}", flush=True)
        if not same:
            raise SystemExit(1)
    server.kill()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["worth", "moves", "flicker", "kill"])
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("scene")
    parser.add_argument("--count", type=int, default=36)
    parser.add_argument("--size", default="256x256")
    parser.add_argument("--arc", type=float, default=360)
    parser.add_argument("--seconds", type=float, default=2)
    parser.add_argument("--repeats", type=int, default=6)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--fps", type=float, default=4)
    parser.add_argument("--move", default="")
    parser.add_argument("--by", default="0,0,1")
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--request", default="{}")
    at = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    o = parser.parse_args(sys.argv[1:at])
    o.options = sys.argv[at + 1:]
    o.work.mkdir(parents=True, exist_ok=True)
    {"worth": worth, "moves": moves, "flicker": flicker, "kill": kill}[o.what](o)


if __name__ == "__main__":
    main()
