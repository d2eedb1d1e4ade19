# SPDX-License-Identifier: Apache-2.0
"""A first grasp: three fingertips hold a box and carry it 20 mm sideways. Draws its path and how far it is off."""
import sys
from pathlib import Path

import matplotlib.pyplot as plt

import thenar
from thenar.palette import SIGNALS

run = thenar.run(thenar.Scene("box_grasp"))
print(f"{run.outcome}; the largest slip of a finger is {run.summary['grasp']['max_slip_mm']:.3f} mm")
figure, (path, off) = plt.subplots(2, 1, sharex=True, figsize=(9, 5), layout="constrained")
for axis in "xyz":
    position, target = run.signals[f"position_{axis}_mm"], run.signals[f"target_{axis}_mm"]
    path.plot(run.signals["time_s"], position, color=SIGNALS[axis], label=axis)
    path.plot(run.signals["time_s"], target, "k--", linewidth=1, label="target" if axis == "z" else None)
    off.plot(run.signals["time_s"], position - target, color=SIGNALS[axis])
path.set_ylabel("displacement [mm]")
path.legend(loc="upper left")
off.set(xlabel="time [s]", ylabel="off the target [mm]")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png"))
