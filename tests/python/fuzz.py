# SPDX-License-Identifier: Apache-2.0
"""Calls the package with what nobody should give it, for so many seconds: fuzz.py [seconds] [seed].

Whatever is given, a call returns or raises; it never crashes, and a simulation that refused something goes on. Under
AddressSanitizer (./dev fuzz SECONDS python) what is read or written out of place is found, too.
"""
import faulthandler
import os
import random
import sys
import tempfile
import threading
import time

from support import np, thenar

faulthandler.enable()

SCENES = [
    thenar.Scene("minimal"),
    thenar.Scene("box_grasp", {"object.points": 3000}),
    thenar.Scene("box_grasp", {"object.points": 3000, "control.muscles": False}),
    thenar.Scene("box_grasp", {"object.points": 3000, "fingertips.leaves": 20}),
]

KEYS = ["object.mass", "contact.friction", "contact.tolerance", "time.step", "time.duration", "control.muscles",
        "control.pid.position", "hand.posture", "hand.file", "object.points", "fingertips.leaves", "task.push", "x.y"]
FOLDER = tempfile.TemporaryDirectory()
thenar.run(
    SCENES[1].set({"time.duration": "40 ms"}), record=os.path.join(FOLDER.name, "whole.mcap"), record_contacts=True
)
with open(os.path.join(FOLDER.name, "whole.mcap"), "rb") as whole:
    RECORDING = whole.read()


def anything(random_, depth=0):
    """A value of any kind, often nearly right."""
    kinds = [
        lambda: None, lambda: True, lambda: random_.randint(-5, 40), lambda: random_.choice([2**63, -2**63, 10**30]),
        lambda: random_.choice([0.0, -1.5, 1e-9, 1e300, float("nan"), float("inf"), 3.7]),
        lambda: random_.choice(["", "1 s", "5 ms", "1 mm", "x", "\0", "ä" * 9, "a=b", "- ", "{", "object.mass", "150 g"]),
        lambda: b"bytes", lambda: object(), lambda: np.float32(0.5), lambda: np.array("x"), lambda: slice(3),
        lambda: np.full(random_.choice([0, 3, 6, 12, 23, 36]), random_.choice([0.0, 1.0, np.nan])),
        lambda: np.zeros([random_.randint(0, 4) for _ in range(random_.randint(0, 4))]),
        lambda: np.eye(random_.choice([1, 3, 4, 6, 9])) * random_.choice([1.0, 0.0, -1.0, 1e200]),
        lambda: np.arange(24.0)[:: random_.choice([1, 2, -1])], lambda: np.zeros(6, complex), lambda: np.zeros(6, object),
        lambda: random_.choice(SCENES), lambda: lambda *a: anything(random_, 3), lambda: (lambda: 1 / 0),
    ]
    if depth < 3:
        kinds += [lambda: [anything(random_, depth + 1) for _ in range(random_.randint(0, 6))],
                  lambda: {random_.choice(["object.mass", "x", 3, "jitter_s", "contact.friction"]): anything(random_, depth + 1)
                           for _ in range(random_.randint(0, 3))}]
    return random_.choice(kinds)()


def law(random_):
    """A law that mostly does as published, and sometimes anything."""
    kept = []

    def act(period):
        kept.append(period)
        for old in kept[-3:-1]:
            try:
                old.torques()
            except RuntimeError:
                pass
        roll = random_.random()
        if roll < 0.1:
            return anything(random_)
        if roll < 0.15:
            raise ValueError("mine")
        if roll < 0.2:
            return period.jacobian(random_.randint(-3, 5))
        name = random_.choice(["published_wrench", "published_forces", "published_torques", "published_muscle_forces",
                               "wrench", "forces", "torques"])
        return getattr(period, name)()

    return act


FIELDS = [name for name in dir(thenar.Simulation) if not name.startswith("_")]


def poke(random_, run):
    """One call on a simulation."""
    def value():
        return anything(random_)

    def soon():
        """As value(), but no time that it takes seconds to come to."""
        time_s = value()
        return 0.02 if isinstance(time_s, (int, float)) and 0.1 < time_s < 1e6 else time_s

    act = random_.choice([
        lambda: run.step(random_.randint(0, 30)), lambda: run.step(value()), lambda: run.run(until=soon()),
        lambda: run.run(until=run.time_s + 0.01), lambda: setattr(run, "input_wrench", value()),
        lambda: setattr(run, "target", value()), lambda: setattr(run, random_.choice(FIELDS), value()),
        lambda: getattr(run, random_.choice(FIELDS)), lambda: repr(run), lambda: run.copy().step(3),
        lambda: run.close() if random_.random() < 0.1 else None, lambda: sum(map(float, np.ravel(run.q_rad))),
        lambda: run.contacts["force_N"].sum(), lambda: thenar.rollout([run, run.copy()], value(), every=value()),
        lambda: thenar.rollout([run.copy(), run], random_.randint(0, 9), threads=2, signals=random_.choice([["margin"], value()])),
        lambda: threads_at_once(run), lambda: run.set_state(run.copy().state()), lambda: run.set_state(value()),
        lambda: run.set_state(run.state()[:random_.randint(0, 40000)]),
    ])
    return act()


def threads_at_once(run):
    """Steps and views by two threads: one of them is refused."""
    def use():
        for _ in range(5):
            try:
                run.step(3)
                run.force_N.sum()
            except Exception:
                pass

    other = threading.Thread(target=use)
    other.start()
    use()
    other.join()


def read_broken(random_):
    """A recording that was cut off, or has some other bytes."""
    bytes_ = bytearray(RECORDING[: random_.choice([len(RECORDING), random_.randrange(len(RECORDING))])])
    for _ in range(random_.randint(0, 8) if bytes_ else 0):
        bytes_[random_.randrange(len(bytes_))] = random_.randrange(256)
    file = os.path.join(FOLDER.name, "broken.mcap")
    with open(file, "wb") as to:
        to.write(bytes_)
    recording = thenar.Recording(file)
    for field in recording:
        np.nansum(recording[field])
    np.nansum(recording.contacts["force_N"]), np.nansum(recording.tick_contacts["force_N"])


def run_recorded(random_):
    """A short run with settings of any kind."""
    settings = {name: random_.choice([anything(random_), right]) for name, right in
                [("record_rate", 100), ("record_fields", ["margin"]), ("record_contacts", True), ("lockstep", False)]}
    scene = random_.choice(SCENES).set({"time.duration": "10 ms"})
    thenar.run(scene, record=os.path.join(FOLDER.name, "run.mcap"), **settings)


def one(random_):
    def value():
        return anything(random_)

    roll = random_.random()
    if roll < 0.06:
        random_.choice(SCENES).set(value())
    elif roll < 0.15:
        changed = random_.choice(SCENES).set({random_.choice(KEYS): value(), random_.choice(KEYS): value()})
        thenar.Simulation(changed).step(3)
    elif roll < 0.16:
        thenar.Scene(value(), value())
    elif roll < 0.18:
        read_broken(random_)
    elif roll < 0.2:
        run_recorded(random_)
    elif roll < 0.3:
        random_.choice([
            lambda: thenar.solve.contact(value(), value(), value()),
            lambda: thenar.solve.contact(np.random.default_rng(1).normal(size=(6, 6)), np.zeros(6), value(), tolerance=value()),
            lambda: thenar.solve.grasp(value(), value(), value(), friction=value(), internal_force_N=value()),
            lambda: thenar.solve.grasp(np.zeros((2, 3)), [np.eye(3)] * 2, value(), friction=0.5, internal_force_N=1.0),
            lambda: thenar.solve.muscles(value(), value()),
            lambda: thenar.solve.muscles(value(), value(), limit_N=value()),
            lambda: thenar.solve.stiff_muscles(value(), value(), finger_joints=value(), turn_m=value(),
                                               fibre_per_m=value(), A=value(), B=value(), D=value(), K_des=value()),
            lambda: thenar.solve.muscles(np.random.default_rng(1).normal(size=(4, 8)), value()),
        ])()
    elif roll < 0.33:
        short = random_.choice(SCENES).set({"time.duration": "10 ms"})
        thenar.sweep(short, random_.choice([value(), {random_.choice(KEYS[:-6]): [value(), "0.5"]}]))
    elif roll < 0.36:
        with thenar.Realtime(random_.choice(SCENES).set({"time.duration": "50 ms"}), realtime=False,
                             torques=random_.choice([None, law(random_), value()])) as run:
            run.input(wrench=value())
            run.state()
    else:
        laws = {name: law(random_) for name in ("wrench", "forces", "torques", "muscles") if random_.random() < 0.2}
        run = thenar.Simulation(random_.choice(SCENES), lockstep=random_.choice([False, False, True, value()]), **laws)
        views = [run.q_rad, run.contacts, run.margin]
        for _ in range(random_.randint(1, 20)):
            try:
                poke(random_, run)
            except Exception:
                pass
        del run
        return sum(float(np.size(view)) for view in views)
    return 0.0


def main(seconds, seed):
    print(f"seed {seed}", flush=True)
    end, calls, refused = time.monotonic() + seconds, 0, {}
    while time.monotonic() < end:
        random_ = random.Random(f"{seed}:{calls}")
        try:
            one(random_)
        except (MemoryError, SystemError):
            print(f"call {calls} of seed {seed}", flush=True)
            raise
        except Exception as error:
            if not str(error):
                sys.exit(f"call {calls} of seed {seed} is refused without a word: {type(error).__name__}")
            refused[type(error).__name__] = refused.get(type(error).__name__, 0) + 1
        calls += 1
    print(f"{calls} calls, refused {refused}")
    if calls == 0 or not refused:
        sys.exit("nothing was tried")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 10.0, int(sys.argv[2]) if len(sys.argv) > 2 else random.randrange(10**6))
