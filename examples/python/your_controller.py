# SPDX-License-Identifier: Apache-2.0
"""A controller of your own: the hand as a spring that keeps a box at its place, in one loop and in real time.

Pushed with a force F, a spring of stiffness K gives way by F / K: the picture shows how near the box comes to it.
"""
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import thenar
from thenar.palette import FINGERS

STIFFNESS = np.array([300.0, 300.0, 300.0, 0.5, 0.5, 0.5])  # [N/m], then [N m/rad]
SQUEEZE_N, PUSH_N = 1.5, 0.5


def impedance(p: thenar.Period) -> NDArray[np.float64]:
    """Joint torques of one control period; thenar.Period says what is known in it."""
    wrench = STIFFNESS * p.error - p.weight  # on the object: a spring to its target, and what bears its weight
    arms = p.point_m - p.object[:3, 3]
    grasp_map = np.hstack([np.vstack([np.eye(3), np.cross(arm, np.eye(3)).T]) for arm in arms])  # forces to wrench
    squeeze = SQUEEZE_N * p.normal.ravel()
    forces = squeeze + np.linalg.pinv(grasp_map) @ (wrench - grasp_map @ squeeze)
    torques = p.gravity_Nm  # which bear the hand itself
    for finger, force in enumerate(forces.reshape(-1, 3)):
        torques = torques + p.jacobian(finger).T @ force
    return torques


scene = thenar.Scene("box_grasp", {"time.control_period": "5 ms", "control.muscles": False, "task": {}})
times_s = np.arange(1, 125) * 0.02
pushes_N = [PUSH_N * (0.5 <= t < 1.5) for t in times_s]

simulation = thenar.Simulation(scene, torques=impedance)
aside = np.append(simulation.object[:3, 1], [0.0, 0.0, 0.0])
one_loop, real_time = [], []
for t, push_N in zip(times_s, pushes_N):  # as fast as it goes
    simulation.run(until=t)
    one_loop.append(1e3 * simulation.position_m[1])
    simulation.input_wrench = push_N * aside
with thenar.Realtime(scene, torques=impedance) as run:  # two threads: contacts at 1 kHz, the law at 200 Hz
    for t, push_N in zip(times_s, pushes_N):
        while run.state()["time_s"] < t and not run.wait(0.002):
            pass
        real_time.append(1e3 * run.state()["position_m"][1])
        run.input(push_N * aside)
    run.wait()
print(f"in one loop {simulation.report['outcome']}, in real time {run.report['outcome']}")
print(f"gave way by {max(one_loop):.2f} mm; F / K is {1e3 * PUSH_N / STIFFNESS[0]:.2f} mm")

figure, axes = plt.subplots(figsize=(8, 4.2), layout="constrained")
axes.axvspan(0.5, 1.5, color="#f0f0f0", label=f"pushed with {PUSH_N} N")
axes.axhline(1e3 * PUSH_N / STIFFNESS[0], color="black", linestyle="--", linewidth=1, label="F / K")
axes.plot(times_s, one_loop, color=FINGERS[0], linewidth=3, label="one loop")
axes.plot(times_s, real_time, color=FINGERS[1], linewidth=1, label="real time, the law at 200 Hz")
axes.set(xlabel="time [s]", ylabel="box, aside [mm]")
axes.legend(frameon=False)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png"), dpi=110)
