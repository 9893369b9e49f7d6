"""Called by mitsuba.sh with FIRST=1: how long each renderer takes, started anew, to a small picture."""

import os
import resource
import statistics
import subprocess
import sys
import time

from prepare_mitsuba import prepared

MITSUBA = """
import sys
import mitsuba
mitsuba.set_variant(sys.argv[1])
mitsuba.file_resolver().prepend(sys.argv[2])
mitsuba.Bitmap(mitsuba.render(mitsuba.load_file(sys.argv[3]), spp=1)).write(sys.argv[4])
"""


def seconds_of(command):
    """Of the processors, and passed."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    passed = time.monotonic() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, passed


def main():
    qray, folder, size, _, runs = sys.argv[1:6]
    os.makedirs(folder, exist_ok=True)
    variant = os.environ.get("MITSUBA_VARIANT", "scalar_rgb")
    print("| scene | processor seconds: qray | Mitsuba 3 | seconds passed: qray | Mitsuba 3 |\n|---|--:|--:|--:|--:|")
    for path in map(os.path.abspath, sys.argv[6:]):
        file, wide, high = prepared(path, folder, int(size), 1)
        out = os.path.join(folder, "first.exr")
        commands = {
            "qray": [qray, "render", path, "--size", f"{wide}x{high}", "--spp", "1", "--method", "none", "-q", "-o", out],
            "mitsuba": [sys.executable, "-c", MITSUBA, variant, os.path.dirname(path), file, out]}
        taken = {name: [] for name in commands}
        for _ in range(int(runs)):
            for name, command in commands.items():
                taken[name].append(seconds_of(command))
        medians = [statistics.median(run[which] for run in taken[name]) for which in (0, 1) for name in commands]
        name = os.path.basename(os.path.dirname(path))
        print(f"| {name} | " + " | ".join(f"{value:.2f}" for value in medians) + " |", flush=True)


if __name__ == "__main__":
    main()
