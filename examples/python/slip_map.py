# SPDX-License-Identifier: Apache-2.0
"""What a grip can bear: a box of many masses is carried with many frictions, and the map says what became of each."""
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap

import thenar
from thenar.palette import OUTCOMES

frictions = [0.15, 0.2, 0.25, 0.3, 0.4, 0.6, 0.8]
masses_g = [50, 100, 150, 200, 300, 400]
scene = thenar.Scene("box_grasp", {"time.duration": "1.5 s", "object.points": 8000, "fingertips.leaves": 160})
rows = thenar.sweep(scene, {"object.mass": [f"{m} g" for m in masses_g], "contact.friction": frictions})
print(f"{sum(row['outcome'] == 'held' for row in rows)} of {len(rows)} were held")

words = list(OUTCOMES)
outcomes = np.array([words.index(row["outcome"]) for row in rows]).reshape(len(masses_g), len(frictions))
figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
axes.pcolormesh(outcomes, cmap=ListedColormap(list(OUTCOMES.values())), vmin=-0.5, vmax=len(words) - 0.5,
                edgecolor="white", linewidth=3)
for outcome in np.unique(outcomes):
    axes.scatter([], [], s=150, marker="s", color=OUTCOMES[words[outcome]], label=words[outcome])
axes.set_xticks(np.arange(len(frictions)) + 0.5, [f"{f:g}" for f in frictions])
axes.set_yticks(np.arange(len(masses_g)) + 0.5, [f"{m} g" for m in masses_g])
axes.set_xlabel("friction")
axes.set_ylabel("mass of the box")
axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png"), dpi=110)
