# SPDX-License-Identifier: Apache-2.0
"""Forces in friction cones: what is planned for three fingers, and what each contact of their pulps bears."""
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import thenar
from thenar.palette import FINGERS

scene = thenar.Scene("box_grasp", {"object.points": 8000})
simulation = thenar.Simulation(scene)
simulation.run(until="900 ms")  # held, and on its way

# The least forces within cones that bear the weight, where the fingers touch; in the object's axes, z up.
R, centre_m = simulation.object[:3, :3], simulation.object[:3, 3]
points_m, normals = (simulation.centre_m - centre_m) @ R, simulation.normal @ R
frames = np.array([np.column_stack([n, np.cross([0, 0, 1], n), np.cross(n, np.cross([0, 0, 1], n))]) for n in normals])
frames /= np.linalg.norm(frames, axis=1, keepdims=True)  # columns: normal, aside, up
weight_N = 9.81 * scene.mass_kg
plan = thenar.solve.grasp(points_m, frames, [0, 0, weight_N, 0, 0, 0], friction=0.55, internal_force_N=2.0)
print(f"{plan.status}: forces of", np.linalg.norm(plan.force_N, axis=1).round(2), "N")

figure = plt.figure(figsize=(11, 5), layout="constrained")
space = figure.add_subplot(1, 2, 1, projection="3d")
space.set_title("Planned: a force a finger, in a cone of friction 0.55")
height, angle = np.meshgrid([0.0, 16.0], np.linspace(0.0, 2.0 * np.pi, 40))
for point, frame, force, colour in zip(1e3 * points_m, frames, plan.force_N, FINGERS):
    cone = np.stack([height, 0.55 * height * np.cos(angle), 0.55 * height * np.sin(angle)], axis=-1) @ frame.T
    space.plot_surface(*np.moveaxis(point + cone, -1, 0), color=colour, alpha=0.25)
    space.quiver(*point, *(8.0 * force), color=colour, linewidth=2.5)
space.bar3d(-25, -25, -25, 50, 50, 50, color="#bbbbbb", edgecolor="#999999", alpha=0.06)
space.quiver(0, 0, 0, 0, 0, -20.0 * weight_N, color="black", linewidth=2.5)
space.set_aspect("equal")
space.set_axis_off()

contacts = simulation.contacts
force_N = np.einsum("ij,ijk->ik", contacts["force_N"] @ R, frames[contacts["finger"]])  # normal, aside, up
carries = force_N[:, 0] > 1e-3
used = force_N[carries, 1:] / (scene.friction * force_N[carries, :1])
plane = figure.add_subplot(1, 2, 2)
plane.set_title("Borne: every contact's cone from above; at the rim it slides")
plane.add_patch(plt.Circle((0.0, 0.0), 1.0, fill=False))
plane.scatter(*used.T, s=400.0 * force_N[carries, 0], color=np.array(FINGERS)[contacts["finger"][carries]], alpha=0.7)
plane.set_aspect("equal")
plane.set_xlabel("tangential force / (friction x normal force), aside")
plane.set_ylabel("up")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png"), dpi=110)
