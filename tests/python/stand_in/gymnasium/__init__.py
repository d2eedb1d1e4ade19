# SPDX-License-Identifier: Apache-2.0
"""What thenar.gym uses of Gymnasium 1, as its documentation has it: tests import it where Gymnasium is missing."""
import numpy as np

from . import spaces

__all__ = ["Env", "register", "registry", "spaces"]
registry = {}


def register(id, entry_point):
    registry[id] = entry_point


class Env:
    metadata = {"render_modes": []}
    render_mode = None
    spec = None
    _np_random = None

    @property
    def np_random(self):
        if self._np_random is None:
            self._np_random = np.random.default_rng()
        return self._np_random

    @property
    def unwrapped(self):
        return self

    def reset(self, *, seed=None, options=None):
        if seed is not None:
            self._np_random = np.random.default_rng(seed)
