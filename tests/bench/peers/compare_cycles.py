"""Called by cycles.sh: glTF files drawn by Blender's Cycles and by qray, and what their pictures tell."""

import base64
import json
import math
import os
import re
import shutil
import struct
import subprocess
import sys

import bpy
import mathutils
import numpy

from regions import difference

FOV = 40  # degrees, of the longer side, where the file has no camera
# What is seen around a file without light, as a box: the radiance of its sides -x, +x, -y ...
SIDES = ((2, 1, .5), (.2, .5, 1.5), (.2, .3, .1), (1.5, 1.5, 1.5), (.1, .1, .1), (.8, .6, .9))

COLORS = ("baseColorTexture", "emissiveTexture", "specularColorTexture", "sheenColorTexture")


def check(qray, path):
    """What qray says of a file: its camera's place and target, the picture's shape, its warnings."""
    text = subprocess.run([qray, "scene", "check", path], check=True, capture_output=True, text=True).stdout
    number = r"(-?[\d.e+-]+)"
    camera = re.search(rf"^camera +\w+, at {number},{number},{number}, target {number},{number},{number}",
                       text, re.M)
    values = [float(v) for v in camera.groups()]
    shape = re.search(r"^picture +(\d+) x (\d+)", text, re.M)
    return {"position": values[:3], "target": values[3:], "size": [int(v) for v in shape.groups()],
            "own_camera": "\ncamera      '" in text, "sky": "a constant sky" in text,
            "warnings": text.count("\nwarning ")}


def box_around(center, half):
    """The six sides of a box as a glTF buffer of four corners and two triangles each, seen from inside."""
    corners, triangles = [], []
    for side in range(6):
        axis, sign = side // 2, 2 * (side % 2) - 1
        for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            corner = [0.0, 0.0, 0.0]
            corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3] = sign, u, v
            corners.append([c + half * x for c, x in zip(center, corner)])
        triangles.append((0, 2, 1, 0, 3, 2) if sign > 0 else (0, 1, 2, 0, 2, 3))
    return corners, triangles


def part_pictures(node, gltf, folder, parted):
    """Blender gives a picture one encoding for all its uses: those that are no colours get a copy."""
    for key, value in node.items() if isinstance(node, dict) else ():
        if isinstance(value, dict) and "index" in value and key.endswith("Texture") and key not in COLORS:
            texture = gltf["textures"][value["index"]]
            image = gltf["images"][texture.get("source", 0)]
            if "uri" in image and not image["uri"].startswith("data:"):
                if value["index"] not in parted:
                    copy = "numbers-" + image["uri"]
                    shutil.copy(os.path.join(folder, image["uri"]), os.path.join(folder, copy))
                    gltf["images"].append({"uri": copy})
                    gltf["textures"].append({**texture, "source": len(gltf["images"]) - 1})
                    parted[value["index"]] = len(gltf["textures"]) - 1
                value["index"] = parted[value["index"]]
        else:
            part_pictures(value, gltf, folder, parted)


def with_light(path, folder, center, half):
    """A copy of a .gltf file with a box that shines in it around the scene."""
    shutil.copytree(os.path.dirname(path), folder, dirs_exist_ok=True)
    with open(path, encoding="utf-8") as file:
        gltf = json.load(file)
    bare = [p for mesh in gltf["meshes"] for p in mesh["primitives"] if "material" not in p]
    if bare:
        gltf.setdefault("materials", []).append({})
    for primitive in bare:
        primitive["material"] = len(gltf["materials"]) - 1
    parted = {}
    for material in gltf.get("materials", []):
        part_pictures(material, gltf, folder, parted)
    corners, triangles = box_around(center, half)
    data = b"".join(struct.pack("<3f", *c) for c in corners)
    data += b"".join(struct.pack("<6H", *t) for t in triangles)
    lists = {name: gltf.setdefault(name, []) for name in
             ("buffers", "bufferViews", "accessors", "materials", "meshes", "nodes")}
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    lists["buffers"].append({"uri": uri, "byteLength": len(data)})
    view = len(lists["bufferViews"])
    buffer = len(lists["buffers"]) - 1
    lists["bufferViews"] += [{"buffer": buffer, "byteLength": 288},
                             {"buffer": buffer, "byteOffset": 288, "byteLength": 72}]
    gltf["extensionsUsed"] = sorted({*gltf.get("extensionsUsed", []), "KHR_materials_emissive_strength",
                                     "KHR_materials_specular"})
    roots = gltf["scenes"][gltf.get("scene", 0)]["nodes"]
    for side, radiance in enumerate(SIDES):
        four = corners[4 * side:4 * side + 4]
        first = len(lists["accessors"])
        lists["accessors"] += [
            {"bufferView": view, "byteOffset": 48 * side, "componentType": 5126, "count": 4,
             "type": "VEC3", "min": [min(c[i] for c in four) for i in range(3)],
             "max": [max(c[i] for c in four) for i in range(3)]},
            {"bufferView": view + 1, "byteOffset": 12 * side, "componentType": 5123, "count": 6,
             "type": "SCALAR"}]
        strength = max(radiance)
        lists["materials"].append({
            "name": f"side {side}", "emissiveFactor": [r / strength for r in radiance],
            "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0},
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength},
                           "KHR_materials_specular": {"specularFactor": 0}}})
        lists["meshes"].append({"primitives": [{"attributes": {"POSITION": first}, "indices": first + 1,
                                                "material": len(lists["materials"]) - 1}]})
        roots.append(len(lists["nodes"]))
        lists["nodes"].append({"mesh": len(lists["meshes"]) - 1})
    out = os.path.join(folder, os.path.basename(path))
    with open(out, "w", encoding="utf-8") as file:
        json.dump(gltf, file)
    return out


def as_specified(material, node):
    """What glTF says and Blender's importer leaves out."""
    node.distribution = os.environ.get("FACETS", "GGX")  # appendix B: one bounce between facets
    strength = node.inputs["Emission Strength"]
    if material.use_backface_culling and (strength.is_linked or strength.default_value > 0):
        tree = material.node_tree  # emission from the front alone
        front = tree.nodes.new("ShaderNodeMath")
        front.operation = "MULTIPLY_ADD"  # strength - backfacing * strength
        geometry = tree.nodes.new("ShaderNodeNewGeometry")
        tree.links.new(geometry.outputs["Backfacing"], front.inputs[0])
        front.inputs[1].default_value = -strength.default_value
        front.inputs[2].default_value = strength.default_value
        tree.links.new(front.outputs[0], strength)


def add_film(node, film):
    """KHR_materials_iridescence, which Blender's importer leaves out: films without a map, over all."""
    node.inputs["Thin Film Thickness"].default_value = film.get("iridescenceThicknessMaximum", 400)
    node.inputs["Thin Film IOR"].default_value = film.get("iridescenceIor", 1.3)


def add_diffuse_transmission(tree, node, through):
    """KHR_materials_diffuse_transmission likewise: the share of the diffuse part that a translucent one takes."""
    share = through.get("diffuseTransmissionFactor", 0)
    back, mix = tree.nodes.new("ShaderNodeBsdfPrincipled"), tree.nodes.new("ShaderNodeMixShader")
    for socket in node.inputs:
        if socket.name in back.inputs and not socket.is_linked:
            back.inputs[socket.name].default_value = socket.default_value
    back.distribution = node.distribution
    back.inputs["Base Color"].default_value = (0, 0, 0, 1)
    translucent, both = tree.nodes.new("ShaderNodeBsdfTranslucent"), tree.nodes.new("ShaderNodeAddShader")
    translucent.inputs["Color"].default_value = (*through.get("diffuseTransmissionColorFactor", (1, 1, 1)), 1)
    tree.links.new(back.outputs[0], both.inputs[0])
    tree.links.new(translucent.outputs[0], both.inputs[1])
    mix.inputs[0].default_value = share
    tree.links.new(node.outputs[0], mix.inputs[1])
    tree.links.new(both.outputs[0], mix.inputs[2])
    output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    tree.links.new(mix.outputs[0], output.inputs["Surface"])


def add_extensions(path):
    """Of a .gltf file's materials, by name."""
    if not path.endswith(".gltf"):
        return
    with open(path, encoding="utf-8") as file:
        materials = json.load(file).get("materials", [])
    for said in materials:
        material = bpy.data.materials.get(said.get("name", ""))
        if not material or not material.use_nodes:
            continue
        node = next((n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED"), None)
        extensions = said.get("extensions", {})
        if node and "KHR_materials_iridescence" in extensions:
            add_film(node, extensions["KHR_materials_iridescence"])
        if node and "KHR_materials_diffuse_transmission" in extensions:
            add_diffuse_transmission(material.node_tree, node, extensions["KHR_materials_diffuse_transmission"])


def give_default_material():
    """Where the file names none: glTF's is white, rough metal."""
    for mesh in bpy.data.meshes:
        if any(slot for slot in mesh.materials):
            continue
        material = bpy.data.materials.new("default")
        material.use_nodes = True
        tree = material.node_tree
        inputs = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED").inputs
        inputs["Base Color"].default_value = (1, 1, 1, 1)
        inputs["Metallic"].default_value = inputs["Roughness"].default_value = 1
        mesh.materials.clear()
        mesh.materials.append(material)


def absorb_as_specified(node):
    """glTF's colour is what a distance leaves; Cycles absorbs density times what the colour lacks."""
    color, density = node.inputs["Color"].default_value, node.inputs["Density"].default_value
    lost = [-math.log(max(c, 1e-6)) * density for c in color[:3]]
    most = max(*lost, 1e-9)
    node.inputs["Density"].default_value = most
    node.inputs["Color"].default_value = (*(1 - one / most for one in lost), 1)


def blender_scene(path, seen, wide, high, spp):
    """The file as Blender's importer reads it, lights in glTF's units, set up as qray traces paths."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path, export_import_convert_lighting_mode="COMPAT")
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("black")
    scene.world.color = (0, 0, 0)
    scene.camera = next((o for o in scene.objects if o.type == "CAMERA"), None)
    if not seen["own_camera"]:
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(camera)
        place, target = (mathutils.Vector((x, -z, y)) for x, y, z in (seen["position"], seen["target"]))
        camera.location = place
        camera.rotation_euler = (target - place).to_track_quat("-Z", "Y").to_euler()
        camera.data.angle = math.radians(FOV)
        scene.camera = camera
    scene.camera.data.clip_start, scene.camera.data.clip_end = 1e-3, 1e6
    give_default_material()
    for material in bpy.data.materials:
        for node in list(material.node_tree.nodes) if material.use_nodes else ():
            if node.type == "BSDF_PRINCIPLED":
                as_specified(material, node)
            elif node.type == "VOLUME_ABSORPTION":
                absorb_as_specified(node)
    add_extensions(path)
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = wide, high, 100
    render.threads_mode, render.threads = "FIXED", 2
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.view_settings.view_transform = "Raw"
    cycles.device, cycles.samples = "CPU", spp
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 15
    cycles.transparent_max_bounces = 64
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.light_sampling_threshold = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.pixel_filter_type = "BOX"
    return scene


def read(path):
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    pixels = numpy.empty(len(image.pixels), numpy.float32)
    image.pixels.foreach_get(pixels)
    shape = (image.size[1], image.size[0], image.channels)
    bpy.data.images.remove(image)
    return pixels.reshape(shape)[:, :, :3]


def write(path, pixels):
    image = bpy.data.images.new("mean", pixels.shape[1], pixels.shape[0], float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    whole = numpy.ones((*pixels.shape[:2], 4), numpy.float32)
    whole[:, :, :3] = pixels
    image.pixels.foreach_set(whole.ravel())
    image.filepath_raw, image.file_format = path, "OPEN_EXR"
    image.save()
    bpy.data.images.remove(image)


def compare(qray, folder, size, spp, runs, path):
    name = os.path.splitext(os.path.basename(path))[0]
    seen = check(qray, path)
    wide, high = (max(1, round(side * size / max(seen["size"]))) for side in seen["size"])
    view = []
    if not seen["own_camera"]:
        view = [f"--camera-{what}=" + ",".join(map(str, seen[what])) for what in ("position", "target")]
        view.append(f"--camera-vertical-fov-deg={FOV}")
    if seen["sky"]:
        half = 4 * math.dist(seen["position"], seen["target"])
        path = with_light(path, os.path.join(folder, name), seen["target"], half)
    ours, theirs = [], []
    for run in range(runs):
        out = os.path.join(folder, "run.exr")
        subprocess.run([qray, "render", path, "--size", f"{wide}x{high}", "--spp", str(spp), "--seed",
                        str(run + 1), "--method", "none", "-q", "-o", out, *view],
                       check=True, stderr=subprocess.DEVNULL)
        ours.append(read(out))
    scene = blender_scene(path, seen, wide, high, spp)
    scene.render.filepath = os.path.join(folder, "run.exr")
    for run in range(runs):
        scene.cycles.seed = run
        bpy.ops.render.render(write_still=True)
        theirs.append(read(scene.render.filepath))
    pictures = []
    for renderer, images in (("qray", ours), ("cycles", theirs)):
        pictures.append(os.path.join(folder, f"{name}-{renderer}.exr"))
        write(pictures[-1], numpy.mean(images, axis=0))
    flip = json.loads(subprocess.run([qray, "diff", *pictures, "--json"], check=True,
                                     capture_output=True).stdout)["flip"]
    ratio, z, off = difference(ours, theirs)
    return f"| {name} | {ratio} | {flip:.4f} | {z} | {off} | {seen['warnings']} |"


def main():
    qray, folder, size, spp, runs, *paths = sys.argv[1:]
    rows = ["| file | mean, qray over Cycles | FLIP | z of 16 regions: median, greatest "
            "| regions' means off by | warnings |", "|---|---|--:|--:|--:|--:|"]
    # Blender writes its progress to stdout too.
    table = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.path.join(folder, "blender.log"), os.O_WRONLY | os.O_CREAT), 1)
    for row in rows:
        print(row, file=table, flush=True)
    for path in paths:
        try:
            row = compare(qray, folder, int(size), int(spp), int(runs), os.path.abspath(path))
        except (RuntimeError, subprocess.CalledProcessError) as error:
            row = f"| {path} | not compared: {str(error).splitlines()[0]} | | | | |"
        print(row, file=table, flush=True)


if __name__ == "__main__":
    main()
