# SPDX-License-Identifier: Apache-2.0
"""An object of your own: a mesh of an egg is written, a grasp of it is found, and the hand lifts it by 10 mm."""
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import thenar
from thenar.palette import FINGERS

# An egg, turned about z. Any closed mesh will do (.obj, .stl, .off), or a scan (.ply).
around, along = 60, 40
turns, heights = np.linspace(0.0, 2.0 * np.pi, around + 1), np.linspace(0.02, np.pi - 0.02, along)
angle, up = np.meshgrid(turns, heights, indexing="ij")
radius = 24.0 * np.sin(up) * (1.0 - 0.35 * np.cos(up + 2.6))
egg = np.stack([radius * np.cos(angle), radius * np.sin(angle), -38.0 * np.cos(up)], axis=-1)  # [mm]

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "egg.obj"
    with file.open("w") as mesh:
        for x, y, z in egg[:-1].reshape(-1, 3):
            mesh.write(f"v {x:.4f} {y:.4f} {z:.4f}\n")
        for i in range(around):
            a, b = along * i + 1, along * ((i + 1) % around) + 1
            for j in range(along - 1):
                mesh.write(f"f {a + j} {b + j} {b + j + 1} {a + j + 1}\n")
    scene = thenar.new_scene(Path(folder) / "egg.yaml", file, unit="1 mm", mass="80 g")
    scene = scene.set({"task.translate": {"by": ["0 mm", "0 mm", "10 mm"], "from": "0.4 s", "over": "0.8 s"}})
    grasp = thenar.grasp(scene)[0]
    run = thenar.run(grasp.scene())
print(grasp)
print(f"lifted: {run.outcome}")

space = plt.figure(figsize=(6, 6), layout="constrained").add_subplot(projection="3d")
space.plot_surface(*np.moveaxis(egg, -1, 0), color="#e3d3a8", linewidth=0, alpha=0.6)
points, forces = 1e3 * grasp.points_m, grasp.force_N @ grasp.object[:3, :3]  # in the object's axes
for finger, point, normal, force, colour in zip(
        grasp.fingers, points, grasp.normals, forces, FINGERS):
    space.quiver(*point, *(15.0 * force), pivot="tip", color=colour, linewidth=3)
    space.text(*(point + 50.0 * normal), finger, color=colour, ha="center")
space.view_init(azim=90.0 + np.degrees(np.arctan2(points[0, 1], points[0, 0])))  # from beside the grip
space.set_title(f"the grasp that was found; lifted, it was {run.outcome}")
space.set_aspect("equal")
space.set_axis_off()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png"), dpi=110)
