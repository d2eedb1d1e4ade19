# SPDX-License-Identifier: Apache-2.0
"""One's own controller: the published one given as functions, and what else may be in its place."""
import subprocess
import sys
import time

from support import box, np, thenar, unittest, wet

LAWS = {
    "wrench": lambda period: period.published_wrench(),
    "forces": lambda period: period.published_forces(),
    "torques": lambda period: period.published_torques(),
    "muscles": lambda period: period.published_muscle_forces(),
}


class OneLoop(unittest.TestCase):
    def test_published_law_holds_the_box_alike(self):
        """Given as Python functions, alone and all at once, the published law makes the same trajectory: to 1e-9 m and
        rad is asked, and it is the same to the last bit, for numbers pass through Python unchanged."""
        plain = thenar.run(box())
        for laws in [*({name: law} for name, law in LAWS.items()), LAWS]:
            run = thenar.run(box(), **laws)
            self.assertEqual(run.outcome, "held")
            for name, column in plain.signals.items():
                self.assertTrue(np.array_equal(run.signals[name], column, equal_nan=True), (list(laws), name))

    def test_jacobian_transpose_holds(self):
        """A law of one's own that knows nothing of ours: J' f + g, with forces from the published cones."""
        def torques(period):
            f = period.forces()
            return period.gravity_Nm + sum(period.jacobian(k).T @ f[k] for k in range(len(f)))

        run = thenar.Simulation(box(time__duration="500 ms"), torques=torques)
        self.assertTrue(run.run()["held"])

    def test_what_a_law_sees(self):
        seen = []

        def wrench(period):
            seen.append(period)
            self.assertEqual(period.q_rad.shape, (12,))
            self.assertEqual(period.jacobian(1).shape, (3, 12))
            self.assertFalse(period.jacobian(1)[:, :4].any())
            self.assertEqual(period.moment_arms_m.shape, (12, 23))
            np.testing.assert_allclose(np.linalg.norm(period.normal, axis=1), 1.0, atol=1e-12)
            np.testing.assert_allclose(period.target @ np.linalg.inv(period.target), np.eye(4), atol=1e-12)
            with self.assertRaises(IndexError):
                period.jacobian(3)
            return period.published_wrench()

        thenar.Simulation(box(), wrench=wrench).step(2)
        with self.assertRaisesRegex(RuntimeError, "is over"):
            seen[0].q_rad

    def test_what_is_known_late(self):
        """Joints and object are those of 65 ms ago, and so is what the fingertips feel; gravity is of now with
        anticipation alone."""
        scene = thenar.Scene("box_shake", {"object.points": 6000, "contact.max_per_finger": 20,
                                           "task.arm.from": "50 ms", "fingertips.touch.delay": "30 ms"})
        states, seen = [], []

        def wrench(period):
            seen.append((period.time_s, period.now_s, period.q_rad, period.stick, period.felt_tangential_N,
                         period.friction_felt, period.squeeze_N, period.known_gravity))
            return period.published_wrench()

        run = thenar.Simulation(scene, wrench=wrench)
        for _ in range(200):
            states.append((run.q_rad.copy(), run.stick.copy(), run.felt_tangential_N.copy()))
            run.step()
        for i, (time_s, now_s, q_rad, stick, tangential_N, friction, squeeze_N, gravity) in enumerate(seen):
            self.assertAlmostEqual(now_s, 1e-3 * i, delta=1e-12)
            self.assertAlmostEqual(time_s, 1e-3 * max(0, i - 65), delta=1e-12)
            self.assertTrue(np.array_equal(q_rad, states[max(0, i - 65)][0]))
            self.assertTrue(np.array_equal(stick, states[max(0, i - 30)][1]))
            self.assertTrue(np.array_equal(tangential_N, states[max(0, i - 30)][2]))
            self.assertEqual(friction.shape, (3,))
            self.assertEqual(squeeze_N.shape, (3,))
        self.assertFalse(np.array_equal(seen[-1][7], seen[0][7]))
        of_now = []
        late = thenar.Simulation(scene.set({"control.anticipation": False}),
                                 wrench=lambda p: of_now.append(p.known_gravity) or p.published_wrench())
        late.step(200)
        self.assertTrue(np.array_equal(of_now[0], of_now[-1]))

    def test_no_touch(self):
        """A scene without it has it of no finger."""
        def wrench(period):
            self.assertEqual(period.stick.shape, (0,))
            self.assertEqual(period.felt_tangential_N.shape, (0, 3))
            self.assertEqual(period.squeeze_N.shape, (0,))
            self.assertEqual(period.now_s, period.time_s)
            return period.published_wrench()

        thenar.Simulation(box(), wrench=wrench).step()

    def test_touch_without_control(self):
        """Of a scene that only touches, a law of torques has what fingertips feel."""
        def torques(period):
            self.assertEqual(period.stick.shape, (3,))
            self.assertEqual(period.squeeze_N.shape, (0,))
            return period.gravity_Nm

        run = thenar.Simulation(thenar.Scene("slide", {"fingertips.touch": {}}), torques=torques)
        run.step(3)

    def test_muscles_and_torques_agree(self):
        """H f of the muscles is what the joints were asked for."""
        residuals = []

        def muscles(period):
            f = period.published_muscle_forces()
            residuals.append(np.abs(period.moment_arms_m @ f - period.torques()).max())
            return f

        thenar.Simulation(box(), muscles=muscles).step(100)
        self.assertLess(max(residuals), 1e-9)

    def test_no_forces(self):
        """None: there are no grasp forces, and the last ones go on."""
        run = thenar.Simulation(box(), forces=lambda p: p.published_forces() if p.time_s < 0.1 else None)
        run.step(200)
        self.assertEqual(run.report["outcome"], "solver failed")
        self.assertGreater(np.linalg.norm(run.desired_N), 1.0)

    def test_one_answer_a_period(self):
        """The PID goes on with each answer, and what waits for a law cannot be asked by it."""
        for law, words in [(lambda p: p.published_wrench() + p.published_wrench(), "once a period"),
                           (lambda p: p.torques() and p.wrench(), "waits for that law")]:
            with self.assertRaisesRegex(RuntimeError, words):
                thenar.Simulation(box(), wrench=law).step()

    def test_refusals(self):
        def fault(**laws):
            try:
                thenar.Simulation(box(), **laws).step()
            except Exception as error:
                return type(error), str(error)
            return None

        name = "what the law 'torques' returned"
        self.assertEqual(fault(torques=lambda p: np.zeros(3)), (ValueError, f"{name} has the shape (3,), not (12,)"))
        self.assertEqual(fault(torques=lambda p: np.full(12, np.nan))[0], ValueError)
        self.assertEqual(fault(torques=lambda p: None)[0], TypeError)
        self.assertEqual(fault(torques=lambda p: 1 / 0)[0], ZeroDivisionError)
        self.assertEqual(fault(wrench=lambda: 1)[0], TypeError)
        kind, words = fault(muscles=lambda p: -np.ones(23))
        self.assertTrue(kind is ValueError and "muscles pull" in words)


class TwoLoops(unittest.TestCase):
    #: The target rests, so that what is seen is the hold alone.
    SCENE = {"time.step": "1 ms", "time.control_period": "5 ms", "time.duration": "2 s", "object.points": 6000,
             "task.translate.by": ["0 mm", "0 mm", "0 mm"]}

    def scene(self):
        return thenar.Scene("box_grasp", self.SCENE)

    def passes(self, run, time_s):
        """Waits until it has simulated so long, which on a busy machine takes longer."""
        while run.state()["time_s"] < time_s:
            self.assertFalse(run.wait(0.005), f"it ended before {time_s} s")

    def test_a_stall_is_a_hold(self):
        """A law that takes 300 ms once, as a garbage collection may: the contact loop goes on with the last frame, which
        is then held, and the object stays where it is, within 1 mm, as in a hold of late frames."""
        calls = 0

        def torques(period):
            nonlocal calls
            calls += 1
            if calls == 150:
                time.sleep(0.3)
            return period.published_torques()

        with thenar.Realtime(self.scene(), realtime=False, torques=torques) as run:
            run.wait()
            state = run.state()
        self.assertGreater(run.report["hold"]["ticks"], 50)
        self.assertEqual(run.report["grasp"]["outcome"], run.report["outcome"])
        self.assertIn(run.report["outcome"], ("held", "unknown"))
        self.assertLess(np.linalg.norm(state["position_m"] - state["path_target_m"]), 1e-3)

    def test_inputs_and_states(self):
        with thenar.Realtime(self.scene(), realtime=False) as run:
            self.assertTrue(run.running)
            self.assertFalse(run.wait("1 ms"))
            self.passes(run, 0.3)
            run.input(wrench=[0, 0, 0.5, 0, 0, 0])
            self.passes(run, 0.8)
            pushed = run.state()["object"][2, 3]
            run.input(wrench=np.zeros(6))
            for bad in ([1, 2], [np.inf] * 6, "x"):
                with self.assertRaises((TypeError, ValueError)):
                    run.input(wrench=bad)
            with self.assertRaisesRegex(RuntimeError, "goes on"):
                run.report
            run.wait()
            self.assertLess(run.state()["object"][2, 3], pushed)
        self.assertFalse(run.running)
        with self.assertRaisesRegex(RuntimeError, "already"):
            run.start()

    def test_what_a_law_raises_ends_the_run(self):
        def torques(period):
            if period.time_s > 0.2:
                raise KeyError("mine")
            return period.published_torques()

        with self.assertRaisesRegex(KeyError, "mine"):
            with thenar.Realtime(self.scene(), realtime=False, torques=torques) as run:
                run.wait()

    def test_raised_again_and_again(self):
        """Whoever asks is told, and as often as is asked."""
        run = thenar.Realtime(self.scene(), realtime=False, torques=lambda period: {}["mine"])
        with self.assertRaisesRegex(RuntimeError, "not begun"):
            run.wait()
        run.start()
        for ask in (run.wait, lambda: run.report, run.wait):
            with self.assertRaisesRegex(KeyError, "mine"):
                ask()

    def test_ends_whoever_lets_go(self):
        """A run that nobody has any more ends, and so does one whose law or whose other thread stops it, at the
        interpreter's end, too: nothing waits for the interpreter's lock while it holds it."""
        for end in ("del run", "run.stop()", "pass", "[t.start() or t.join() for t in [threading.Thread(target=run.stop)]]"):
            text = f"""
import threading, time, thenar
run = thenar.Realtime(thenar.Scene("minimal", {{"time.duration": "1000 s"}}), realtime=False,
                      wrench=lambda period: period.published_wrench())
run.start()
while run.state()["time_s"] == 0.0:
    time.sleep(0.01)
{end}
"""
            said = subprocess.run([sys.executable, "-c", text], timeout=60, capture_output=True, text=True)
            self.assertEqual((said.returncode, said.stderr), (0, ""), end)
        runs = []

        def stopping(period):
            runs[0].stop()
            return period.published_torques()

        runs.append(thenar.Realtime(self.scene(), realtime=False, torques=stopping))
        runs[0].start()
        self.assertTrue(runs[0].wait(20.0))

    def in_a_process(self, text, said="lived\n"):
        """Programs end as they should, without a word of the system's."""
        text = """
import gc, threading, time, thenar
scene = thenar.Scene("minimal", {"object.points": 1000, "time.duration": "1000 s"})
published = lambda period: period.published_torques()
class Cycle:
    def __init__(self, law):
        self.me = self
        self.run = thenar.Realtime(scene, realtime=False, torques=law)
        self.run.start()
""" + text
        ended = subprocess.run([sys.executable, "-B", "-c", text], timeout=60, capture_output=True, text=True)
        self.assertEqual((ended.returncode, ended.stderr, ended.stdout), (0, "", said), text)

    def test_let_go_of_in_a_law(self):
        """A run may be let go of in a law: its own, or another run's, by hand or by the garbage collector."""
        for text in (
            "box = []\n"
            "def law(period):\n    box.clear()\n    return period.published_torques()\n"
            "box.append(thenar.Realtime(scene, realtime=False, torques=law))\nbox[0].start()\ntime.sleep(0.3)\n",
            "def law(period):\n    gc.collect()\n    return period.published_torques()\n"
            "gc.disable()\nCycle(law)\ntime.sleep(0.3)\n",
            "def law(period):\n    gc.collect()\n    return period.published_torques()\n"
            "gc.disable()\nCycle(published)\nrun = thenar.Realtime(scene, realtime=False, torques=law)\nrun.start()\n"
            "time.sleep(0.3)\nrun.stop()\n",
        ):
            self.in_a_process(text + 'print("lived")')

    def test_waits_in_laws(self):
        """A law that waits for its own run is told so; one may wait for another run, or end it."""
        said = []
        short = self.scene().set({"time.duration": "50 ms"})

        def torques(period):
            if not said:
                try:
                    run.wait()
                except RuntimeError as error:
                    said.append(str(error))
                with thenar.Realtime(short, realtime=False) as other:
                    said.append(other.wait(20.0))
                    said.append(other.wait(0))
            return period.published_torques()

        run = thenar.Realtime(short, realtime=False, torques=torques)
        run.start()
        self.assertTrue(run.wait(30.0))
        self.assertIn("its own run", said[0])
        self.assertEqual(said[1:], [True, True])

    def test_two_wait_for_one_another(self):
        runs = [thenar.Realtime(self.scene().set({"time.duration": "1000 s"}), realtime=False,
                                torques=lambda period, other=other: (runs[other].stop(), period.published_torques())[1])
                for other in (1, 0)]
        for run in runs:
            run.start()
        for run in runs:
            self.assertTrue(run.wait(20.0))

    def test_the_end_of_the_interpreter(self):
        """Threads that nobody waits for may be in a step, a rollout or a run when the interpreter ends."""
        for work in ("simulations[0].step(10**9)", "thenar.rollout(simulations, 10**6, every=10**6)", "thenar.run(scene)"):
            self.in_a_process(
                "simulations = [thenar.Simulation(scene, torques=published) for _ in range(3)]\n"
                f"threading.Thread(target=lambda: {work}, daemon=True).start()\ntime.sleep(0.3)\nprint('lived')")

    def test_laws_that_nobody_asks(self):
        plain = box(control__muscles=False)
        with self.assertRaisesRegex(ValueError, "no muscles"):
            thenar.Simulation(plain, muscles=LAWS["muscles"])

    def test_leaving_stops(self):
        with thenar.Realtime(self.scene().set({"time.duration": "1000 s"}), realtime=False) as run:
            run.wait(0.1)
        self.assertFalse(run.running)
        thenar.Realtime(self.scene())  # never begun


if __name__ == "__main__":
    unittest.main()
