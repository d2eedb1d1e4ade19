# SPDX-License-Identifier: Apache-2.0
"""A grasp as an environment of Gymnasium, to learn how to hold an object.

    import thenar.gym

    env = thenar.gym.GraspEnv("box_grasp")
    observation, info = env.reset(seed=1, options={"set": {"contact.friction": 0.5}})
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

With Gymnasium's register: `gymnasium.make("thenar.gym:thenar/Grasp-v0", scene="box_grasp")`.
"""
from __future__ import annotations

from typing import Any, Callable, Mapping, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

try:
    import gymnasium
except ImportError as _missing:
    raise ImportError("thenar.gym needs Gymnasium, which is not installed: pip install gymnasium") from _missing

from . import _core
from .result import Array

Law = Callable[[_core.Period, Array], Optional[npt.ArrayLike]]
Reward = Callable[[_core.Simulation, Array], float]
Variation = Callable[[np.random.Generator], Mapping[str, Any]]

#: What is observed unless named otherwise: poses of the object and its target, forces and friction to spare of the
#: fingers, joint angles or, of fingertips on slides, their ways.
OBSERVATION = ("object", "target", "force_N", "margin", "q_rad", "q_m")
#: What an action of 1 adds to what the published controller asks for, unless named otherwise.
SCALE: dict[str, npt.ArrayLike] = {
    "wrench": [0.5, 0.5, 0.5, 0.01, 0.01, 0.01],  # [N], then [N m]
    "forces": 0.5,  # [N]
    "torques": 0.02,  # [N m]
    "muscles": 1.0,  # [N]
}


def nearness(simulation: _core.Simulation, action: Array) -> float:
    """The reward unless given: 1 with the object at its target, 0.37 at 2 mm from there, and 0 once it is lost."""
    if simulation.lost:
        return 0.0
    off_m = simulation.position_m - simulation.path_target_m
    return float(np.exp(-np.square(off_m / 2e-3).sum()))


def _published(part: str, scale: Array) -> Law:
    """The published law of this part, with the action added."""

    def law(period: _core.Period, action: Array) -> Optional[Array]:
        if part == "wrench":
            return period.published_wrench() + scale * action
        if part == "forces":
            forces = period.published_forces()
            return None if forces is None else forces + (scale * action).reshape(forces.shape)
        if part == "torques":
            return period.published_torques() + scale * action
        return np.maximum(period.published_muscle_forces() + scale * action, 0.0)  # A muscle only pulls.

    return law


def _numbers(simulation: _core.Simulation, field: str) -> Array:
    """A field as an array of numbers: of a pose its rotation and position, (3, 4); 0 where it is NaN."""
    if not isinstance(getattr(_core.Simulation, field, None), property):
        raise ValueError(f"observation: a Simulation has no field '{field}'")
    value = getattr(simulation, field)
    try:
        numbers = np.asarray([] if value is None else value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"observation: '{field}' is not made of numbers") from None
    return np.nan_to_num(numbers[:3] if numbers.shape == (4, 4) else numbers, nan=0.0)


class GraspEnv(gymnasium.Env):  # type: ignore[misc]
    """A scene as an environment: an episode is a run of it, which ends when the object is lost.

    action_space: numbers from -1 to 1, what lies beyond being clipped. They act through one part of the controller,
    `wrench`, `forces`, `torques` or `muscles` (docs/guide/controller.md), and stay the same for a step of `period_s`.
    observation_space: fields of a Simulation by their names, one after the other; observation_names has a name for
    each number, such as "force_N[0,2]". Numbers that are not known, such as the margin of a finger without load, are 0.

    A step returns terminated where the object is lost or a phase of its task has failed, truncated at the scene's end
    (time.duration), and as info `time_s`, `outcome` and `set`, what this episode's scene has other than `scene`.
    `simulation` is the run itself: its state() and set_state(), also of another environment of the same scene, serve to
    look ahead.
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi"], "render_fps": 50}

    def __init__(
        self,
        scene: Union[_core.Scene, str] = "box_grasp",
        *,
        part: str = "wrench",
        scale: Optional[npt.ArrayLike] = None,
        law: Optional[Law] = None,
        actions: Optional[int] = None,
        observation: Sequence[str] = OBSERVATION,
        reward: Reward = nearness,
        vary: Optional[Variation] = None,
        period_s: float = 0.02,
        lockstep: Union[bool, dict[str, Any]] = False,
        render_mode: Optional[str] = None,
    ) -> None:
        """Makes an environment of a scene, or of the name of one.

        part: of the controller, through which an action acts. The action is added to what the published controller
        asks for there, times `scale`, a number or one for each of the action's.
        law: instead, what this part asks for: a function of a Period and the action, which has `actions` numbers.
        observation: names of fields. reward: a function of the simulation after a step, and of the action.
        vary: a function of the environment's random numbers that returns what an episode's scene has other than
        `scene`, as Scene.set takes it: {'contact.friction': rng.uniform(0.4, 0.8)}. reset(options={'set': {...}})
        does so for one episode, and has the last word.
        lockstep: as of Simulation. render_mode: 'ansi', a line of text; a notebook shows `simulation` as a picture.
        """
        self.scene = scene if isinstance(scene, _core.Scene) else _core.Scene(scene)
        self.render_mode = render_mode
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise ValueError(f"render_mode is None or 'ansi', not {render_mode!r}")
        self._ticks = round(period_s / self.scene.step_s)
        if self._ticks < 1:
            raise ValueError(f"period_s has to be a tick, {self.scene.step_s} s, or longer")
        self.metadata = {**self.metadata, "render_fps": round(1.0 / (self._ticks * self.scene.step_s))}
        self._part, self._lockstep = part, lockstep
        self._action = np.zeros(self._count(law, actions))
        self._law = law or _published(part, self._scale(scale))
        self._reward, self._vary, self._fields = reward, vary, tuple(observation)
        self._set: dict[str, Any] = {}
        self.simulation = self._start(self.scene)
        self.observation_names = tuple(
            field + (f"[{','.join(map(str, index))}]" if index else "")
            for field in self._fields for index in np.ndindex(_numbers(self.simulation, field).shape))
        if not self.observation_names:
            raise ValueError("observation names no field that has numbers in this scene")
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, self._action.shape, np.float64)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (len(self.observation_names),), np.float64)

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begins an episode. options: {'set': changes}, what its scene has other than `scene`, as Scene.set takes it.

        Its cost is that of reading the scene, as long as the changes leave the object's shape and the fingertips.
        """
        super().reset(seed=seed)
        unknown = set(options or {}) - {"set"}
        if unknown:
            raise ValueError(f"options has no {', '.join(map(repr, sorted(unknown)))}: set")
        changes = dict(self._vary(self.np_random)) if self._vary else {}
        changes.update((options or {}).get("set", {}))
        simulation = self._start(self.scene.set(changes) if changes else self.scene)
        if self._observe(simulation).shape != self.observation_space.shape:
            raise ValueError("this scene has another number of fingers or joints: make another environment of it")
        self.close()
        self.simulation, self._set = simulation, changes
        return self._observe(simulation), self._info()

    def step(self, action: npt.ArrayLike) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Lets the action act for period_s, or until the object is lost or the scene ends."""
        given = np.asarray(action, dtype=np.float64)
        if given.shape != self._action.shape or not np.isfinite(given).all():
            raise ValueError(f"an action is {self._action.size} finite numbers, not {action!r}")
        self._action[:] = np.clip(given, -1.0, 1.0)
        run = self.simulation
        end = round(run.scene.duration_s / run.scene.step_s)
        until = max(run.tick, min(run.tick + self._ticks, end))
        run.run(until=until * run.scene.step_s)  # It ends by itself where the object is lost, or a phase of the task fails.
        ended = run.lost or run.tick < until
        reward = float(self._reward(run, self._action.copy()))
        return self._observe(run), reward, ended, run.tick >= end and not ended, self._info()

    def render(self) -> Optional[str]:
        """A line of text with render_mode 'ansi', else None."""
        if self.render_mode is None:
            return None
        run = self.simulation
        off_mm = 1e3 * float(np.linalg.norm(run.position_m - run.path_target_m))
        loads = ", ".join(f"{name} {load:.2f} N" for name, load in zip(run.scene.fingers, run.normal_N))
        return f"{run.time_s:.3f} s: {run.report['outcome']}, {off_mm:.2f} mm off the target; {loads}"

    def close(self) -> None:
        """Ends the episode, and lets the simulation and the law go."""
        self.simulation.close()

    def _count(self, law: Optional[Law], actions: Optional[int]) -> int:
        """How many numbers an action has."""
        counts = {"wrench": 6, "forces": 3 * len(self.scene.fingers), "torques": len(self.scene.joints),
                  "muscles": len(self.scene.muscles)}
        if self._part not in counts:
            raise ValueError(f"part is one of {', '.join(counts)}, not {self._part!r}")
        if (law is None) != (actions is None):
            raise ValueError("law and actions, how many numbers an action of it has, come together")
        count = counts[self._part] if actions is None else actions
        if count < 1:
            raise ValueError("an action has no numbers here: torques drive the joints of this scene, and no muscles"
                             if actions is None else "actions has to be 1 or more")
        return count

    def _scale(self, scale: Optional[npt.ArrayLike]) -> Array:
        """What an action of 1 adds to each number."""
        given = np.asarray(SCALE[self._part] if scale is None else scale, dtype=np.float64)
        if given.shape not in ((), self._action.shape) or not np.isfinite(given).all():
            raise ValueError(f"scale is a finite number, or one for each of the {self._action.size} of an action")
        return np.broadcast_to(given, self._action.shape)

    def _start(self, scene: _core.Scene) -> _core.Simulation:
        """A run of the scene in which the action acts. Its law must not refer to it, or nothing would free it."""
        self._action = np.zeros_like(self._action)
        law, action = self._law, self._action
        laws: dict[str, Any] = {self._part: lambda period: law(period, action)}
        return _core.Simulation(scene, lockstep=self._lockstep, **laws)

    def _observe(self, simulation: _core.Simulation) -> Array:
        return np.concatenate([_numbers(simulation, field).ravel() for field in self._fields])

    def _info(self) -> dict[str, Any]:
        return {"time_s": self.simulation.time_s, "outcome": self.simulation.report["outcome"], "set": dict(self._set)}


gymnasium.register(id="thenar/Grasp-v0", entry_point="thenar.gym:GraspEnv")
