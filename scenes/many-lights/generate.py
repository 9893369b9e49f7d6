#!/usr/bin/env python3
"""Writes building.obj and building.mtl: 8 x 5 rooms joined by doorways, five small lamps in each.

Rooms are 3 x 3 m and 2.5 m high, walls 0.1 m thick. The pattern is fixed; run it here to get the
same bytes again.
"""

NX, NZ, SIZE, HEIGHT, WALL = 8, 5, 3.0, 2.5, 0.1
DOOR_WIDTH, DOOR_HEIGHT = 0.9, 2.05

MATERIALS = {  # name: (Kd, Ke)
    "wall": ((0.74, 0.72, 0.68), (0, 0, 0)),
    "wall_red": ((0.60, 0.22, 0.16), (0, 0, 0)),
    "wall_blue": ((0.20, 0.32, 0.55), (0, 0, 0)),
    "wall_green": ((0.25, 0.48, 0.22), (0, 0, 0)),
    "ceiling": ((0.8, 0.8, 0.8), (0, 0, 0)),
    "floor": ((0.45, 0.36, 0.27), (0, 0, 0)),
    "crate": ((0.55, 0.36, 0.18), (0, 0, 0)),
    "lamp_warm": ((0.5, 0.5, 0.5), (180, 126, 66)),
    "lamp_white": ((0.5, 0.5, 0.5), (140, 140, 140)),
    "lamp_cold": ((0.5, 0.5, 0.5), (75, 110, 180)),
}

vertices = []
faces = []  # (material, four indices from 1), in order


def quad(material, origin, edge1, edge2):
    """Front towards edge1 x edge2."""
    for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
        vertices.append([origin[i] + a * edge1[i] + b * edge2[i] for i in range(3)])
    n = len(vertices)
    faces.append((material, (n - 3, n - 2, n - 1, n)))


def box(material, lo, hi):
    d = [h - l for l, h in zip(lo, hi)]
    x, y, z = (d[0], 0, 0), (0, d[1], 0), (0, 0, d[2])
    for corner, e1, e2 in ((lo, y, x), (lo, x, z), (lo, z, y)):
        quad(material, corner, e1, e2)
    for axis, e1, e2 in ((2, x, y), (1, z, x), (0, y, z)):
        corner = list(lo)
        corner[axis] = hi[axis]
        quad(material, corner, e1, e2)


def wall(material, axis, at, start, door):
    """A wall of one room's length at `at` along `axis`, from `start`; `door`: its offset or None."""

    def piece(a, b, y0, y1):
        lo, hi = [0, y0, 0], [0, y1, 0]
        lo[axis], hi[axis] = at - WALL / 2, at + WALL / 2
        lo[2 - axis], hi[2 - axis] = start + a, start + b
        box(material, lo, hi)

    if door is None:
        piece(0, SIZE, 0, HEIGHT)
        return
    piece(0, door, 0, HEIGHT)
    piece(door + DOOR_WIDTH, SIZE, 0, HEIGHT)
    piece(door, door + DOOR_WIDTH, DOOR_HEIGHT, HEIGHT)


def main():
    quad("floor", (0, 0, 0), (0, 0, NZ * SIZE), (NX * SIZE, 0, 0))
    quad("ceiling", (0, HEIGHT, 0), (NX * SIZE, 0, 0), (0, 0, NZ * SIZE))
    paints = ["wall", "wall", "wall_red", "wall", "wall_blue", "wall", "wall_green"]
    for i in range(NX + 1):
        for j in range(NZ):
            outer = i in (0, NX)
            door = None if outer or (i + 2 * j) % 5 == 4 else (0.25, 1.05, 1.85)[(2 * i + j) % 3]
            if j == 2 and not outer:
                door = 1.05  # the middle row's line up: the camera looks along them
            wall(paints[(3 * i + j) % 7], 0, i * SIZE, j * SIZE, door)
    for j in range(NZ + 1):
        for i in range(NX):
            outer = j in (0, NZ)
            door = None if outer or (2 * i + j) % 4 == 3 else (1.05, 1.85, 0.25)[(i + 2 * j) % 3]
            wall(paints[(i + 5 * j) % 7], 2, j * SIZE, i * SIZE, door)
    for i in range(NX):
        for j in range(NZ):
            x, z = i * SIZE, j * SIZE
            w, h = 0.5 + 0.1 * ((i + j) % 3), 0.4 + 0.15 * ((2 * i + j) % 4)
            box("crate", (x + 0.25, 0, z + 0.3), (x + 0.25 + w, h, z + 0.3 + w))
            for k in range(5):  # 9 cm panels, 1 cm below the ceiling, facing down
                lx = x + 0.5 + 0.47 * k + 0.03 * ((i * 7 + k * 3) % 5)
                lz = z + 0.55 + 0.41 * ((i * 3 + j * 5 + k * 2) % 5)
                lamp = ("lamp_warm", "lamp_white", "lamp_cold", "lamp_warm")[(i + 3 * j) % 4]
                quad(lamp, (lx, HEIGHT - 0.01, lz), (0.09, 0, 0), (0, 0, 0.09))
    with open("building.mtl", "w", encoding="ascii") as out:
        for name, (kd, ke) in MATERIALS.items():
            out.write(f"newmtl {name}\nillum 1\nKd {kd[0]} {kd[1]} {kd[2]}\n")
            out.write(f"Ke {ke[0]} {ke[1]} {ke[2]}\n\n")
    with open("building.obj", "w", encoding="ascii") as out:
        out.write("mtllib building.mtl\n")
        for v in vertices:
            out.write("v {:.6g} {:.6g} {:.6g}\n".format(*v))
        for name in MATERIALS:
            out.write(f"g {name}\nusemtl {name}\n")
            for material, corners in faces:
                if material == name:
                    out.write("f {} {} {} {}\n".format(*corners))


if __name__ == "__main__":
    main()
