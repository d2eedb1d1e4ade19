# SPDX-License-Identifier: Apache-2.0
"""Types of the compiled part. Its docstrings are written here by python/stub.py."""
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Any, Callable, Iterator, Mapping, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

_Array = npt.NDArray[np.float64]
_Path = Union[str, PathLike[str]]
_Time = Union[float, str]  # Seconds, or text with a unit: "500 ms".
_Law = Optional[Callable[[Period], npt.ArrayLike]]
_ForceLaw = Optional[Callable[[Period], Optional[npt.ArrayLike]]]

__version__: str
__commit__: str

class Scene:
    """A scene: what holds what, and how.

    Immutable: set() gives another one. It is read and checked when it is made; its surfaces are made when it first
    runs, and shared by all runs of it and by other scenes with the same object and fingertips.
    """
    def __init__(self, file: _Path, set: Optional[dict[str, Any]] = None) -> None:
        """Reads a scene.

        file: a YAML file, or the name of a scene that comes with the package (thenar.scenes()).
        set: changes, as set() takes them.
        Raises SceneError with every fault, its file, line, column and key; FileError for a file that cannot be read.
        """
    def set(self, changes: dict[str, Any]) -> Scene:
        """The scene with some values changed: {'object.mass': '150 g', 'contact.friction': 0.6}.

        Keys and units are those of the file; what has a unit is text. Raises as Scene() does.
        """
    def __copy__(self) -> Scene: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Scene: ...
    def prepare(self) -> None:
        """Makes the surfaces now, finds the grasp where the scene asks for one, and, for `model: auto`, which parts
        it needs: the first run would do it.
        """
    @property
    def file(self) -> Path:
        """The file it was read from."""
    @property
    def changes(self) -> list[str]:
        """What set() has changed, as 'key=value', in order."""
    @property
    def name(self) -> str: ...
    @property
    def duration_s(self) -> float: ...
    @property
    def step_s(self) -> float:
        """Of a contact tick."""
    @property
    def control_period_s(self) -> float: ...
    @property
    def friction(self) -> float: ...
    @property
    def mass_kg(self) -> float: ...
    @property
    def fingers(self) -> list[str]:
        """Names, in the order of every array that has one row a finger."""
    @property
    def joints(self) -> list[str]:
        """Names, in the order of q_rad, or of q_m: finger by finger, from the palm on."""
    @property
    def muscles(self) -> list[str]:
        """Names, in the order of muscles_N; empty where torques drive the joints, or `model: auto` needs no muscles.

        With `model: auto` it does what prepare() does.
        """

class Period:
    """One control period, as a law of the controller sees it.

    All arrays are copies, in SI units, world axes = hand frame. It is over when the law returns. Joints, object and
    forces are those of time_s, which is control.feedback_delay before now_s; touch is fingertips.touch.delay old. What
    comes before in the chain wrench -> forces -> torques -> muscle forces is found when it is asked for: by the law
    given for it, or as published.
    """
    @property
    def time_s(self) -> float:
        """Of what is seen."""
    @property
    def now_s(self) -> float:
        """When the period begins."""
    @property
    def known_gravity(self) -> _Array:
        """(3,) Gravity in the hand's frame [m/s^2]: with control.anticipation the arm's swing is in it."""
    @property
    def period_s(self) -> float:
        """Simulated time since the last period."""
    @property
    def held(self) -> bool:
        """Frames came too late: an old drive is held, and nothing acts that is asked for."""
    @property
    def q_rad(self) -> _Array:
        """(joints,) Joint angles; of slides in m."""
    @property
    def object(self) -> _Array:
        """(4, 4) Pose of the object."""
    @property
    def target(self) -> _Array:
        """(4, 4) Where the object should be."""
    @property
    def error(self) -> _Array:
        """(6,) From the object to its target: translation [m], then rotation vector [rad]."""
    @property
    def force_N(self) -> _Array:
        """(fingers, 3) Force of each finger on the object."""
    @property
    def point_m(self) -> _Array:
        """(fingers, 3) Where each finger acts on the object."""
    @property
    def normal(self) -> _Array:
        """(fingers, 3) Into the object, there."""
    @property
    def gravity_Nm(self) -> _Array:
        """(joints,) What bears the hand's own weight."""
    @property
    def weight(self) -> _Array:
        """(6,) The object's weight, about its origin [N, N m]."""
    @property
    def moment_arms_m(self) -> _Array:
        """(joints, muscles) H of torques = H f."""
    def jacobian(self, finger: int) -> _Array:
        """(3, joints) Velocity of point_m[finger] for the joints' speeds; zero for other fingers' joints."""
    def wrench(self) -> _Array:
        """(6,) W^d: asked of the fingers, about the object's origin [N, N m]."""
    def forces(self) -> _Array:
        """(fingers, 3) f^d: desired force of each finger on the object [N]."""
    def torques(self) -> _Array:
        """(joints,) tau^d: desired joint torques [N m]."""
    def published_wrench(self) -> _Array:
        """(6,) As the PID has it. At most once a period, as all published laws."""
    def published_forces(self) -> Optional[_Array]:
        """(fingers, 3) Within the friction cones, for wrench(); None if there are none."""
    def published_torques(self) -> _Array:
        """(joints,) Of the force control, for forces()."""
    def published_muscle_forces(self) -> _Array:
        """(muscles,) The least that give torques() [N]."""
    @property
    def stick(self) -> _Array:
        """(fingers,) Share of each patch's loaded area that sticks, of scenes with fingertips.touch; else of none."""
    @property
    def rim_friction(self) -> _Array:
        """(fingers,) Likewise: friction where the patch slips; NaN where nothing does."""
    @property
    def slip_speed_m_per_s(self) -> _Array:
        """(fingers,) Likewise: mean speed of what of the patch slips [m/s]."""
    @property
    def torsion_Nm(self) -> _Array:
        """(fingers,) Likewise: moment about the mean normal [N m]."""
    @property
    def felt_normal_N(self) -> _Array:
        """(fingers,) Likewise: load along the mean normal, with the noise of what is felt [N]."""
    @property
    def felt_tangential_N(self) -> _Array:
        """(fingers, 3) Likewise: load across it, world axes [N]."""
    @property
    def friction_felt(self) -> _Array:
        """(fingers,) Likewise: friction that the hand has felt last, or expects."""
    @property
    def cone_friction(self) -> _Array:
        """(fingers,) Likewise: that of the cones of published_forces()."""
    @property
    def squeeze_N(self) -> _Array:
        """(fingers,) Likewise: their squeeze [N]."""

class Simulation:
    """A scene that is stepped.

    In one loop, as `thenar run`, or on the virtual clock of two loops, as `thenar run --lockstep`: the same bits as
    there. Arrays are read-only views of the engine's memory: they show the newest tick; .copy() keeps one. Names and
    units are those of recordings. To lose the object is no error: see lost and report.
    """
    def __init__(
        self,
        scene: Scene,
        *,
        lockstep: Union[bool, dict[str, Any]] = False,
        wrench: _Law = None,
        forces: _ForceLaw = None,
        torques: _Law = None,
        muscles: _Law = None,
    ) -> None:
        """Makes a run that has not begun.

        lockstep: True, or {'jitter_s': 2e-3, 'seed': 1}: frames come late, as between threads. wrench, forces, torques,
        muscles: functions of a Period, each instead of that part of the published controller.
        """
    def step(self, ticks: int = 1) -> None:
        """So many contact ticks, with the control ticks that are due. Lets other threads run."""
    def run(self, until: Optional[_Time] = None) -> dict[str, Any]:
        """Goes on until a simulated time (seconds, or text such as '500 ms'), the scene's end, or the object is lost.

        Returns report.
        """
    def _record_now(self, file: _Path) -> None:
        """A recording of this instant alone."""
    def _repr_html_(self) -> str: ...
    def copy(self) -> Simulation:
        """A run that goes on as this one would, by itself."""
    def state(self) -> bytes:
        """All of the run as bytes, but its laws: the controller's memory, that of the contacts, frames under way.

        For set_state() of a simulation of the same scene, in this process or another one of the same version and
        machine. pickle saves them; so does numpy, as numpy.frombuffer(state, numpy.uint8).
        """
    def set_state(self, state: Union[bytes, npt.NDArray[np.uint8]]) -> None:
        """Goes on as the run did whose state() this is: with the same bits as its copy().

        state: bytes, or an array of bytes, such as numpy.load() gives. The laws stay. Raises ValueError, and changes
        nothing, if the bytes are not whole, or the state of another scene: each value of both has to be the same. Like
        a pickle, a state is to come from somebody you trust.
        """
    def close(self) -> None:
        """No more steps and views, and its laws are let go; views that are there stay. Leaving a `with` does so,
        too.
        """
    def __enter__(self) -> Simulation: ...
    def __exit__(self, *args: Any) -> None: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def lost(self) -> bool:
        """Whether the object is lost."""
    @property
    def report(self) -> dict[str, Any]:
        """What became of the grasp so far, as in summary.json: outcome, reason, held, lost_at_s, beyond."""
    @property
    def environment_wrench(self) -> _Array:
        """(6,) Of the environment on the object: force [N], and moment about its origin [N m], world axes; zero without
        one.
        """
    @property
    def input_wrench(self) -> _Array:
        """(6,) Acts on the object until it is changed: force [N], and moment about its origin [N m], world axes."""
    @input_wrench.setter
    def input_wrench(self, wrench: npt.ArrayLike) -> None: ...
    @property
    def target(self) -> _Array:
        """(4, 4) Where the object should be. Set: from the next tick on; None: where the task has it."""
    @target.setter
    def target(self, target: Optional[npt.ArrayLike]) -> None: ...
    @property
    def displacement_m(self) -> tuple[_Array, ...]:
        """A (points, 3) array a finger: how far the pulp's surface is pushed in at its control points, distal axes [m].
        The surface moves by its negative.
        """
    @property
    def contacts(self) -> npt.NDArray[Any]:
        """Structured array of all contacts: what states have of them.

        As long as the array lives it shows the instant at which `contacts` was last read.
        """
    @property
    def reflex(self) -> Optional[dict[str, Any]]:
        """What the grip began to answer in the last tick; None: nothing.

        A dict: event, 'load' or 'slip'; finger, which felt it most; rate_N_per_s, how fast its load changed, 0 for a
        slip.
        """
    # The fields of a tick, as `thenar fields --stub` prints them.
    @property
    def time_s(self) -> float:
        """Simulated time at the end of the tick. [s]"""
    @property
    def tick(self) -> int:
        """Contact ticks done."""
    @property
    def frame(self) -> int:
        """Sequence number of the frame in use; -1: none yet."""
    @property
    def held(self) -> bool:
        """The frame is too old, and its drive is held."""
    @property
    def object(self) -> _Array:
        """(4, 4) Pose of the object, world axes. [m]"""
    @property
    def q_rad(self) -> _Array:
        """(joints,) Joint angles. [rad] Only of hands with joints that turn."""
    @property
    def q_m(self) -> _Array:
        """(joints,) How far fingertips on slides are from where they began. [m] Only of fingertips on slides."""
    @property
    def stop_Nm(self) -> _Array:
        """(joints,) What the stops at the ends of the joints' ranges bear. [N m] Only of hands with joints that
        turn.
        """
    @property
    def stop_N(self) -> _Array:
        """(joints,) What the stops at the ends of the slides bear. [N] Only of fingertips on slides."""
    @property
    def force_N(self) -> _Array:
        """(fingers, 3) Force of each finger on the object, world axes. [N]"""
    @property
    def desired_N(self) -> _Array:
        """(fingers, 3) What the controller asks of each finger, world axes. [N]"""
    @property
    def centre_m(self) -> _Array:
        """(fingers, 3) Pressure centre of each finger, world axes. [m]"""
    @property
    def normal(self) -> _Array:
        """(fingers, 3) Mean normal of each finger's contacts, into the object, world axes."""
    @property
    def normal_N(self) -> _Array:
        """(fingers,) Part of `force_N` along the normal. [N]"""
    @property
    def tangential_N(self) -> _Array:
        """(fingers,) Part of `force_N` across the normal. [N]"""
    @property
    def desired_normal_N(self) -> _Array:
        """(fingers,) Part of `desired_N` along the normal. [N]"""
    @property
    def desired_tangential_N(self) -> _Array:
        """(fingers,) Part of `desired_N` across the normal. [N]"""
    @property
    def force_error_N(self) -> _Array:
        """(fingers,) Length of `desired_N` - `force_N`. [N]"""
    @property
    def margin(self) -> _Array:
        """(fingers,) Friction to spare, of force and torsion together: 1 without tangential load, 0 where the whole
        patch slides or turns; NaN without load.
        """
    @property
    def slip_m(self) -> _Array:
        """(fingers,) How far each patch has moved on the object since its first contact. [m]"""
    @property
    def start_slip_m(self) -> _Array:
        """(fingers,) The part of `slip_m` in the first 0.3 s. [m]"""
    @property
    def spin_rad(self) -> _Array:
        """(fingers,) How far each patch has turned on the object since its first contact. [rad]"""
    @property
    def start_spin_rad(self) -> _Array:
        """(fingers,) The part of `spin_rad` in the first 0.3 s. [rad]"""
    @property
    def walk_m(self) -> _Array:
        """(fingers, 3) Net way of each patch on the object from 0.3 s on: the sum of its slips as vectors, the object's
        axes. [m]
        """
    @property
    def turn_rad(self) -> _Array:
        """(fingers,) Net turn of each patch on the object from 0.3 s on, about its normal into the object. [rad]"""
    @property
    def dent_m(self) -> _Array:
        """(fingers, 3) How far the object's surface has given way under each patch: the mean of u_o at its points,
        weighted by normal force, the object's axes. [m] Only of soft objects.
        """
    @property
    def sliding_share(self) -> _Array:
        """(fingers,) Share of the normal force on points that slide."""
    @property
    def creep_m_per_s(self) -> _Array:
        """(fingers,) Speed of the fastest loaded point inside its friction cone. [m/s]"""
    @property
    def stick(self) -> _Array:
        """(fingers,) Share of each patch's loaded area that sticks. Only of scenes with `fingertips.touch`."""
    @property
    def rim_friction(self) -> _Array:
        """(fingers,) Friction where the patch slips; NaN where nothing does. Only of scenes with `fingertips.touch`."""
    @property
    def slip_speed_m_per_s(self) -> _Array:
        """(fingers,) Mean speed of what slips of the patch. [m/s] Only of scenes with `fingertips.touch`."""
    @property
    def torsion_Nm(self) -> _Array:
        """(fingers,) Moment about the mean normal. [N m] Only of scenes with `fingertips.touch`."""
    @property
    def friction_felt(self) -> _Array:
        """(fingers,) Friction that the hand has felt last, or expects; 0 before it does. Only of scenes with
        `fingertips.touch` and control.
        """
    @property
    def squeeze_N(self) -> _Array:
        """(fingers,) By how much the controller lets each finger squeeze. [N] Only of scenes with `fingertips.touch`
        and control.
        """
    @property
    def last_reflex(self) -> int:
        """The last answer since the start, as `reflex`. Only of scenes with `fingertips.touch` and control."""
    @property
    def last_reflex_finger(self) -> float:
        """Which finger felt it most, from 0 on; NaN before the first. Only of scenes with `fingertips.touch` and
        control.
        """
    @property
    def last_reflex_s(self) -> float:
        """When it began; NaN before the first. [s] Only of scenes with `fingertips.touch` and control."""
    @property
    def asked_N_per_m(self) -> Optional[_Array]:
        """Stiffness that is asked for along the object's axes. [N/m] Only of scenes that choose a stiffness."""
    @property
    def asked_Nm_per_rad(self) -> Optional[_Array]:
        """Stiffness that is asked for about the object's axes. [N m/rad] Only of scenes that choose a stiffness."""
    @property
    def stiffness_share(self) -> Optional[float]:
        """Share of it that the last control period had. Only of scenes that choose a stiffness."""
    @property
    def stiffness_squeeze_N(self) -> Optional[float]:
        """By how much the internal force is raised for it. [N] Only of scenes that choose a stiffness."""
    @property
    def stiffness_N_per_m(self) -> Optional[_Array]:
        """Stiffness that the chosen forces make, object axes, by columns: of the force for a motion without a turn.
        [N/m] Only of scenes that choose a stiffness.
        """
    @property
    def stiffness_Nm_per_rad(self) -> Optional[_Array]:
        """The same of the moment for a turn about `object_stiffness.centre_m`. [N m/rad] Only of scenes that choose a
        stiffness.
        """
    @property
    def lack_s(self) -> Optional[float]:
        """When a control period last found no forces for it. [s] Only of scenes that choose a stiffness."""
    @property
    def lack_N_per_m(self) -> Optional[float]:
        """How much was lacking then along an axis; NaN where another cause was found. [N/m] Only of scenes that choose
        a stiffness.
        """
    @property
    def lack_Nm_per_rad(self) -> Optional[float]:
        """How much was lacking then about an axis; NaN where another cause was found. [N m/rad] Only of scenes that
        choose a stiffness.
        """
    @property
    def lack_axis(self) -> Optional[_Array]:
        """That axis, object axes. Only of scenes that choose a stiffness."""
    @property
    def lack_muscles(self) -> Optional[_Array]:
        """Of each muscle, 1: it was at its limit then. Only of scenes that choose a stiffness."""
    @property
    def least_muscles_N(self) -> Optional[_Array]:
        """Of each muscle, the least force for the same torques. [N] Only of scenes that choose a stiffness."""
    @property
    def bodies_N(self) -> _Array:
        """(bodies, 3) Force of each body of the environment on the object, world axes; in messages of all bodies,
        elsewhere of the first 16. [N] Only of scenes with an environment.
        """
    @property
    def phase(self) -> int:
        """Which phase of the task runs, from 0 on; as many as there are: all are done; -1: it has none. Only of scenes
        with a task in phases.
        """
    @property
    def borne_N(self) -> float:
        """What the fingers bear against gravity. [N] Only of scenes with a task in phases."""
    @property
    def arm_m(self) -> _Array:
        """(3,) Where the arm is, object axes at the start. [m] Only of scenes with a task in phases."""
    @property
    def friction(self) -> float:
        """Friction of the contacts at this time."""
    @property
    def position_m(self) -> _Array:
        """(3,) Displacement of the object from its start, object axes at the start. [m]"""
    @property
    def path_target_m(self) -> _Array:
        """(3,) Where it should be, likewise. [m]"""
    @property
    def rotation_error_rad(self) -> float:
        """Angle between the object and its target. [rad]"""
    @property
    def muscles_N(self) -> _Array:
        """(muscles,) Forces with which the muscles pulled: by their activation, and by their stretch at the tick's end.
        Of one that pulls several fingers, the sum. [N]
        """
    @property
    def muscles_asked_N(self) -> _Array:
        """(muscles,) Muscle forces that were asked for. [N] Only of scenes whose muscles have activation or
        stiffness.
        """
    @property
    def active(self) -> int:
        """Those that carry force."""
    @property
    def sweeps(self) -> int:
        """Sweeps of the contact solve."""
    @property
    def residual(self) -> float:
        """Residual of the contact solve: natural map."""
    @property
    def penetration_m(self) -> float:
        """The deepest of all control points in the object. [m]"""
    @property
    def environment_force_N(self) -> _Array:
        """(3,) Force of the environment on the object, world axes. [N] Only of scenes with an environment."""
    @property
    def environment_moment_Nm(self) -> _Array:
        """(3,) Its moment about the object's origin, world axes. [N m] Only of scenes with an environment."""
    @property
    def environment_normal_N(self) -> float:
        """Sum of its normal forces. [N] Only of scenes with an environment."""
    @property
    def environment_contacts(self) -> int:
        """Its contacts within the band. Only of scenes with an environment."""
    @property
    def environment_active(self) -> int:
        """Those that carry force. Only of scenes with an environment."""
    @property
    def environment_penetration_m(self) -> float:
        """How far object and body give way to each other, at the most. [m] Only of scenes with an environment."""
    @property
    def frame_age_s(self) -> float:
        """Time from the frame's snapshot to the start of the tick. [s]"""
    @property
    def grasp_failed(self) -> bool:
        """The control tick found no grasp forces."""
    @property
    def muscles_failed(self) -> bool:
        """The control tick found no muscle forces."""
    @property
    def find_us(self) -> float:
        """Time of contact finding; in the window, the median of the last second. [us]"""
    @property
    def factors_us(self) -> float:
        """Time of what a frame needs beside its contacts; in the window, the median of the last second. [us]"""
    @property
    def grasp_us(self) -> float:
        """Time of grasp forces; in the window, the median of the last second. [us]"""
    @property
    def muscle_us(self) -> float:
        """Time of muscle forces; in the window, the median of the last second. [us]"""
    @property
    def assemble_us(self) -> float:
        """Time of assembly of the contact problem; in the window, the median of the last second. [us]"""
    @property
    def solve_us(self) -> float:
        """Time of the contact solve; in the window, the median of the last second. [us]"""
    @property
    def deform_us(self) -> float:
        """Time of deformation of the fingertips; in the window, the median of the last second. [us]"""
    @property
    def drive_J(self) -> float:
        """Work of the drive, since the start. [J]"""
    @property
    def viscous_J(self) -> float:
        """Work of the viscosities, since the start. [J]"""
    @property
    def deformation_J(self) -> float:
        """Work on the pulps and a soft object, since the start. [J]"""
    @property
    def stored_J(self) -> float:
        """Energy that these hold now. [J]"""
    @property
    def injected_J(self) -> float:
        """Work of contacts that give energy, since the start. [J]"""
    @property
    def dissipated_J(self) -> float:
        """Work of contacts that take energy, since the start. [J]"""
    @property
    def dropped_J(self) -> float:
        """Elastic energy that went with contacts that are no more, since the start. [J]"""
    @property
    def torques_Nm(self) -> _Array:
        """(joints,) What the controller asks of the joints. [N m] Only of hands with joints that turn."""
    @property
    def felt_normal_N(self) -> _Array:
        """(fingers,) Load along the mean normal, with the noise of what is felt. [N] Only of scenes with
        `fingertips.touch`.
        """
    @property
    def felt_tangential_N(self) -> _Array:
        """(fingers, 3) Load across it, likewise, world axes. [N] Only of scenes with `fingertips.touch`."""
    @property
    def cone_friction(self) -> _Array:
        """(fingers,) Friction of the cones that the controller plans with. Only of scenes with `fingertips.touch` and
        control.
        """

class Realtime:
    """The two loops of a scene on threads of their own, as `thenar run --realtime`.

        with thenar.Realtime(scene, torques=law) as run:
            run.input(wrench=[0.2, 0, 0, 0, 0, 0])
            print(run.state()['position_m'])

    Laws are called on the control thread. While one takes its time, the last frame stays in use and is then held: the
    contact loop never waits for Python.
    """
    def __init__(
        self,
        scene: Scene,
        *,
        realtime: bool = True,
        core: int = -1,
        wrench: _Law = None,
        forces: _ForceLaw = None,
        torques: _Law = None,
        muscles: _Law = None,
    ) -> None:
        """It lasts as long as the scene. realtime: ask for SCHED_FIFO and a core of its own; what
        is refused is told in report. core: the contact thread's. Laws as of Simulation.
        """
    def start(self) -> None:
        """Begins; entering a `with` does so, too."""
    def stop(self) -> None:
        """Ends it, and waits for the threads; leaving a `with` does so, too. A law of its own does not wait."""
    def __enter__(self) -> Realtime: ...
    def __exit__(
        self, type: Optional[type[BaseException]], value: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None: ...
    def wait(self, seconds: Optional[_Time] = None) -> bool:
        """Until the end of the run, or so long. Whether it has ended. Raises what a law raised, and RuntimeError in a
        law of this run, whose end would never come.
        """
    def state(self) -> dict[str, Any]:
        """The newest tick as a dict of copies; names and units as of Simulation."""
    def input(
        self,
        wrench: Optional[npt.ArrayLike] = None,
        *,
        shift_m: Optional[npt.ArrayLike] = None,
        turn_rad: Optional[npt.ArrayLike] = None,
    ) -> None:
        """From the next tick on, until it is changed.

        wrench: (6,) on the object, about its origin, world axes [N, N m]. shift_m, turn_rad: (3,) of the target against
        the task's, object axes at the start; within 50 mm and 0.5 rad an axis, to which it goes at 50 mm/s and 1
        rad/s.
        """
    @property
    def running(self) -> bool: ...
    @property
    def report(self) -> dict[str, Any]:
        """Of a run that has ended: outcome and reason, and its summary.json as `thenar run --realtime` writes it.

        Raises what a law raised.
        """

class Recording:
    """What a recording holds, as arrays: recording['force_N'].

    A row a state. Names and units are those of Simulation and of the live window; `object` and `target` are (states, 4,
    4) poses, and what is a vector a finger is (states, fingers, 3). What a recording does not know is NaN.
    """
    def __init__(self, file: _Path) -> None:
        """Reads an MCAP file that thenar wrote, also one that was cut off. Raises FileError."""
    def __iter__(self) -> Iterator[str]: ...
    @property
    def whole(self) -> bool:
        """Whether the file was ended: it was not cut off, and is sound."""
    def __getitem__(self, field: str) -> _Array: ...
    def __contains__(self, arg0: object) -> bool: ...
    def __len__(self) -> int: ...
    def keys(self) -> list[str]:
        """Names of the fields that the states have."""
    @property
    def name(self) -> str:
        """Of the scene."""
    @property
    def fingers(self) -> list[str]: ...
    @property
    def joints(self) -> list[str]: ...
    @property
    def muscles(self) -> list[str]: ...
    @property
    def time_s(self) -> _Array:
        """(states,) They go back where the simulation was set back."""
    @property
    def contacts(self) -> npt.NDArray[Any]:
        """Structured array of all contacts of all states, a row each.

        time_s of the state, finger, control_point, point_m, normal, force_N: world axes, the force acts on the object;
        normal_N, friction_N and share as `Simulation.contacts` has them, NaN where the recording does not.
        """
    @property
    def tick_contacts(self) -> npt.NDArray[Any]:
        """Structured array of all contacts of all ticks, where `record_contacts` was asked for.

        time_s, finger, control_point; force_N on the object along normal, tangent and their cross product; slip_m along
        the last two in that tick; point_m, normal and tangent: world, as the message of many ticks that they are of
        began.
        """
    def _repr_html_(self) -> str: ...

class Grasp:
    """A grasp that was found."""
    @property
    def fingers(self) -> list[str]:
        """Names of those that hold."""
    @property
    def q_rad(self) -> _Array:
        """(joints,) Of these fingers."""
    @property
    def object(self) -> _Array:
        """(4, 4) Pose of the object."""
    @property
    def points_m(self) -> _Array:
        """(fingers, 3) Where they touch, object frame."""
    @property
    def normals(self) -> _Array:
        """(fingers, 3) Outward there, object frame."""
    @property
    def force_N(self) -> _Array:
        """(fingers, 3) On the object against its weight, world axes."""
    def scene(self) -> Scene:
        """The scene with this grasp, ready to run."""
    # The measures of a found grasp, as `thenar fields --stub` prints them.
    @property
    def width_m(self) -> float:
        """The distance from the finger that faces the others to the middle of their places. [m]"""
    @property
    def press_N(self) -> float:
        """The normal load of the least loaded finger, while the hand holds the weight. [N]"""
    @property
    def margin(self) -> float:
        """The least share of a friction cone that is left, of all fingers, with the weight in any direction, a push of
        0.5 N along it and a turn of 10 mN m: 0 slips, 1 has no tangential force at all.
        """
    @property
    def needed_friction(self) -> float:
        """The friction that suffices for the scene's weight with the torsion of the patches, at rest in the trial."""
    @property
    def limit_rad(self) -> float:
        """The least distance of a joint from an end of its range. [rad]"""
    @property
    def muscle_share(self) -> float:
        """The largest force of a muscle as a share of its limit, under the weight as it is and with a push of 0.5 N in
        any direction; without muscles 0, and null in messages.
        """
    @property
    def torque_Nm(self) -> float:
        """The largest torque of a joint under the weight as it is; the effort of hands without muscles. [N m]"""
    @property
    def patch(self) -> float:
        """The least share of a pressed pulp's patch that lies on the surface: less than 1 over an edge or a hole."""
    @property
    def travel_m(self) -> float:
        """How far the fingers carry the object in the direction in which they carry it best, at most 25 mm. [m]"""
    @property
    def cost(self) -> float:
        """The number by which the search ranks grasps: it weighs margin, friction, limits, effort, patches and
        travel.
        """

def scenes() -> dict[str, str]:
    """Scenes that come with the package, by name, and what each shows."""
def hands() -> list[str]:
    """Names of the hands that come with the package."""
def new_scene(
    file: _Path,
    object: _Path,
    hand: _Path = "hand",
    *,
    unit: str = "1 m",
    mass: str = "100 g",
    friction: float = 0.6,
) -> Scene:
    """Writes a scene in which a hand is to grasp an object of one's own, as `thenar new`.

    file: the scene, which is not there yet. object: a mesh (STL, OBJ, OFF, PLY) or a cloud (PLY, PCD, XYZ); unit: what
    1 in it measures, '1 mm'. hand: a file, or the name of one that comes with the package (thenar.hands()). mass: '100
    g'. Returns the scene; its grasp is found when it first runs.
    """
def use_data(folder: _Path) -> None:
    """Where scenes and hands that come with the package lie."""
def grasp(scene: Scene, *, best: int = 1, seed: Optional[int] = None) -> list[Grasp]:
    """Finds how the scene's hand can hold its object: `best` grasps, the best first; each was tried in the engine.

    What the scene asks of the grasp under `grasp` is heeded. Raises NoGrasp with the reason where there is none.
    """
def rollout(
    simulations: Sequence[Simulation],
    ticks: int,
    *,
    every: int = 1,
    signals: Sequence[str] = ...,
    threads: Optional[int] = None,
) -> dict[str, _Array]:
    """Advances many simulations by so many ticks, each on one thread, all at once.

    Returns a dict: for each signal an array (simulations, ticks / every, ...), sampled every so many ticks. Names as of
    Simulation; contacts is their number, and reflex is 0, 1 for a load or 2 for a slip. A field that a scene does not
    have has no numbers. The bits are those of step(), whatever the threads.
    """
def sweep(
    scene: Scene, vary: Mapping[str, Union[str, Sequence[Any]]], *, threads: Optional[int] = None
) -> list[dict[str, Any]]:
    """Runs all combinations of what varies, as `thenar sweep`.

    vary: key to values, {'contact.friction': [0.3, 0.5], 'object.mass': '50 g:200 g:4'}; the last key turns fastest.
    Returns a list of rows: a dict of what varies, as the list had it, outcome, reason and the measures of summary.json.
    A combination that is no scene is a row: 'refused', and why.
    """
def solve_contact(
    W: npt.ArrayLike,
    delta_free: npt.ArrayLike,
    mu: npt.ArrayLike,
    method: str,
    tolerance: float,
    iterations: int,
    guess: Optional[npt.ArrayLike],
    /,
) -> tuple[str, _Array, _Array, float, int, int, Optional[_Array]]: ...
def solve_grasp(
    points_m: npt.ArrayLike,
    axes: npt.ArrayLike,
    wrench: npt.ArrayLike,
    friction: npt.ArrayLike,
    internal_force_N: npt.ArrayLike,
    cone: str,
    centre_m: npt.ArrayLike,
    /,
) -> tuple[str, _Array, float, int, _Array]: ...
def solve_muscles(
    H: npt.ArrayLike, torques_Nm: npt.ArrayLike, limit_N: Optional[npt.ArrayLike], /
) -> tuple[str, _Array, float, int, _Array]: ...
def solve_stiff_muscles(
    problem: dict[str, Any], /
) -> tuple[str, _Array, float, int, _Array, _Array, _Array, float, _Array]: ...
def _page(recording: _Path) -> str: ...
def _run(
    scene: Scene,
    record: Optional[_Path],
    record_rate: Optional[Union[float, str]],
    record_fields: Optional[Sequence[str]],
    record_contacts: bool,
    lockstep: Union[bool, dict[str, Any]],
    wrench: _Law,
    forces: _ForceLaw,
    torques: _Law,
    muscles: _Law,
) -> dict[str, Any]: ...
