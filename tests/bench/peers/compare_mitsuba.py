"""Called by mitsuba.sh: both renderers in turn, and what their pictures tell."""

import ctypes
import json
import os
import subprocess
import sys
import time

import drjit
import mitsuba
import numpy

from pictures import read
from prepare_mitsuba import prepared
from regions import difference


def as_with_avx2():
    """Mitsuba's vectors as on a processor that has AVX2 and no more; drjit has no other way."""
    drjit.eval(drjit.llvm.Float(0) + 1)  # starts LLVM
    core = ctypes.CDLL(os.path.join(os.path.dirname(drjit.__file__), "libdrjit-core.so"))
    set_target = core["_Z19jit_llvm_set_targetPKcS0_j"]
    set_target.argtypes = [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_uint]
    set_target(b"haswell", b"+fma,+bmi,+bmi2,+avx,+avx2,+f16c", 8)


def compare(qray, folder, size, spp, runs, path):
    os.makedirs(folder, exist_ok=True)
    depth = os.environ.get("DEPTH")
    paths = ["--method", "none"]
    if depth:
        paths = ["--method", "none:roulette=off", "--max-depth", depth]
    name = os.path.basename(os.path.dirname(os.path.abspath(path)))
    prepared_path, wide, high = prepared(path, folder, size, spp, depth)
    mitsuba.file_resolver().prepend(os.path.dirname(os.path.abspath(path)))
    scene = mitsuba.load_file(prepared_path)
    numpy.array(mitsuba.render(scene, spp=1))  # some variants compile
    theirs, ours, seconds = [], [], {"qray": 0.0, "mitsuba": 0.0}
    for run in range(runs):
        start = time.monotonic()
        picture = numpy.array(mitsuba.render(scene, spp=spp, seed=run))
        seconds["mitsuba"] += time.monotonic() - start
        theirs.append(picture[:, :, :3])
        out, stats = os.path.join(folder, "run.exr"), os.path.join(folder, "run.json")
        subprocess.run([qray, "render", path, "--size", f"{wide}x{high}", "--spp", str(spp),
                        *paths, "--seed", str(run + 1), "-q", "-o", out, "--json", stats],
                       check=True, stderr=subprocess.DEVNULL)
        with open(stats, encoding="utf-8") as file:
            seconds["qray"] += json.load(file)["seconds"]
        ours.append(read(out))
    mean = {}
    for renderer, pictures in (("qray", ours), ("mitsuba", theirs)):
        mean[renderer] = numpy.mean(pictures, axis=0)
        mitsuba.Bitmap(mean[renderer].astype(numpy.float32)).write(
            os.path.join(folder, f"{name}-{renderer}.exr"))
    flip = json.loads(subprocess.run(
        [qray, "diff", os.path.join(folder, f"{name}-qray.exr"),
         os.path.join(folder, f"{name}-mitsuba.exr"), "--json"],
        check=True, capture_output=True).stdout)["flip"]
    ratio, z, off = difference(ours, theirs)
    samples = wide * high * spp * runs / 1e6
    print(f"| {name} | {ratio} | {flip:.4f} | {z} | {off} | {samples / seconds['qray']:.2f} "
          f"| {samples / seconds['mitsuba']:.2f} |", flush=True)


def main():
    qray, folder, size, spp, runs = sys.argv[1:6]
    if os.environ.get("AVX2"):
        as_with_avx2()
    print("| scene | mean, qray over Mitsuba 3 | FLIP | z of 16 regions: median, greatest "
          "| regions' means off by | qray, M samples/s | Mitsuba |\n|---|---|--:|--:|--:|--:|--:|")
    for path in sys.argv[6:]:
        try:
            compare(qray, folder, int(size), int(spp), int(runs), path)
        except (RuntimeError, subprocess.CalledProcessError) as error:
            print(f"| {path} | not compared: {str(error).splitlines()[0]} | | | | | |", flush=True)


main()
