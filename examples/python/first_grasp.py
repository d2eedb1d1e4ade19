"""A first grasp: three fingertips hold a box and carry it 20 mm sideways. Draws its path and how far it is off."""
import sys
from pathlib import Path

import thenar
from thenar import plot

run = thenar.run(thenar.Scene("box_grasp"))
print(f"{run.outcome}; the largest slip of a finger is {run.summary['grasp']['max_slip_mm']:.3f} mm")
plot.figures(run)["path"].savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png"))
