#!/usr/bin/env python3
"""Writes goblet.ply: a wine glass, turned on a lathe, 24 cm high, with smooth normals.

A closed surface: the profile runs from the axis below the foot up the outside, over the rim and
down the inside of the bowl to the axis. Metres, +y up.
"""

import math

# (radius, height) of the outside, from the foot's centre to the rim, in centimetres.
OUTER = [(0, 0), (3.6, 0), (3.75, 0.12), (3.6, 0.3), (2.2, 0.6), (0.9, 1.1), (0.5, 2.0), (0.42, 4.0),
         (0.42, 7.0), (0.55, 8.6), (1.2, 9.6), (2.4, 10.6), (3.4, 12.2), (4.0, 14.5), (4.15, 17.0),
         (4.0, 20.0), (3.75, 22.4), (3.6, 23.9), (3.52, 24.0)]
# The inside of the bowl, from the rim to the axis.
INNER = [(3.44, 23.9), (3.58, 22.4), (3.82, 20.0), (3.97, 17.0), (3.82, 14.5), (3.2, 12.3),
         (2.2, 10.9), (1.0, 10.2), (0, 10.05)]
SEGMENTS, STEPS = 64, 3


def smooth(points):
    """Catmull-Rom through the points, STEPS pieces each."""
    out = []
    for i in range(len(points) - 1):
        p = [points[max(0, i - 1)], points[i], points[i + 1], points[min(len(points) - 1, i + 2)]]
        for step in range(STEPS):
            t = step / STEPS
            out.append(tuple(
                0.5 * (2 * p[1][k] + (p[2][k] - p[0][k]) * t
                       + (2 * p[0][k] - 5 * p[1][k] + 4 * p[2][k] - p[3][k]) * t * t
                       + (3 * p[1][k] - p[0][k] - 3 * p[2][k] + p[3][k]) * t ** 3)
                for k in range(2)))
    return out + [points[-1]]


def main():
    # The foot's flat underside keeps its edge: it is not smoothed with the rest.
    profile = [OUTER[0]] + smooth(OUTER[1:] + INNER)
    profile = [(max(0.0, r) / 100, h / 100) for r, h in profile]
    profile[0] = (0.0, profile[0][1])
    profile[-1] = (0.0, profile[-1][1])
    rows, n = [], len(profile)
    for i, (r, h) in enumerate(profile):
        (r0, h0), (r1, h1) = profile[max(0, i - 1)], profile[min(n - 1, i + 1)]
        if i == 1:  # the underside's rim: the normal of the side above
            r0, h0 = r, h
        slope = math.hypot(h1 - h0, r1 - r0)
        nr, nh = (h1 - h0) / slope, -(r1 - r0) / slope
        if r == 0:
            nr, nh = 0.0, math.copysign(1, nh)
        for s in range(SEGMENTS):
            phi = 2 * math.pi * s / SEGMENTS
            c, d = math.cos(phi), -math.sin(phi)
            rows.append((r * c, h, r * d, nr * c, nh, nr * d))
    faces = []
    for i in range(n - 1):
        for s in range(SEGMENTS):
            a, b = i * SEGMENTS + s, i * SEGMENTS + (s + 1) % SEGMENTS
            if profile[i][0] == 0:
                faces.append((a, b + SEGMENTS, a + SEGMENTS))
            elif profile[i + 1][0] == 0:
                faces.append((a, b, a + SEGMENTS))
            else:
                faces.append((a, b, b + SEGMENTS, a + SEGMENTS))
    with open("goblet.ply", "w", encoding="ascii") as out:
        out.write(f"ply\nformat ascii 1.0\nelement vertex {len(rows)}\n")
        for name in ("x", "y", "z", "nx", "ny", "nz"):
            out.write(f"property float {name}\n")
        out.write(f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
        for row in rows:
            out.write(" ".join(f"{v:.5g}" for v in row) + "\n")
        for face in faces:
            out.write(" ".join(str(v) for v in (len(face), *face)) + "\n")


if __name__ == "__main__":
    main()
