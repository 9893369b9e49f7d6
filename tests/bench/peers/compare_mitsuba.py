"""Called by mitsuba.sh: both renderers in turn, and what their pictures tell."""

import json
import os
import subprocess
import sys
import time
import xml.etree.ElementTree as xml

import mitsuba
import numpy

from pictures import read
from regions import difference


def prepared(path, folder, size, spp):
    """The scene with a box filter, another size, and without what Mitsuba 3 no longer knows."""
    tree = xml.parse(path)
    root = tree.getroot()
    defaults = {"$" + d.get("name"): d.get("value") for d in root.findall("default")}
    sensor = root.find("sensor")
    film = sensor.find("film")
    sides = {}
    for value in film.findall("integer"):
        if value.get("name") in ("width", "height"):
            sides[value.get("name")] = int(defaults.get(value.get("value"), value.get("value")))
    wide, high = sides.get("width", 768), sides.get("height", 576)
    scale = size / max(wide, high)
    wide, high = max(1, round(wide * scale)), max(1, round(high * scale))
    sensor.remove(film)
    film = xml.SubElement(sensor, "film", type="hdrfilm")
    xml.SubElement(film, "integer", name="width", value=str(wide))
    xml.SubElement(film, "integer", name="height", value=str(high))
    xml.SubElement(film, "rfilter", type="box")
    for sampler in sensor.findall("sampler"):
        sensor.remove(sampler)
    sampler = xml.SubElement(sensor, "sampler", type="independent")
    xml.SubElement(sampler, "integer", name="sample_count", value=str(spp))
    depth = "-1"
    for integrator in root.findall("integrator"):
        for value in integrator.findall("integer"):
            if value.get("name") in ("maxDepth", "max_depth"):
                depth = defaults.get(value.get("value"), value.get("value"))
        root.remove(integrator)
    integrator = xml.SubElement(root, "integrator", type="path")
    xml.SubElement(integrator, "integer", name="max_depth", value=depth)
    if root.get("version", "0").startswith("0."):
        for value in integrator.findall("integer") + sampler.findall("integer"):
            value.set("name", {"max_depth": "maxDepth", "sample_count": "sampleCount"}[value.get("name")])
    # Beside its includes, where Mitsuba looks for them; meshes are found through the resolver.
    out = os.path.join(folder, "prepared.xml")
    tree.write(out)
    return out, wide, high


def compare(qray, folder, size, spp, runs, path):
    os.makedirs(folder, exist_ok=True)
    name = os.path.basename(os.path.dirname(os.path.abspath(path)))
    prepared_path, wide, high = prepared(path, folder, size, spp)
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
                        "--method", "none", "--seed", str(run + 1), "-q", "-o", out,
                        "--json", stats], check=True, stderr=subprocess.DEVNULL)
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
    print("| scene | mean, qray over Mitsuba 3 | FLIP | z of 16 regions: median, greatest "
          "| regions' means off by | qray, M samples/s | Mitsuba |\n|---|---|--:|--:|--:|--:|--:|")
    for path in sys.argv[6:]:
        try:
            compare(qray, folder, int(size), int(spp), int(runs), path)
        except (RuntimeError, subprocess.CalledProcessError) as error:
            print(f"| {path} | not compared: {str(error).splitlines()[0]} | | | | | |", flush=True)


main()
