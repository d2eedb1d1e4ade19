"""An object of your own: a mesh of an egg is written, a grasp of it is found, and the hand lifts it by 10 mm."""
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import thenar

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
    shape = {"cloud": {"file": file, "unit": "mm"}}
    scene = thenar.Scene("found_carry", {"object.shape": shape, "object.mass": "80 g", "grasp": {"press": "1.2 N"}})
    grasp = thenar.grasp(scene)[0]
    run = thenar.run(grasp.scene())
print(grasp)
print(f"lifted: {run.outcome}")

space = plt.figure(figsize=(6, 6), layout="constrained").add_subplot(projection="3d")
space.plot_surface(*np.moveaxis(egg, -1, 0), color="#e3d3a8", linewidth=0, alpha=0.6)
forces = grasp.force_N @ grasp.object[:3, :3]  # in the object's axes
for name, point, force, colour in zip(grasp.fingers, 1e3 * grasp.points_m, forces, ["#c0392b", "#2563a8", "#3a8f5c"]):
    space.quiver(*point, *(20.0 * force), pivot="tip", color=colour, linewidth=3)
    space.text(*(point - 32.0 * force), name, color=colour, ha="center")
space.set_title(f"the grasp that was found; lifted, it was {run.outcome}")
space.set_aspect("equal")
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png"), dpi=110)
