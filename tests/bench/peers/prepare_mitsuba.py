"""A Mitsuba file made ready for both renderers, for compare_mitsuba.py and first_pictures.py."""

import os
import xml.etree.ElementTree as xml


def prepared(path, folder, size, spp, depth=None):
    """The scene with a box filter, another size, and without what Mitsuba 3 no longer knows.

    `depth`: of paths without Russian roulette; None: the file's paths.
    """
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
    path = {"max_depth": "-1"}
    for integrator in root.findall("integrator"):
        for value in integrator.findall("integer"):
            if value.get("name") in ("maxDepth", "max_depth"):
                path["max_depth"] = defaults.get(value.get("value"), value.get("value"))
        root.remove(integrator)
    integrator = xml.SubElement(root, "integrator", type="path")
    if depth:
        path = {"max_depth": depth, "rr_depth": "1000000"}
    for name, value in path.items():
        xml.SubElement(integrator, "integer", name=name, value=value)
    if root.get("version", "0").startswith("0."):
        for value in integrator.findall("integer") + sampler.findall("integer"):
            value.set("name", {"max_depth": "maxDepth", "rr_depth": "rrDepth",
                               "sample_count": "sampleCount"}[value.get("name")])
    # Beside its includes, where Mitsuba looks for them; meshes are found through the resolver.
    out = os.path.join(folder, "prepared.xml")
    tree.write(out)
    return out, wide, high
