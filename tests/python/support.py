# SPDX-License-Identifier: Apache-2.0
"""What the tests of the package share."""
import os
import sys
import unittest

try:
    import numpy as np
except ImportError:
    print("skipped: numpy is missing (Debian: python3-numpy)")
    sys.exit(77)

import thenar

PROGRAM = os.environ.get("THENAR_PROGRAM", "")

#: Fewer samples of the box, which no figure here needs, and a short run.
QUICK = {"object.points": 6000, "time.duration": "300 ms"}


def box(**changes):
    """The box grasp, quickly; `a__b=c` changes a.b."""
    return thenar.Scene("box_grasp", {**QUICK, **{key.replace("__", "."): value for key, value in changes.items()}})


def wet(**changes):
    """A box that becomes wet at 0.4 s, quickly: the hand feels it 65 ms later."""
    quick = {"object.points": 6000, "contact.max_per_finger": 20, "task.friction": [{"at": "0.4 s", "to": 0.15}]}
    return thenar.Scene("box_wet", {**quick, **{key.replace("__", "."): value for key, value in changes.items()}})


__all__ = ["PROGRAM", "QUICK", "box", "np", "thenar", "unittest", "wet"]
