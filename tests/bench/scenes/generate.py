#!/usr/bin/env python3
"""Makes rooms that no method was tuned on: tests/bench/scenes/generate.py OUT [--sky FILE.hdr]

Each becomes OUT/<name>/scene.json. With --sky, a room with a glazed window and a ground of glass
and metal balls are lit by that picture. docs/measurements/guiding.md has figures.
"""
import argparse
import json
import pathlib
import random
import shutil

WALL = {"name": "wall", "type": "diffuse", "reflectance": 0.75}
MATERIALS = [
    WALL,
    {"name": "floor", "type": "diffuse", "reflectance": [0.45, 0.3, 0.2]},
    {"name": "gloss", "type": "plastic", "reflectance": [0.2, 0.25, 0.4], "roughness": 0.3},
    {"name": "metal", "type": "conductor", "metal": "aluminium", "roughness": 0.35},
    {"name": "cloth", "type": "diffuse", "reflectance": [0.5, 0.1, 0.1]},
]


def lamp(radiance):
    return {"name": "lamp", "type": "diffuse", "reflectance": 0.5, "emission": radiance}


def box(material, low, high, **more):
    return {"material": material, "box": {"min": low, "max": high}, **more}


def quad(material, origin, edge1, edge2):
    return {"material": material, "quad": {"origin": origin, "edge1": edge1, "edge2": edge2}}


def ball(material, center, radius, **more):
    return {"material": material, "sphere": {"center": center, "radius": radius, **more}}


def cone(material, base, height, radius, top):
    return {"material": material, "cylinder": {"base": base, "height": height, "radius": radius,
                                               "top_radius": top, "caps": False}}


def floor(x, z):
    return quad("floor", [-x, 0.001, z], [2 * x, 0, 0], [0, 0, -2 * z])


def closed(material, x, height, z):
    return [box(material, [-x, 0, -z], [x, height, z], flip=True), floor(x, z)]


def furniture():
    return [box("gloss", [-1, 0.7, -0.6], [0.2, 0.76, 0.1]),
            box("gloss", [-0.95, 0, -0.55], [-0.85, 0.7, -0.45]),
            box("gloss", [0.05, 0, -0.05], [0.15, 0.7, 0.05]),
            ball("metal", [-0.4, 0.91, -0.25], 0.15),
            box("cloth", [0.6, 0, -1.2], [1.6, 0.45, -0.4]),
            box("cloth", [0.6, 0.45, -1.2], [1.6, 0.9, -1.05])]


def view(position, target, fov=60):
    return {"position": position, "target": target, "vertical_fov_deg": fov}


def office():
    """Six lamps under the ceiling, whose louvres hide them from most places."""
    meshes = closed("wall", 3, 2.8, 3)
    for x, z in [(-2 + 1.8 * i, -1.8 + 2.4 * j) for i in range(3) for j in range(2)]:
        meshes.append(quad("lamp", [x, 2.79, z], [0.3, 0, 0], [0, 0, 1.2]))
        for louvre in [z + 0.15 * k for k in range(9)]:
            meshes.append(box("metal", [x - 0.05, 2.6, louvre], [x + 0.35, 2.75, louvre + 0.01]))
        meshes += [box("gloss", [x - 0.2, 0.7, z + 0.2], [x + 1, 0.75, z + 0.9]),
                   box("cloth", [x + 0.1, 0, z + 1], [x + 0.6, 0.5, z + 1.4]),
                   box("metal", [x + 0.1, 0.75, z + 0.3], [x + 0.7, 1.15, z + 0.33])]
    return dict(camera=view([2.7, 1.7, 2.7], [-0.6, 0.8, -0.8], 65),
                materials=MATERIALS + [lamp([18, 18, 17])], meshes=meshes)


def corridor():
    """Two bends lie between the lamp and the camera, and the picture is dark."""
    walls = [([-1, -0.1, -8], [9, 0, 3]), ([-1, 2.5, -8], [9, 2.6, 3]),
             ([-1.1, 0, -4], [-1, 2.5, 3]), ([1, 0, -2], [1.1, 2.5, 3]),
             ([-1.1, 0, 3], [1.1, 2.5, 3.1]), ([-1.1, 0, -4.1], [6, 2.5, -4]),
             ([1, 0, -2.1], [8, 2.5, -2]), ([8, 0, -8], [8.1, 2.5, -2]),
             ([6, 0, -8], [6.1, 2.5, -4]), ([6, 0, -8.1], [8.1, 2.5, -8])]
    meshes = [box("wall", low, high) for low, high in walls]
    meshes += [quad("lamp", [6.7, 2.49, -7.4], [0.6, 0, 0], [0, 0, 0.6]),
               box("gloss", [-0.8, 0, -1], [-0.2, 0.8, -0.3]), ball("metal", [0.5, 0.4, -1.6], 0.4),
               box("cloth", [2.5, 0, -3.8], [3.2, 1, -3.2])]
    return dict(camera=view([0, 1.5, 2.7], [0.1, 1.1, -3]),
                materials=MATERIALS + [lamp([120, 110, 90])], meshes=meshes)


def lampshade():
    """Small bulbs under a shade that light passes, and in a cone of metal."""
    shade = {"name": "shade", "type": "principled", "reflectance": [0.8, 0.7, 0.5],
             "roughness": 0.9, "thin": True, "diffuse_transmission": 0.5}
    meshes = closed("wall", 2, 2.6, 2) + furniture()
    meshes += [cone("shade", [-1.4, 1.2, -1.4], 0.35, 0.28, 0.16),
               cone("metal", [-1.4, 0, -1.4], 1.2, 0.02, 0.02),
               ball("lamp", [-1.4, 1.35, -1.4], 0.05),
               cone("metal", [-0.75, 1, -0.4], 0.2, 0.12, 0.04),
               ball("lamp", [-0.75, 1.12, -0.4], 0.025)]
    return dict(camera=view([1.7, 1.5, 1.7], [-0.5, 0.9, -0.7], 58),
                materials=MATERIALS + [shade, lamp([400, 330, 220])], meshes=meshes)


def cove():
    """Walls of rough copper; strips of light lie hidden on ledges and shine up."""
    copper = {"name": "copper", "type": "conductor", "metal": "copper", "roughness": 0.6}
    meshes = closed("copper", 3, 3, 3) + furniture()
    meshes += [box("wall", [-3, 2.3, -3], [-2.7, 2.35, 3]),
               box("wall", [2.7, 2.3, -3], [3, 2.35, 3]),
               box("wall", [-2.75, 2.35, -3], [-2.7, 2.45, 3]),
               box("wall", [2.7, 2.35, -3], [2.75, 2.45, 3]),
               quad("lamp", [-2.98, 2.36, 2.5], [0.1, 0, 0], [0, 0, -5]),
               quad("lamp", [2.88, 2.36, 2.5], [0.1, 0, 0], [0, 0, -5])]
    return dict(camera=view([1.8, 1.5, 2.6], [-0.4, 1, -1]),
                materials=MATERIALS + [copper, lamp([60, 50, 40])], meshes=meshes)


def gallery():
    """Six spots, each on a picture; the rest of the room is dark."""
    meshes, lights = closed("wall", 4, 3.5, 3), []
    for x in [-3.3 + 1.3 * i for i in range(6)]:
        meshes.append(box("gloss", [x - 0.4, 1.2, -2.98], [x + 0.4, 2.1, -2.93]))
        lights.append({"type": "spot", "position": [x, 3.3, -1.5], "direction": [0, -1.7, -1.45],
                       "intensity": [12, 11, 9], "inner_deg": 10, "outer_deg": 22})
    meshes += [ball("metal", [-1.5, 0.5, -0.5], 0.5), box("cloth", [0.5, 0, -0.8], [1.6, 0.5, 0.2])]
    return dict(camera=view([3.2, 1.6, 2.7], [-0.6, 1.3, -2]), materials=MATERIALS, meshes=meshes,
                lights=lights)


def with_opening(low, high, height, sides):
    """A box open at the low end of z or the top, with `sides` around the opening there."""
    (x0, z0), (x1, z1) = low, high
    return [box("wall", [x0, -0.1, z0], [x1, 0, z1]),
            box("wall", [x0 - 0.1, 0, z0], [x0, height, z1]),
            box("wall", [x1, 0, z0], [x1 + 0.1, height, z1]),
            box("wall", [x0, 0, z1], [x1, height, z1 + 0.1]),
            *[box("wall", *side) for side in sides]]


def shaft():
    """The floor of a light well, 12 m below a skylight with a dome."""
    top, y = 2.1, 12
    sides = [([-top, 0, -top], [top, y, -2]), ([-top, y, -top], [top, y + 0.1, -0.4]),
             ([-top, y, 0.4], [top, y + 0.1, top]), ([-top, y, -0.4], [-0.4, y + 0.1, 0.4]),
             ([0.4, y, -0.4], [top, y + 0.1, 0.4])]
    dome = {"name": "dome", "type": "thin_dielectric"}
    meshes = with_opening((-2, -2), (2, 2), y, sides) + furniture()
    meshes.append(ball("dome", [0, 12.3, 0], 0.6))
    return dict(camera=view([1.7, 1.5, 1.7], [-0.5, 1.2, -0.8], 65), materials=MATERIALS + [dome],
                meshes=meshes, environment={"radiance": [6, 7, 9]})


def window(sky):
    """A room that a picture of the sky lights through a pane."""
    sides = [([-2, 0, -2.15], [-0.9, 2.6, -2]), ([0.5, 0, -2.15], [2, 2.6, -2]),
             ([-0.9, 0, -2.15], [0.5, 0.9, -2]), ([-0.9, 2.1, -2.15], [0.5, 2.6, -2]),
             ([-2, 2.6, -2], [2, 2.7, 2.2])]
    glass = {"name": "glass", "type": "thin_dielectric"}
    meshes = with_opening((-2, -2), (2, 2.2), 2.6, sides) + furniture()
    meshes += [floor(2, 2.2), quad("glass", [-0.9, 0.9, -2.07], [1.4, 0, 0], [0, 1.2, 0])]
    return dict(camera=view([1.4, 1.5, 1.8], [-0.5, 0.9, -1]), materials=MATERIALS + [glass],
                meshes=meshes, environment={"image": sky})


def balls(sky):
    """Forty balls of glass, metal, lacquer and plaster under a sky."""
    random.seed(5)
    materials = [{"name": "ground", "type": "diffuse", "reflectance": [0.5, 0.45, 0.4]},
                 {"name": "glass", "type": "dielectric"},
                 {"name": "frosted", "type": "dielectric", "roughness": 0.4},
                 {"name": "gold", "type": "conductor", "metal": "gold", "roughness": 0.2},
                 {"name": "lacquer", "type": "principled", "reflectance": [0.6, 0.05, 0.05],
                  "roughness": 0.5, "clearcoat": 1, "clearcoat_roughness": 0.1},
                 {"name": "plaster", "type": "diffuse", "reflectance": [0.2, 0.4, 0.6]}]
    meshes = [quad("ground", [-8, 0, 8], [16, 0, 0], [0, 0, -16])]
    for _ in range(40):
        radius = random.uniform(0.12, 0.4)
        place = [random.uniform(-3, 3), radius, random.uniform(-3, 2)]
        meshes.append(ball(random.choice(materials[1:])["name"], place, radius, exact=True))
    return dict(camera=view([0, 2.2, 4.5], [0, 0.3, -0.3], 45), materials=materials, meshes=meshes,
                environment={"image": sky})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--sky", type=pathlib.Path)
    options = parser.parse_args()
    scenes = [(make, []) for make in (office, corridor, lampshade, cove, gallery, shaft)]
    if options.sky:
        scenes += [(make, [options.sky.name]) for make in (window, balls)]
    for make, sky in scenes:
        folder = options.out / make.__name__
        folder.mkdir(parents=True, exist_ok=True)
        if sky:
            shutil.copy(options.sky, folder)
        scene = make(*sky)
        (folder / "scene.json").write_text(
            json.dumps({"name": make.__doc__.rstrip("."), "size": [256, 256], **scene}, indent=1))


if __name__ == "__main__":
    main()
