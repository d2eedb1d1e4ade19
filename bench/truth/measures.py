# SPDX-License-Identifier: Apache-2.0
"""What is measured of a run, the same way for every engine: from the object's motion, the fingers' and the loads."""

import math

import numpy

LOST_m = 0.01           # Who has moved so far along the load since it is there has let go.
HELD_m_per_s = 50e-6    # A body that is slower than this at the end is held; what slides soon is faster by far.
LOADED_s = 0.75         # From then on loads are there.


def moved(run):
    """How far the object has gone along its load since that is there [m], by time."""
    along = run.along()
    return along - along[min(len(along) - 1, numpy.searchsorted(run.time, LOADED_s))]


def lost_s(run):
    """When it let go; None: it did not."""
    gone = numpy.flatnonzero(~(numpy.abs(moved(run)) < LOST_m) & (run.time > LOADED_s))
    if len(gone):
        return float(run.time[gone[0]])
    return None if run.whole else float(run.time[-1])


def creep_um_per_s(run):
    """The speed along the load over the last two thirds, and not before 10 s of a long run; None: lost."""
    if lost_s(run) is not None:
        return None
    first = numpy.searchsorted(run.time, min(10.0, run.time[-1] / 3))
    along = run.along()
    return float(1e6 * abs(along[-1] - along[first]) / (run.time[-1] - run.time[first]))


def held(run):
    """Whether the object is held: not lost, and as good as at rest in the last fifth."""
    if lost_s(run) is not None:
        return False
    first = numpy.searchsorted(run.time, 0.8 * run.time[-1])
    along = run.along()
    return bool(abs(along[-1] - along[first]) / (run.time[-1] - run.time[first]) < HELD_m_per_s)


def energy_J(run):
    """Kinetic and stored energy, less the work of all loads and of the fingers' forces, after each step: in exact
    mechanics with friction it never rises. Loads must be constant, and without moment."""
    energy = run.kinetic + run.stored
    for load in run.world["loads"]:
        factor = numpy.interp(run.time, load["times"], load["factors"])
        step = numpy.diff(run.at, axis=0, prepend=run.at[:1]) @ numpy.asarray(load["force"], float)
        energy = energy - numpy.cumsum(factor * step)
    for finger, gone in zip(run.world["fingers"], run.travel.T):
        energy = energy - finger["force"] * gone
    return energy


def injected_J(run, since_s, until_s=math.inf):
    """The sum of all increases of that energy in a stretch of time."""
    chosen = energy_J(run)[(run.time >= since_s) & (run.time <= until_s)]
    return float(numpy.clip(numpy.diff(chosen), 0, None).sum())


def median_us(run):
    """The time of a step, when loads are there."""
    return float(numpy.median(run.us[run.time > LOADED_s]))
