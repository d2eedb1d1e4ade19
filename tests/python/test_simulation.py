# SPDX-License-Identifier: Apache-2.0
"""Simulations: the program's bits, views of the engine's memory, what one may not do."""
import csv
import ctypes
import gc
import os
import pickle
import subprocess
import sys
import tempfile
import threading

from support import PROGRAM, QUICK, box, np, thenar, unittest, wet


def program_signals(*options, scene="box_grasp"):
    """What the program `thenar` writes of the same run: names, and the rows' text."""
    changes = [text for key, value in QUICK.items() for text in ("--set", f"{key}={value}")]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([PROGRAM, "run", scene, *changes, "--out", folder, "--quiet", *options], check=True)
        with open(os.path.join(folder, "signals.csv")) as file:
            rows = list(csv.reader(file))
    return rows[0], rows[1:]


class SameBits(unittest.TestCase):
    def expect_same(self, run, names, rows):
        self.assertEqual(list(run.signals), names)
        for i, name in enumerate(names):
            self.assertEqual([f"{x:.9g}" for x in run.signals[name]], [row[i] for row in rows], name)

    def test_run_is_the_programs(self):
        """All nine digits of every signal of every tick are those of `thenar run`."""
        self.expect_same(thenar.run(box()), *program_signals())

    def test_lockstep_is_the_programs(self):
        self.expect_same(thenar.run(box(), lockstep=True), *program_signals("--lockstep"))

    def test_found_grasp_is_the_programs(self):
        """The finder, too, takes the same copies of what Eigen and the solvers share with others."""
        self.expect_same(thenar.run(thenar.Scene("found_carry", QUICK)), *program_signals(scene="found_carry"))

    def test_what_a_scene_needs_is_the_programs(self):
        """`model: auto` leaves out here what it leaves out there, and says so."""
        names, rows = program_signals("--set", "model=auto")
        needed = thenar.run(box(model="auto"))
        self.expect_same(needed, names, rows)
        self.assertIn("left out: muscles (control.muscles)", " ".join(needed.summary["parts"]))
        self.assertEqual(box(model="auto").muscles, [])
        self.assertNotEqual(list(needed.signals), list(thenar.run(box()).signals))

    def test_steps_are_a_run(self):
        """One by one, in batches, and with until: the same state, to the last bit, and that of a run."""
        scene = box()
        runs = [thenar.Simulation(scene) for _ in range(3)]
        ticks = round(scene.duration_s / scene.step_s)
        for _ in range(ticks):
            runs[0].step()
        runs[1].step(ticks - 7)
        runs[1].step(7)
        runs[2].run(until="150 ms")
        runs[2].run()
        whole = thenar.run(scene)
        for run in runs:
            self.assertEqual(run.tick, ticks)
            self.assertTrue(np.array_equal(run.object, runs[0].object))
            for i, joint in enumerate(scene.joints):
                self.assertEqual(run.q_rad[i], whole.signals[joint + "_rad"][-1])

    def test_copy_goes_on_by_itself(self):
        one = thenar.Simulation(box(), lockstep={"jitter_s": 1e-3, "seed": 7})
        one.step(90)
        two = one.copy()
        before = one.object.copy()
        two.step(50)
        self.assertTrue(np.array_equal(one.object, before))
        one.step(50)
        self.assertTrue(np.array_equal(one.object, two.object))
        self.assertTrue(np.array_equal(one.slip_m, two.slip_m))

    def test_state_goes_on_as_a_copy(self):
        """With the same bits, all that is told of the run included: another simulation, and the same one set back."""
        soft = {"object.compliance": "{reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 5 ms}"}
        late = {"jitter_s": 1e-3, "seed": 7}
        for scene, lockstep in ((box(), False), (box(), late), (thenar.Scene("box_grasp", {**QUICK, **soft}), False),
                                (wet(), late), (thenar.Scene("resting_box"), False),
                                (thenar.Scene("pick_and_place"), False)):
            one, other = thenar.Simulation(scene, lockstep=lockstep), thenar.Simulation(scene, lockstep=lockstep)
            one.step(90)
            other.step(7)
            copy, state = one.copy(), one.state()
            self.assertIsInstance(state, bytes)
            other.set_state(state)
            self.assertEqual(other.state(), state)
            self.assertTrue(np.array_equal(one.contacts, other.contacts))
            self.assertTrue(np.array_equal(one.margin, other.margin, equal_nan=True))
            for run in (one, copy, other):
                run.step(50)
            after = one.state()
            one.set_state(state)
            one.step(50)
            for run in (copy, other, one):
                self.assertTrue(np.array_equal(run.object, copy.object), scene.name)
                self.assertTrue(np.array_equal(run.slip_m, copy.slip_m), scene.name)
                self.assertEqual(run.report, copy.report)
            self.assertEqual(len(after), len(one.state()))

    def test_state_is_saved(self):
        """By pickle and by numpy, and a run goes on from there in another process: with the last bit of the controller's
        memory, of what is felt late, and of the contacts."""
        program = ("import pickle, sys\nimport numpy as np\nimport support\n"
                   "run = support.thenar.Simulation(support.wet(control__feedback_delay='8 ms'))\n"
                   "run.set_state(np.load(sys.argv[1]))\nrun.step(300)\n"
                   "pickle.dump(run.state(), open(sys.argv[2], 'wb'))\n")
        run = thenar.Simulation(wet(control__feedback_delay="8 ms"))
        run.step(200)
        state = run.state()
        run.step(300)  # In which the box becomes wet, and the grip answers.
        after, report, friction = run.state(), run.report, run.friction_felt.copy()
        self.assertNotEqual(run.last_reflex, 0)
        run.set_state(pickle.loads(pickle.dumps(state)))
        self.assertEqual(run.tick, 200)
        run.step(300)
        with tempfile.TemporaryDirectory() as folder:
            saved, other = os.path.join(folder, "state.npy"), os.path.join(folder, "other")
            np.save(saved, np.frombuffer(state, np.uint8))
            subprocess.run([sys.executable, "-B", "-c", program, saved, other], check=True,
                           cwd=os.path.dirname(os.path.abspath(__file__)))
            with open(other, "rb") as file:
                elsewhere = pickle.load(file)
        for name in ("object", "q_rad", "force_N", "margin", "slip_m", "muscles_N", "stick"):
            run.set_state(after)
            expected = np.array(getattr(run, name))
            run.set_state(elsewhere)
            self.assertTrue(np.array_equal(getattr(run, name), expected, equal_nan=True), name)
        self.assertEqual(run.report, report)
        self.assertTrue(np.array_equal(run.friction_felt, friction))

    def test_state_refuses_what_is_none(self):
        run = thenar.Simulation(box())
        run.step(20)
        state, before = run.state(), run.object.copy()
        bad = [state[:i * len(state) // 50] for i in range(50)] + [state + b"0", b"thenar state" * 9, b"\xff" * 99]
        bad += [state[:i] + bytes([state[i] ^ 1]) + state[i + 1:] for i in range(0, len(state), len(state) // 20)]
        bad += [thenar.Simulation(thenar.Scene("minimal")).state(), thenar.Simulation(box(), lockstep=True).state()]
        for bytes_ in bad:
            with self.assertRaises(ValueError):
                run.set_state(bytes_)
        for other in ("state", None, np.zeros(9), np.frombuffer(state, np.uint8)[::2],
                      np.frombuffer(state, np.uint8).reshape(1, -1)):
            with self.assertRaises(TypeError):
                run.set_state(other)
        self.assertTrue(np.array_equal(run.object, before))
        self.assertEqual(run.tick, 20)
        run.set_state(state)

    def test_arrays_stay_what_they_are(self):
        """Views are of the engine's memory, which a state that is set, or a copy, does not move."""
        run = thenar.Simulation(box())
        run.step(60)
        state, contacts = run.state(), run.contacts
        then, u = contacts.copy(), run.displacement_m
        run.step(20)
        run.copy()
        run.state()
        self.assertTrue(np.array_equal(contacts, then))
        run.set_state(state)
        for mine, now in zip(u, run.displacement_m):
            self.assertTrue(np.array_equal(mine, now))
        copy = run.copy()
        of_copy = copy.contacts
        address = of_copy.__array_interface__["data"][0]
        copy.step(60)
        self.assertEqual(copy.contacts.__array_interface__["data"][0], address)

    def test_state_is_of_one_scene(self):
        """Gains, delays and materials are in a state as they were: another scene's are not to be mixed with them."""
        state = thenar.Simulation(box()).state()
        for key, value in (("contact.friction", 0.7), ("control.position.p", "250 N/m"), ("object.mass", "90 g")):
            with self.assertRaisesRegex(ValueError, "the state is of another scene: "):
                thenar.Simulation(box().set({key: value})).set_state(state)

    def test_state_keeps_the_laws(self):
        calls = []
        run = thenar.Simulation(box(), torques=lambda period: calls.append(1) or period.published_torques())
        run.step(5)
        run.set_state(run.state())
        before = len(calls)
        run.step(5)
        self.assertGreater(len(calls), before)


class Views(unittest.TestCase):
    FIELDS = {"q_rad": (12,), "object": (4, 4), "force_N": (3, 3), "centre_m": (3, 3), "normal": (3, 3),
              "normal_N": (3,), "tangential_N": (3,), "desired_N": (3, 3), "margin": (3,), "slip_m": (3,),
              "spin_rad": (3,), "walk_m": (3, 3), "turn_rad": (3,), "sliding_share": (3,), "creep_m_per_s": (3,),
              "position_m": (3,), "path_target_m": (3,), "torques_Nm": (12,), "muscles_N": (23,), "stop_Nm": (12,)}

    def setUp(self):
        self.run_ = thenar.Simulation(box())
        self.run_.step(100)

    def test_are_the_engines_memory(self):
        """No copy: a view keeps its address, and shows the next tick's numbers without being asked for again."""
        for name, shape in self.FIELDS.items():
            view = getattr(self.run_, name)
            self.assertEqual(view.shape, shape, name)
            self.assertIs(view.base, self.run_, name)
            self.assertEqual(view.ctypes.data, getattr(self.run_, name).ctypes.data, name)
        forces, kept = self.run_.force_N, self.run_.force_N.copy()
        self.run_.step(50)
        self.assertFalse(np.array_equal(forces, kept))
        self.assertTrue(np.array_equal(forces, self.run_.force_N))

    def test_cannot_be_written(self):
        for name in [*self.FIELDS, "contacts"]:
            with self.assertRaises(ValueError, msg=name):
                getattr(self.run_, name)[...] = 0
        with self.assertRaises(ValueError):
            self.run_.displacement_m[0][0, 0] = 1.0

    def test_keep_the_simulation(self):
        q = self.run_.q_rad
        kept = q.copy()
        self.run_ = None
        gc.collect()
        self.assertTrue(np.array_equal(q, kept))

    def test_contacts_add_up(self):
        """Forces act on the object: into it along the normal, and their sum over a finger is the finger's. Sums of some
        twenty numbers round at 1e-15 of them."""
        contacts = self.run_.contacts
        self.assertGreater(len(contacts), 10)
        self.assertGreaterEqual(np.einsum("ij,ij->i", contacts["force_N"], contacts["normal"]).min(), -1e-12)
        for k in range(3):
            total = contacts["force_N"][contacts["finger"] == k].sum(axis=0)
            np.testing.assert_allclose(total, self.run_.force_N[k], atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(contacts["normal"], axis=1), 1.0, atol=1e-12)

    def test_forces_hold_the_weight(self):
        """At rest the fingers' forces bear the weight, but for the drag of what still creeps: within 1 % of it."""
        run = thenar.Simulation(thenar.Scene("box_grasp", {"object.points": 6000}))
        run.run()
        gravity = np.array([7.018620, 5.581331, 3.977916])
        np.testing.assert_allclose(run.force_N.sum(axis=0), -run.scene.mass_kg * gravity, atol=0.01 * 9.81 * 0.1)

    def test_before_the_first_tick(self):
        fresh = thenar.Simulation(box())
        self.assertEqual(len(fresh.contacts), 0)
        self.assertEqual(fresh.tick, 0)
        for name in self.FIELDS:
            getattr(fresh, name)
        self.assertEqual(fresh.report["outcome"], "held")


class Environment(unittest.TestCase):
    def test_carries_the_weight(self):
        """0.01 N: c f of the corners, which are not placed to the last micrometre."""
        rest = thenar.Simulation(thenar.Scene("resting_box"))
        rest.step(100)
        np.testing.assert_allclose(rest.environment_wrench[:3], [0.0, 0.0, 0.1 * 9.80665], atol=0.01)
        self.assertEqual(rest.environment_contacts, 4)
        self.assertAlmostEqual(rest.environment_normal_N, 0.1 * 9.80665 * np.cos(np.radians(10.0)), delta=0.01)
        self.assertLess(rest.environment_penetration_m, 0.1e-6)

    def test_is_none_where_the_scene_names_none(self):
        grasp = thenar.Simulation(box())
        grasp.step(1)
        self.assertEqual(grasp.environment_contacts, 0)
        self.assertFalse(grasp.environment_wrench.any())


class Touch(unittest.TestCase):
    """What fingertips feel, and the grip's answer."""
    ROWS = ("stick", "rim_friction", "slip_speed_m_per_s", "torsion_Nm", "felt_normal_N", "friction_felt",
            "cone_friction", "squeeze_N")
    SIGNALS = {"stick": "stick", "rim_friction": "rim_friction", "friction_felt": "friction_felt",
               "squeeze_N": "squeeze_N"}

    def test_views(self):
        """Views of the engine's memory; a scene that does not name touch has none of it."""
        run, none = thenar.Simulation(wet()), thenar.Simulation(box())
        for simulation, fingers in ((run, 3), (none, 0)):
            views = {name: getattr(simulation, name) for name in self.ROWS}
            simulation.step(50)
            for name, view in views.items():
                self.assertEqual(view.shape, (fingers,), name)
                self.assertTrue(np.array_equal(view, getattr(simulation, name), equal_nan=True), name)
                with self.assertRaises(ValueError):
                    view[...] = 0
            self.assertEqual(simulation.felt_tangential_N.shape, (fingers, 3))
            self.assertIsNone(simulation.reflex)
        # Where nothing grips, fingertips feel all the same.
        given = thenar.Simulation(thenar.Scene("slide", {"fingertips.touch": {}}))
        self.assertEqual((given.stick.shape, given.squeeze_N.shape), ((3,), (0,)))
        # Without noise what is felt is the load.
        np.testing.assert_allclose(run.felt_normal_N, run.normal_N, atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(run.felt_tangential_N, axis=1), run.tangential_N, atol=1e-12)

    def test_slip_is_answered(self):
        """65 ms after the box has become wet the reflex begins; friction is then felt where the rims slip, and the
        squeeze goes up. rollout keeps the numbers that the columns of a run are."""
        scene = wet(time__duration="600 ms")
        run = thenar.Simulation(scene)
        events = []
        while run.time_s < scene.duration_s - 1e-9:
            run.step()
            if run.reflex:
                events.append((run.time_s, run.reflex))
        time_s, first = events[0]
        self.assertEqual(first["event"], "slip")
        self.assertIn(first["finger"], scene.fingers)
        self.assertEqual(first["rate_N_per_s"], 0.0)
        self.assertGreaterEqual(time_s, 0.4 + 0.065)
        self.assertLess(time_s, 0.4 + 0.065 + 0.02)
        np.testing.assert_allclose(run.friction_felt, 0.15, rtol=0.05)
        np.testing.assert_allclose(run.cone_friction * 1.3, run.friction_felt, rtol=1e-12)
        columns = thenar.run(scene).signals
        self.assertEqual(events, [(t, e) for t, e in events if columns["reflex"][round(t / scene.step_s) - 1] == 2])
        kept = thenar.rollout([thenar.Simulation(scene)], 600, signals=list(self.SIGNALS))
        for name, column in self.SIGNALS.items():
            for k, finger in enumerate(scene.fingers):
                self.assertTrue(np.array_equal(kept[name][0, :, k], columns[f"{finger}_{column}"], equal_nan=True), name)


class Fields(unittest.TestCase):
    """The fields of a tick: what a simulation shows, a rollout keeps and real time tells are one list."""

    def test_rollout_and_views_agree(self):
        for scene in (wet(), box(), thenar.Scene("resting_box"), thenar.Scene("slides_ball", {"object.points": 4000})):
            try:
                thenar.rollout([], 0, signals=["?"])
            except ValueError as error:
                names = str(error).split(": ")[1].split(", ")
            self.assertGreater(len(names), 80)
            run = thenar.Simulation(scene)
            kept = thenar.rollout([run], 20, every=20, signals=names)
            for name in names:
                value = getattr(run, name)
                if name in ("contacts", "reflex", "target") or name.endswith("_us"):
                    continue  # The first three mean more as views; times are of the clock.
                last = kept[name][0, 0]
                if value is None:  # A stiffness that the scene does not choose.
                    self.assertEqual(last.size, 0, name)
                elif np.size(last) > 0 or np.size(value) == 0:
                    self.assertTrue(np.array_equal(value, last, equal_nan=True), name)
                self.assertIn(".", getattr(type(run), name).__doc__, name)

    def test_real_time_tells_them(self):
        with thenar.Realtime(wet().set({"time.duration": "0.2 s"}), realtime=False) as run:
            run.wait()
            state = run.state()
        shown = thenar.Simulation(wet())
        shown.step(1)
        for name, value in state.items():
            if name not in ("contacts", "reflex", "target"):
                self.assertEqual(np.shape(value), np.shape(getattr(shown, name)), name)
        self.assertIsInstance(state["sweeps"], int)
        self.assertIsInstance(state["held"], bool)

    def test_real_time_tells_that_no_forces_were_found(self):
        run = thenar.Realtime(box().set({"time.duration": "0.2 s"}), realtime=False, 
                              forces=lambda period: None if period.now_s > 0.05 else period.published_forces())
        run.start()
        run.wait()
        self.assertTrue(run.state()["grasp_failed"])


class Slides(unittest.TestCase):
    """Fingertips on slides: joints in m and N."""

    def test_views(self):
        scene = thenar.Scene("slides_ball", {"object.points": 4000})
        self.assertEqual(scene.joints, ["tip1_travel", "tip2_travel", "tip3_travel"])
        with thenar.Simulation(scene) as run:
            run.step(300)
            self.assertEqual((run.q_m.shape, run.stop_N.shape), ((3,), (3,)))
            self.assertEqual((run.q_rad.shape, run.stop_Nm.shape), ((0,), (0,)))
            np.testing.assert_allclose(run.normal_N, 2.0, rtol=0.05)
            self.assertFalse(run.q_m.flags.writeable)
        with thenar.Simulation(box()) as run:
            self.assertEqual((run.q_m.shape, run.stop_N.shape), ((0,), (0,)))

    def test_rollout_and_signals(self):
        scene = thenar.Scene("slides_ball", {"object.points": 4000, "time.duration": "0.05 s"})
        arrays = thenar.rollout([thenar.Simulation(scene)], 50, signals=["q_m", "q_rad"])
        self.assertEqual((arrays["q_m"].shape, arrays["q_rad"].shape), ((1, 50, 3), (1, 50, 0)))
        whole = thenar.run(scene)
        np.testing.assert_array_equal(whole.signals["tip1_travel_mm"], 1e3 * arrays["q_m"][0, :, 0])

    def test_bad_slide(self):
        with self.assertRaises(thenar.SceneError) as caught:
            thenar.Scene("slides_ball", {"hand.slides[1].spring": "{stiffness: 1 N/m, rest: 0 mm}"})
        self.assertIn("hand.slides[1].spring", str(caught.exception))


class Rules(unittest.TestCase):
    def test_losing_the_object_is_a_value(self):
        run = thenar.Simulation(box(contact__friction=0.02, control__grasp__friction=0.3, time__duration="2 s"))
        report = run.run()
        self.assertTrue(run.lost)
        self.assertEqual(report["outcome"], "lost")
        self.assertLess(run.time_s, 2.0)
        run.step(10)  # and nothing forbids to go on

    def test_closed(self):
        run = thenar.Simulation(box())
        run.step(3)
        q = run.q_rad
        run.close()
        run.close()
        for use in (run.step, run.run, run.copy, lambda: run.q_rad, lambda: run.report, lambda: run.contacts):
            with self.assertRaisesRegex(ValueError, "closed"):
                use()
        self.assertEqual(q.shape, (12,))

    def test_views_of_a_driven_run(self):
        """A table's muscle forces come where the views are."""
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "drive.csv")
            with open(file, "w") as table:
                names = thenar.Scene("box_grasp").muscles
                print("time_s", *(f"{name}_N" for name in names), sep=",", file=table)
                for time_s in (0, 1):
                    print(time_s, *(1 + time_s for _ in names), sep=",", file=table)
            run = thenar.Simulation(box(control__drive=file))
        view = run.muscles_N
        for _ in range(50):
            run.step()
            self.assertEqual(view.ctypes.data, run.muscles_N.ctypes.data)
            np.testing.assert_allclose(view, 1 + run.time_s, rtol=1e-12)

    def test_one_thread_at_a_time(self):
        run = thenar.Simulation(box(time__duration="20 s"))
        ready = threading.Event()
        other = threading.Thread(target=lambda: (ready.set(), run.step(4000)))
        other.start()
        ready.wait()
        faults = []
        while other.is_alive():
            try:
                run.step()
            except RuntimeError as error:
                faults.append(str(error))
        other.join()
        self.assertTrue(faults and all("being stepped" in fault for fault in faults))

    def test_inputs(self):
        run = thenar.Simulation(box())
        run.step(200)
        before = run.object[:3, 3].copy()
        run.input_wrench = [0, 0, 0.5, 0, 0, 0]
        run.step(50)
        self.assertGreater(run.object[2, 3], before[2] + 1e-5)
        run.input_wrench = np.zeros(6)
        target = run.target
        target[0, 3] += 2e-3
        run.target = target
        run.run(until=0.8)
        self.assertAlmostEqual(run.object[0, 3], target[0, 3], delta=3e-4)
        run.target = None

    def test_bad_input(self):
        run = thenar.Simulation(box())
        cases = [
            (TypeError, "must be numbers", lambda: setattr(run, "input_wrench", "abcdef")),
            (TypeError, "must be numbers", lambda: setattr(run, "input_wrench", None)),
            (ValueError, r"shape \(5,\), not \(6,\)", lambda: setattr(run, "input_wrench", [0] * 5)),
            (ValueError, "not finite", lambda: setattr(run, "input_wrench", [np.nan] * 6)),
            (ValueError, "no pose", lambda: setattr(run, "target", 2 * np.eye(4))),
            (ValueError, "0 or more", lambda: run.step(-1)),
            (TypeError, "", lambda: run.step(1.5)),
            (TypeError, "", lambda: run.step("3")),
            (ValueError, "not a time", lambda: run.run(until="3 kg")),
            (ValueError, "not finite", lambda: run.run(until=np.inf)),
            (ValueError, "million", lambda: run.run(until=1e9)),
            (TypeError, "takes a function", lambda: thenar.Simulation(box(), torques=3)),
            (TypeError, "", lambda: thenar.Simulation("box_grasp")),
            (ValueError, "until must lie", lambda: run.run(until=-(2.0**63))),
            (TypeError, "lockstep takes True", lambda: thenar.Simulation(box(), lockstep=3)),
            (ValueError, "lockstep has no 'jiter_s'", lambda: thenar.Simulation(box(), lockstep={"jiter_s": 1})),
        ]
        for kind, words, act in cases:
            with self.assertRaisesRegex(kind, words):
                act()
        run.step()

    def test_takes_no_memory(self):
        """Ten thousand steps ask for no memory: the library that counts is preloaded."""
        counter = os.environ.get("LD_PRELOAD")
        if not counter:
            self.skipTest("nothing counts here")
        allocations = ctypes.CDLL(counter).thenar_allocations
        allocations.restype = ctypes.c_long
        run = thenar.Simulation(thenar.Scene("box_grasp", {"object.points": 6000, "time.duration": "20 s"}))
        run.step(500)
        before = allocations()
        self.assertGreater(before, 1000)
        run.step(10_000)
        self.assertLessEqual(allocations() - before, 20)  # of Python's own call


if __name__ == "__main__":
    unittest.main()
