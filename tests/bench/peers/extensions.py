"""Small glTF files of material extensions that ../shared/testdata has no file of, for cycles.sh:
`python3 extensions.py FOLDER` writes a ball of each material below."""

import base64
import json
import math
import os
import struct
import sys

MATERIALS = {
    "clearcoat": (dict(color=[.5, .2, .1], roughness=.7), {
        "KHR_materials_specular": {"specularFactor": 0},
        "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": .2}}),
    "specular": (dict(color=[.05, .1, .2], roughness=.3), {
        "KHR_materials_specular": {"specularFactor": .7, "specularColorFactor": [1, .7, .4]}}),
    "iridescence_thin": (dict(color=[0, 0, 0], roughness=.2), {
        "KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceThicknessMaximum": 300}}),
    "iridescence_thick": (dict(color=[0, 0, 0], roughness=.5), {
        "KHR_materials_ior": {"ior": 2},
        "KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceIor": 1.5,
                                      "iridescenceThicknessMaximum": 550}}),
    "iridescence_white": (dict(color=[.8, .8, .8], roughness=.2), {
        "KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceThicknessMaximum": 400}}),
    # Without microfacets, which Cycles' translucent shader knows nothing of.
    "diffuse_transmission": (dict(color=[.2, .4, .6], roughness=.5), {
        "KHR_materials_specular": {"specularFactor": 0},
        "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": .6,
                                               "diffuseTransmissionColorFactor": [.9, .6, .3]}}),
}
RINGS, SECTORS = 128, 256


def ball():
    """Positions, which are the normals too, and triangles of the unit ball."""
    points = [(math.sin(a) * math.cos(b), math.cos(a), math.sin(a) * math.sin(b))
              for a in (math.pi * r / RINGS for r in range(RINGS + 1))
              for b in (2 * math.pi * s / SECTORS for s in range(SECTORS))]
    triangles = []
    for r in range(RINGS):
        for s in range(SECTORS):
            a, b = r * SECTORS + s, r * SECTORS + (s + 1) % SECTORS
            c, d = a + SECTORS, b + SECTORS
            triangles += ([(a, b, d)] if r > 0 else []) + ([(a, d, c)] if r < RINGS - 1 else [])
    return points, triangles


def gltf_of(name, extensions, color, roughness):
    points, triangles = ball()
    data = b"".join(struct.pack("<3f", *p) for p in points)
    places = len(data)
    data += b"".join(struct.pack("<3I", *t) for t in triangles)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    material = {
        "name": name, "extensions": extensions,
        "pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": 0, "roughnessFactor": roughness}}
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "extensionsUsed": sorted(extensions), "materials": [material],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1, "material": 0}]}],
        "buffers": [{"uri": uri, "byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteLength": places},
                        {"buffer": 0, "byteOffset": places, "byteLength": len(data) - places}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3",
                       "min": [-1, -1, -1], "max": [1, 1, 1]},
                      {"bufferView": 1, "componentType": 5125, "count": 3 * len(triangles), "type": "SCALAR"}]}


def main():
    folder = sys.argv[1]
    os.makedirs(folder, exist_ok=True)
    for name, (core, extensions) in MATERIALS.items():
        with open(os.path.join(folder, name + ".gltf"), "w", encoding="utf-8") as file:
            json.dump(gltf_of(name, extensions, **core), file)


if __name__ == "__main__":
    main()
