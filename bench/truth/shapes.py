# SPDX-License-Identifier: Apache-2.0
"""Worlds whose object is a mesh or a scan of the same solid: files beside the world, which only some engines read."""

import math

import worlds


def _mesh(path, points, faces):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points]
    path.write_text("\n".join(lines + ["f " + " ".join(str(i + 1) for i in face) for face in faces]) + "\n")


def box_mesh(path, half):
    """A box of quadrilaterals, seen from outside counter-clockwise."""
    points = [(x, y, z) for x in (-half[0], half[0]) for y in (-half[1], half[1]) for z in (-half[2], half[2])]
    _mesh(path, points, [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])


def ball_mesh(path, radius, around=128):
    """A ball of triangles between circles of latitude, turned so that no finger is at a pole."""
    rows = around // 2
    ring = lambda i, j: 1 + (i - 1) * around + j % around
    points = [(0.0, 0.0, radius)]
    for i in range(1, rows):
        height, across = radius * math.cos(math.pi * i / rows), radius * math.sin(math.pi * i / rows)
        points += [(across * math.cos(2 * math.pi * j / around), across * math.sin(2 * math.pi * j / around), height) for j in range(around)]
    points.append((0.0, 0.0, -radius))
    faces = [(0, ring(1, j), ring(1, j + 1)) for j in range(around)]
    for i in range(1, rows - 1):
        for j in range(around):
            faces += [(ring(i, j), ring(i + 1, j), ring(i + 1, j + 1)), (ring(i, j), ring(i + 1, j + 1), ring(i, j + 1))]
    faces += [(len(points) - 1, ring(rows - 1, j + 1), ring(rows - 1, j)) for j in range(around)]
    _mesh(path, points, faces)


def scanned_ball(path, radius, points=12000):
    """Points all over a ball with their normals, on a spiral of equal areas."""
    rows = []
    for i in range(points):
        z = 1 - (2 * i + 1) / points
        across, angle = math.sqrt(1 - z * z), i * math.pi * (3 - math.sqrt(5))
        n = (across * math.cos(angle), across * math.sin(angle), z)
        rows.append(" ".join(repr(v) for v in (*(radius * c for c in n), *n)))
    path.write_text("\n".join(rows) + "\n")


MADE = {"mesh box": ("box", "box.obj", lambda path, shape: box_mesh(path, shape["box"])),
        "mesh ball": ("ball", "ball.obj", lambda path, shape: ball_mesh(path, shape["sphere"])),
        "scanned ball": ("ball", "ball.xyz", lambda path, shape: scanned_ball(path, shape["sphere"]))}


def world(name, folder, **changes):
    """A world by its file's name, or one of those above, whose shape becomes a file in the folder."""
    if name not in MADE:
        return worlds.world(name, **changes)
    of, file, make = MADE[name]
    made = worlds.world(of, **changes)
    if not (folder / file).exists():
        make(folder / file, made["shape"])
    made["shape"] = {"file": file}
    return made
