# SPDX-License-Identifier: Apache-2.0
"""The small problems of a control period, as functions of arrays."""
from __future__ import annotations

from typing import NamedTuple, Optional, Sequence

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


class StiffMuscleSolution(NamedTuple):
    status: str  #: "optimal", "infeasible", "budget spent".
    force_N: Array  #: (muscles,) Zero without a solution.
    residual: float  #: How far the answer is from its proof [no unit].
    iterations: int
    stiffness: Array  #: (6, 6) K_o of these forces; zero without a solution.
    multiplier: Array  #: (joints,) What proves it, with
    stiffness_multiplier: Array  #: (6, 6) the weights of K_o >= K_des.
    lacking_N_per_m: float  #: Infeasible: K_des less this times diag(1, 1, 1, length_m^2, ..) cannot be had either.
    lacking_direction: Array  #: (6,) Where it lacks most: translation, then rotation times length_m; of length 1.


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
    f_t minimises f_t . delta_t over norm(f_t) <= mu f_n.

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


def muscles(
    H: npt.ArrayLike, torques_Nm: npt.ArrayLike, *, limit_N: Optional[npt.ArrayLike] = None
) -> MuscleSolution:
    """The least forces of muscles, which only pull, that give joint torques: min f'f, H f = tau, 0 <= f <= limit.

    H: (joints, muscles) moment arms [m]. torques_Nm: (joints,).
    limit_N: (muscles,) the largest forces, which may be infinite; None: no limits.
    """
    return MuscleSolution(*_core.solve_muscles(H, torques_Nm, limit_N))


def stiff_muscles(
    H: npt.ArrayLike,
    torques_Nm: npt.ArrayLike,
    *,
    finger_joints: Sequence[int],
    turn_m: npt.ArrayLike,
    fibre_per_m: npt.ArrayLike,
    A: npt.ArrayLike,
    B: npt.ArrayLike,
    D: npt.ArrayLike,
    K_des: npt.ArrayLike,
    kappa: float = 0.0,
    limit_N: Optional[npt.ArrayLike] = None,
    arm_m: Optional[npt.ArrayLike] = None,
    tendon_N_per_m: Optional[npt.ArrayLike] = None,
    length_m: float = 0.025,
) -> StiffMuscleSolution:
    """The least muscle forces that give joint torques and make the object so stiff: min f'f, H f = tau,
    0 <= f <= limit, K_o(f) = A - sum_k B_k (D_k + M_k)^-1 B_k' >= K_des, D_k + M_k >= kappa for each finger k, with
    M_k(f) = sum_j s_j a_kj a_kj' - f_j G_kj and s_j = f_j / (1 / fibre_j + f_j / tendon_j).

    H: (joints, muscles) moment arms [m]. torques_Nm: (joints,). finger_joints: joints of each finger, 1 to 5, in the
    order of H's rows. arm_m: (joints, muscles) the a_kj; None: H.
    turn_m: (pairs, muscles) lower triangles of G_kj by rows, finger after finger. fibre_per_m, tendon_N_per_m: (muscles,)
    stiffness of the fibres a newton, and of the tendons; None: rigid. A, K_des: (6, 6) [N/m, N m/rad].
    B: (6, joints). D: (joints, joints), of which the fingers' blocks count. kappa: [N m/rad].
    length_m: the arm on which rotations compare with translations.
    """
    return StiffMuscleSolution(*_core.solve_stiff_muscles({
        "H": H, "torques_Nm": torques_Nm, "finger_joints": list(finger_joints), "turn_m": turn_m,
        "fibre_per_m": fibre_per_m, "A": A, "B": B, "D": D, "K_des": K_des, "kappa": kappa, "limit_N": limit_N,
        "arm_m": arm_m, "tendon_N_per_m": tendon_N_per_m, "length_m": length_m,
    }))
