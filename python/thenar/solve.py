"""The small problems of a control period, as functions of arrays."""
from __future__ import annotations

from typing import NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from . import _core

Array = npt.NDArray[np.float64]


class ContactSolution(NamedTuple):
    status: str  #: "converged", "budget spent", "no solution", "not finite".
    force_N: Array  #: (contacts, 3) Normal, tangent 1, tangent 2; on the object.
    gap_m: Array  #: (contacts, 3) W f + delta_free.
    residual: float  #: Natural map [no unit].
    sweeps: int  #: Of Gauss-Seidel.
    steps: int  #: Of Newton.
    certificate: Optional[Array]  #: (contacts,) Normal forces that prove that there is no solution.


class GraspSolution(NamedTuple):
    status: str  #: "optimal", "infeasible", "budget spent".
    force_N: Array  #: (contacts, 3) World axes, on the object; zero without a solution.
    residual: float  #: How far the answer is from its proof [no unit].
    iterations: int
    multiplier: Array  #: (6,) What proves it.


class MuscleSolution(NamedTuple):
    status: str  #: "optimal", "infeasible", "budget spent".
    force_N: Array  #: (muscles,) Zero without a solution.
    residual: float  #: How far the answer is from its proof [no unit].
    iterations: int
    multiplier: Array  #: (joints,) What proves it.


def contact(
    W: npt.ArrayLike,
    delta_free: npt.ArrayLike,
    mu: npt.ArrayLike,
    *,
    method: str = "newton",
    tolerance: float = 1e-8,
    iterations: int = 800,
    guess: Optional[npt.ArrayLike] = None,
) -> ContactSolution:
    """Contact forces f with Coulomb friction: delta = W f + delta_free, 0 <= f_n, delta_n >= 0, f_n delta_n = 0, and
    f_t minimises f_t . delta_t over |f_t| <= mu f_n.

    W: (3n, 3n) Delassus operator [m/N], symmetric; rows normal, tangent 1, tangent 2 of each contact.
    delta_free: (3n,) gaps and slips without contact forces [m]. mu: (n,) or a number.
    method: "newton", which goes on where sweeps stall, or "gauss_seidel".
    tolerance: natural-map residual at which it stops. iterations: steps of Newton, or sweeps.
    guess: (3n,) forces to begin with [N].
    """
    status, f, delta, residual, sweeps, steps, certificate = _core.solve_contact(
        W, delta_free, mu, method, tolerance, iterations, guess
    )
    return ContactSolution(status, f.reshape(-1, 3), delta.reshape(-1, 3), residual, sweeps, steps, certificate)


def grasp(
    points_m: npt.ArrayLike,
    axes: npt.ArrayLike,
    wrench: npt.ArrayLike,
    *,
    friction: npt.ArrayLike,
    internal_force_N: npt.ArrayLike,
    cone: str = "exact",
    centre_m: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> GraspSolution:
    """The least contact forces that give a wrench within friction cones, biased towards squeezing.

    points_m: (n, 3) contact points, 1 to 8. axes: (n, 3, 3), columns n, t1, t2 of each; n points into the object.
    wrench: (6,) on the object, force [N] and moment about centre_m [N m]. World axes.
    friction: (n,) or a number, of the cones. internal_force_N: (n,) or a number, how much squeeze is worth [N].
    cone: "exact" or "pyramid".
    """
    return GraspSolution(*_core.solve_grasp(points_m, axes, wrench, friction, internal_force_N, cone, centre_m))


def muscles(H: npt.ArrayLike, torques_Nm: npt.ArrayLike) -> MuscleSolution:
    """The least forces of muscles, which only pull, that give joint torques: min f'f, H f = tau, f >= 0.

    H: (joints, muscles) moment arms [m]. torques_Nm: (joints,).
    """
    return MuscleSolution(*_core.solve_muscles(H, torques_Nm))
