"""Small scenes, one for each Mitsuba 3 plugin or parameter, drawn by Mitsuba 3 and by qray: called by
plugins.sh. Prints how far the means are apart, in percent and in standard errors."""

import os
import subprocess
import sys

import mitsuba
import numpy

from pictures import read
from regions import regions

WIDE, HIGH, SPP = 64, 48, 64


def tag(kind, name, value):
    return f'<{kind} name="{name}" value="{value}"/>'


def rgb(name, *value):
    return tag("rgb", name, ", ".join(str(v) for v in value))


def bsdf(kind, inside=""):
    return f'<bsdf type="{kind}">{inside}</bsdf>'


def shape(kind, inside="", to_world=""):
    place = f'<transform name="to_world">{to_world}</transform>' if to_world else ""
    return f'<shape type="{kind}">{place}{inside}</shape>'


def texture(name, kind, inside=""):
    return f'<texture name="{name}" type="{kind}">{inside}</texture>'


def bitmap(name, inside="", file="picture.png"):
    return texture(name, "bitmap", tag("string", "filename", file) + inside)


def transform(name, inside):
    return f'<transform name="{name}">{inside}</transform>'


RED = bsdf("diffuse", rgb("reflectance", .7, .2, .1))
LOOK = '<lookat origin="0, 2, 6" target="0, .8, 0" up="0, 1, 0"/>'
FLOOR = shape("rectangle", bsdf("twosided", bsdf("diffuse", texture("reflectance", "checkerboard",
              rgb("color0", .6, .5, .4) + rgb("color1", .1, .2, .3)
              + transform("to_uv", '<scale x="4" y="4"/>')))),
              '<rotate x="1" angle="-90"/><scale value="4"/>')
LAMP = shape("rectangle", '<emitter type="area">' + rgb("radiance", 8, 7, 6) + "</emitter>",
             '<rotate x="1" angle="90"/><translate x="-1" y="4" z="1"/>')
SKY = '<emitter type="constant">' + rgb("radiance", .3, .4, .5) + "</emitter>"
SENSOR = tag("float", "fov", 40)
BALL = '<translate y="1"/>'


def scene(things, light=LAMP + SKY, sensor="perspective", lens=SENSOR, film="", floor=FLOOR,
          look=LOOK, integrator=""):
    return f"""<scene version="3.0.0"><integrator type="path">{tag("integer", "max_depth", 12)}
{integrator}</integrator><sensor type="{sensor}">{lens}{transform("to_world", look)}
<sampler type="independent">{tag("integer", "sample_count", SPP)}</sampler>
<film type="hdrfilm">{tag("integer", "width", WIDE)}{tag("integer", "height", HIGH)}{film}
<rfilter type="box"/></film></sensor>{light}{floor}{things}</scene>"""


def ball(material):
    return scene(shape("sphere", material, BALL))


def pane(material):
    """Seen through and against, unlike a ball: an open surface."""
    return scene(shape("rectangle", material, '<scale value=".9"/>' + BALL))


def cases():
    number = lambda name, value: tag("float", name, value)
    text = lambda name, value: tag("string", name, value)
    turned = transform("to_uv", '<scale x="2" y="3"/><rotate z="1" angle="30"/>'
                       '<translate x=".2" y=".1"/>')
    yield "diffuse", ball(RED)
    for kind in ("ggx", "beckmann"):
        yield f"roughdielectric, {kind}", ball(bsdf("roughdielectric", text("distribution", kind)
                                                    + number("alpha", .2)))
        yield f"roughconductor, {kind}", ball(bsdf("roughconductor", text("distribution", kind)
                                                   + text("material", "Au") + number("alpha", .2)))
    yield "roughconductor, alpha_u and alpha_v", ball(bsdf(
        "roughconductor", text("material", "Al") + number("alpha_u", .3) + number("alpha_v", .05)))
    yield "dielectric", ball(bsdf("dielectric", text("int_ior", "diamond")))
    yield "dielectric, coloured", ball(bsdf("dielectric", rgb("specular_transmittance", .9, .5, .2)
                                            + rgb("specular_reflectance", .2, .5, 1)))
    yield "thindielectric", pane(bsdf("thindielectric", text("int_ior", "bk7")))
    for metal in ("Cu", "Ag", "W", "Cr", "none"):
        yield f"conductor, {metal}", ball(bsdf("conductor", text("material", metal)))
    yield "conductor, eta and k", ball(bsdf("conductor", rgb("eta", 1.2, .8, .4)
                                            + rgb("k", 3, 2, 1)))
    yield "plastic", ball(bsdf("plastic", rgb("diffuse_reflectance", .1, .3, .6)))
    yield "plastic, nonlinear", ball(bsdf("plastic", rgb("diffuse_reflectance", .1, .5, .9)
                                          + tag("boolean", "nonlinear", "true")))
    yield "roughplastic", ball(bsdf("roughplastic", rgb("diffuse_reflectance", .1, .3, .6)
                                    + number("alpha", .1)))
    base = rgb("base_color", .7, .4, .2)
    for name, value in (("roughness", .3), ("metallic", .8), ("spec_trans", .8), ("clearcoat", 1),
                        ("sheen", 1), ("anisotropic", .8), ("flatness", 1), ("spec_tint", 1),
                        ("specular", .9), ("eta", 1.8)):
        yield f"principled, {name}", ball(bsdf("principled", base + number(name, value)))
    yield "principledthin", pane(bsdf("principledthin", base + number("diff_trans", .8)
                                      + number("spec_trans", .3)))
    yield "bumpmap", ball(bsdf("bumpmap", bitmap("height", tag("boolean", "raw", "true"))
                               + number("scale", .3) + bsdf("roughplastic")))
    yield "normalmap", ball(bsdf("normalmap", bitmap("normalmap", tag("boolean", "raw", "true"),
                                                     "normals.png") + RED))
    yield "blendbsdf", ball(bsdf("blendbsdf", bitmap("weight") + RED
                                 + bsdf("conductor", text("material", "Cu"))))
    yield "mask", ball(bsdf("mask", number("opacity", .3) + bsdf("twosided", RED)))
    yield "mask, picture", ball(bsdf("mask", bitmap("opacity") + bsdf("twosided", RED)))
    yield "twosided, two", pane(bsdf("twosided", RED + bsdf("plastic")))
    yield "one-sided", scene(shape("rectangle", RED, '<rotate y="1" angle="180"/>' + BALL))
    yield "null", ball(bsdf("null"))
    for wrap in ("repeat", "clamp", "mirror"):
        yield f"bitmap, {wrap}", ball(bsdf("diffuse", bitmap(
            "reflectance", text("wrap_mode", wrap) + turned)))
    yield "bitmap, nearest", ball(bsdf("diffuse", bitmap("reflectance",
                                                         text("filter_type", "nearest"))))
    yield "bitmap, raw", ball(bsdf("diffuse", bitmap("reflectance", tag("boolean", "raw", "true"))))
    yield "bitmap, one channel", ball(bsdf("diffuse", bitmap("reflectance", file="grey.png")))
    yield "checkerboard, turned", ball(bsdf("diffuse", texture("reflectance", "checkerboard",
                                                               turned)))
    thing = shape("sphere", RED, BALL)
    yield "point", scene(thing, '<emitter type="point"><point name="position" x="1" y="3" z="2"/>'
                         + rgb("intensity", 20, 15, 10) + "</emitter>")
    aim = transform("to_world", '<lookat origin="2, 4, 3" target="0, 0, 0" up="0, 1, 0"/>')
    spot = rgb("intensity", 40, 30, 20) + number("cutoff_angle", 25)
    yield "spot", scene(thing, f'<emitter type="spot">{aim}{spot}</emitter>')
    yield "spot, beam_width", scene(
        thing, f'<emitter type="spot">{aim}{spot}{number("beam_width", 5)}</emitter>')
    yield "directional", scene(thing, f'<emitter type="directional">{aim}'
                               + rgb("irradiance", 3, 2, 1) + "</emitter>")
    turn = transform("to_world", '<rotate y="1" angle="70"/><rotate x="1" angle="20"/>')
    yield "envmap, turned and scaled", scene(
        thing, f'<emitter type="envmap">{text("filename", "sky.exr")}{number("scale", 2)}{turn}'
        "</emitter>")
    yield "sunsky", scene(thing, '<emitter type="sunsky">' + number("turbidity", 4) + transform(
        "to_world", '<rotate x="1" angle="-90"/>')
        + '<vector name="sun_direction" x=".3" y=".6" z=".5"/></emitter>')
    yield "projector", scene(thing, f'<emitter type="projector">{aim}{number("fov", 30)}'
                             f'{bitmap("irradiance")}{number("scale", 30)}</emitter>')
    yield "area, picture", scene(thing, shape("rectangle", '<emitter type="area">' + bitmap(
        "radiance", file="sky.exr") + "</emitter>", '<translate z="-2" y="2"/>'))
    for axis in ("x", "y", "diagonal", "smaller", "larger"):
        yield f"fov_axis {axis}", scene(thing, lens=SENSOR + text("fov_axis", axis))
    yield "focal_length", scene(thing, lens=text("focal_length", "50mm"))
    yield "principal_point_offset", scene(thing, lens=SENSOR
                                          + number("principal_point_offset_x", .15)
                                          + number("principal_point_offset_y", -.1))
    yield "crop", scene(thing, film="".join(tag("integer", "crop_" + name, value) for name, value in (
        ("width", 24), ("height", 20), ("offset_x", 30), ("offset_y", 4))))
    yield "near_clip", scene(thing, lens=SENSOR + number("near_clip", 5.5))
    yield "thinlens", scene(thing, sensor="thinlens", lens=SENSOR + number("aperture_radius", .2)
                            + number("focus_distance", 4))
    yield "orthographic", scene(thing, sensor="orthographic", lens="",
                                look='<scale x="2" y="2"/>' + LOOK)
    yield "hide_emitters", scene(thing, integrator=tag("boolean", "hide_emitters", "true"))
    small = '<scale value=".8"/>'
    yield "cube", scene(shape("cube", RED, small + '<rotate y="1" angle="30"/>' + BALL))
    yield "disk", scene(shape("disk", bsdf("twosided", RED), small + BALL))
    cylinder = ('<point name="p0" x="-.5" y=".5" z="0"/><point name="p1" x=".6" y="1.5" z=".2"/>'
                + number("radius", .4))
    yield "cylinder", scene(shape("cylinder", bsdf("twosided", RED) + cylinder))
    yield "cylinder, flipped", scene(shape("cylinder", RED + cylinder
                                           + tag("boolean", "flip_normals", "true")))
    yield "ply, face_normals", scene(shape("ply", RED + text("filename", "mesh.ply")
                                           + tag("boolean", "face_normals", "true"), BALL))
    yield "ply, smooth", scene(shape("ply", RED + text("filename", "mesh.ply"), BALL))
    yield "ply, vertex colours", scene(shape("ply", bsdf("diffuse", texture(
        "reflectance", "mesh_attribute", text("name", "vertex_color")))
        + text("filename", "mesh.ply"), BALL))
    yield "obj", scene(shape("obj", bsdf("diffuse", bitmap("reflectance"))
                             + text("filename", "mesh.obj"), BALL))
    group = '<shape type="shapegroup" id="g">' + shape("sphere", RED) + shape(
        "cube", bsdf("plastic"), '<scale value=".4"/><translate x="1"/>') + "</shape>"
    put = lambda where: f'<shape type="instance"><ref id="g"/>{transform("to_world", where)}</shape>'
    yield "shapegroup, instance", scene(group + put('<scale value=".5"/>' + BALL) + put(
        '<scale x=".4" y=".6" z=".5"/><rotate y="1" angle="60"/><translate x="1.2" y=".6"/>'))
    yield "flip_normals, sphere", scene(shape("sphere", RED + tag("boolean", "flip_normals", "true"),
                                              BALL))


def write_files(folder):
    """Pictures and meshes that the scenes name."""
    random = numpy.random.default_rng(1)
    def write(name, values, kind):
        bitmap = mitsuba.Bitmap(numpy.ascontiguousarray(values))
        bitmap.convert(component_format=kind, srgb_gamma=False).write(os.path.join(folder, name))
    eight = mitsuba.Struct.Type.UInt8
    y, x = numpy.mgrid[0:24, 0:32].astype(numpy.float32)
    wave = .5 + .5 * numpy.sin(x / 32 * 12.566) * numpy.cos(y / 24 * 6.283)
    picture = numpy.stack([wave, .2 + .5 * y / 24, random.random(wave.shape)], axis=2)
    write("picture.png", picture.astype(numpy.float32), eight)
    write("grey.png", wave[:, :, None].astype(numpy.float32), eight)
    normal = numpy.stack([.5 + .2 * numpy.sin(x), .5 + .2 * numpy.cos(y), .9 + 0 * x], axis=2)
    write("normals.png", normal.astype(numpy.float32), eight)
    sky = numpy.stack([.2 + 3 * wave ** 4, .3 + 2 * wave ** 4, .2 + y / 24], axis=2)
    # Mitsuba stretches an environment's outer rows to the poles, which shows in small pictures.
    sky = numpy.kron(sky.astype(numpy.float32), numpy.ones((16, 16, 1), numpy.float32))
    write("sky.exr", sky, mitsuba.Struct.Type.Float32)
    # A bent sheet of triangles with uvs, in a .ply with vertex colours and in an .obj.
    side = 9
    points = [(u, v) for v in numpy.linspace(0, 1, side) for u in numpy.linspace(0, 1, side)]
    where = lambda u, v: (2 * u - 1, 1.6 * v - .8, .4 * numpy.sin(5 * u) * numpy.cos(4 * v))
    faces = [(i + j * side, i + 1 + j * side, i + 1 + (j + 1) * side, i + (j + 1) * side)
             for j in range(side - 1) for i in range(side - 1)]
    with open(os.path.join(folder, "mesh.ply"), "w", encoding="utf-8") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n" + "".join(
            f"property float {name}\n" for name in ("x", "y", "z", "u", "v", "r", "g", "b"))
            + f"element face {len(faces) * 2}\nproperty list uchar int vertex_indices\nend_header\n")
        for u, v in points:
            file.write(" ".join(f"{n:.6f}" for n in (*where(u, v), u, v, u, v, .5)) + "\n")
        for a, b, c, d in faces:
            file.write(f"3 {a} {b} {c}\n3 {a} {c} {d}\n")
    with open(os.path.join(folder, "mesh.obj"), "w", encoding="utf-8") as file:
        for u, v in points:
            file.write("v %.6f %.6f %.6f\n" % where(u, v) + f"vt {u:.6f} {v:.6f}\n")
        for a, b, c, d in faces:
            for corners in ((a, b, c), (a, c, d)):
                file.write("f " + " ".join(f"{i + 1}/{i + 1}" for i in corners) + "\n")


def compare(qray, folder, name, text, runs):
    path, out = os.path.join(folder, "scene.xml"), os.path.join(folder, "out.exr")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    theirs, ours, said = [], [], ""
    scene_read = mitsuba.load_file(path)
    for run in range(runs):
        picture = numpy.array(mitsuba.render(scene_read, spp=SPP, seed=run))[:, :, :3]
        theirs.append(picture)
        done = subprocess.run([qray, "render", path, "--spp", str(SPP), "--method", "none",
                               "--seed", str(run + 1), "-q", "-o", out], capture_output=True,
                              text=True, check=False)
        said = done.stderr.strip()
        if done.returncode != 0:
            raise RuntimeError("qray: " + said)
        ours.append(read(out))
        if ours[-1].shape != picture.shape:
            raise RuntimeError(f"qray's picture is {ours[-1].shape}, Mitsuba's {picture.shape}")
    a, b = (numpy.array([regions(p) for p in pictures]) for pictures in (ours, theirs))
    ratio = a.mean(axis=(0, 1)) / b.mean(axis=(0, 1))
    whole = [numpy.array([p.mean() for p in pictures]) for pictures in (ours, theirs)]
    error = numpy.sqrt(sum(w.var(ddof=1) for w in whole) / runs)
    z = (whole[0].mean() - whole[1].mean()) / max(error, 1e-9)
    mine, other = a.mean(axis=0).sum(axis=1), b.mean(axis=0).sum(axis=1)
    lit = other > 1e-4 * other.max()
    off = mine[lit] / other[lit] - 1
    warned = said.replace(folder, "").replace("\n", "; ")
    print(f"| {name} | {ratio[0]:.3f} {ratio[1]:.3f} {ratio[2]:.3f} | {z:+.1f} "
          f"| {100 * off.min():+.1f} to {100 * off.max():+.1f} % | {warned} |", flush=True)


def main():
    qray, folder, runs = sys.argv[1], sys.argv[2], int(sys.argv[3])
    wanted = sys.argv[4:]
    write_files(folder)
    mitsuba.file_resolver().prepend(folder)
    print("| plugin, parameter | mean, qray over Mitsuba 3 | in standard errors "
          "| regions' means off by | qray's warnings |\n|---|---|--:|--:|---|")
    for name, text in cases():
        if wanted and not any(w in name for w in wanted):
            continue
        try:
            compare(qray, folder, name, text, runs)
        except RuntimeError as error:
            print(f"| {name} | not compared: {' '.join(str(error).split())} | | | |", flush=True)


main()
