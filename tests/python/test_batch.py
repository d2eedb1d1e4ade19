# SPDX-License-Identifier: Apache-2.0
"""Many runs at once, and the small problems."""
import os
import signal
import threading

from support import box, np, thenar, unittest


class Rollouts(unittest.TestCase):
    def test_are_steps(self):
        """Whatever the threads, the bits are those of steps."""
        start = thenar.Simulation(box())
        start.step(60)
        runs = [start.copy() for _ in range(5)]
        for i, run in enumerate(runs):
            run.input_wrench = [0.02 * i, 0, 0, 0, 0, 0]
        alone = [run.copy() for run in runs]
        for threads in (1, 3):
            kept = thenar.rollout([run.copy() for run in runs], 40, every=10, threads=threads,
                                  signals=["time_s", "object", "force_N", "muscles_N"])
            self.assertEqual(kept["object"].shape, (5, 4, 4, 4))
            self.assertEqual(kept["force_N"].shape, (5, 4, 3, 3))
            self.assertEqual(kept["time_s"].shape, (5, 4))
            for i, run in enumerate(alone):
                steps = run.copy()
                for sample in range(4):
                    steps.step(10)
                    self.assertTrue(np.array_equal(kept["object"][i, sample], steps.object))
                    self.assertTrue(np.array_equal(kept["force_N"][i, sample], steps.force_N))

    def test_ctrl_c_between_samples(self):
        """However rare the samples are."""
        run = thenar.Simulation(box())
        threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            thenar.rollout([run], 2**62, every=2**61)
        run.step()

    def test_bad_input(self):
        run = thenar.Simulation(box())
        for kind, words, act in [
            (ValueError, "keeps no 'slips'", lambda: thenar.rollout([run], 10, signals=["slips"])),
            (ValueError, "divide", lambda: thenar.rollout([run], 10, every=3)),
            (ValueError, "0 or more", lambda: thenar.rollout([run], -1)),
            (ValueError, "threads", lambda: thenar.rollout([run], 10, threads=0)),
            (RuntimeError, "being stepped", lambda: thenar.rollout([run, run], 10)),
            (TypeError, "", lambda: thenar.rollout([3], 10)),
            (TypeError, "", lambda: thenar.rollout([None], 10)),
        ]:
            with self.assertRaisesRegex(kind, words):
                act()
        run.step()
        self.assertEqual(thenar.rollout([], 10)["time_s"].shape, (0, 10))


class Sweeps(unittest.TestCase):
    def test_rows_are_runs(self):
        rows = thenar.sweep(box(), {"contact.friction": [0.4, 0.8], "object.mass": ["30 g", "-1 g"]})
        self.assertEqual([row["outcome"] for row in rows], ["held", "refused", "held", "refused"])
        run = thenar.run(box(contact__friction=0.8, object__mass="30 g"))
        self.assertEqual(rows[2]["final_error_mm"], run.summary["object"]["final_error_mm"])
        self.assertEqual((rows[2]["contact.friction"], rows[2]["object.mass"]), (0.8, "30 g"))
        self.assertEqual(len(thenar.sweep(box(), {"object.mass": "20 g:60 g:3"})), 3)
        rows = thenar.sweep(box(), {"contact.friction": [0.8, "0.8"], "contact.tolerance": [1e-6, 1e-7, 1e-8]})
        self.assertEqual([row["contact.friction"] for row in rows], 3 * [0.8] + 3 * ["0.8"])
        self.assertEqual([row["contact.tolerance"] for row in rows], 2 * [1e-6, 1e-7, 1e-8])

    def test_bad_input(self):
        with self.assertRaises(thenar.SceneError):
            thenar.sweep(box(), {"object.mas": ["30 g"]})
        with self.assertRaisesRegex(ValueError, "over nothing"):
            thenar.sweep(box(), {"object.mass": []})
        with self.assertRaisesRegex(TypeError, "contact.friction takes a list"):
            thenar.sweep(box(), {"contact.friction": 0.5})


class Problems(unittest.TestCase):
    def test_one_contact(self):
        """W = w I, pressed by g: f_n = g / w; a slip beyond the cone slides with f_t = mu f_n against it."""
        w, g = 2.0, 1e-3
        for method in ("newton", "gauss_seidel"):
            stuck = thenar.solve.contact(w * np.eye(3), [-g, 0.1 * g, 0], 0.5, method=method)
            self.assertEqual(stuck.status, "converged")
            np.testing.assert_allclose(stuck.force_N, [[g / w, -0.1 * g / w, 0]], atol=1e-8 * g / w)
            slides = thenar.solve.contact(w * np.eye(3), [-g, 3 * g, 0], 0.5, method=method)
            np.testing.assert_allclose(slides.force_N, [[g / w, -0.5 * g / w, 0]], rtol=1e-6)
            self.assertEqual(thenar.solve.contact(w * np.eye(3), [g, g, 0], 0.5, method=method).force_N.any(), False)

    def test_no_solution_is_proved(self):
        """Two rigid contacts that press against one another and nothing moves: y proves it, y >= 0, W y = 0, y.d < 0."""
        W = np.zeros((6, 6))
        W[[0, 0, 3, 3], [0, 3, 0, 3]] = [1, -1, -1, 1]
        for i in (1, 2, 4, 5):
            W[i, i] = 1
        free = [-1e-3, 0, 0, -1e-3, 0, 0]
        answer = thenar.solve.contact(W, free, 0.0)
        self.assertEqual(answer.status, "no solution")
        np.testing.assert_allclose(answer.certificate, [1, 1], atol=1e-6)

    def test_grasp_forces(self):
        """Two fingers that face each other bear a weight by friction alone: f_t = w / 2 each, inside the cones."""
        axes = np.array([np.c_[[1, 0, 0], [0, 1, 0], [0, 0, 1]], np.c_[[-1, 0, 0], [0, -1, 0], [0, 0, 1]]], float)
        points = [[-0.02, 0, 0], [0.02, 0, 0]]
        answer = thenar.solve.grasp(points, axes, [0, 0, 1, 0, 0, 0], friction=0.5, internal_force_N=2.0)
        self.assertEqual(answer.status, "optimal")
        np.testing.assert_allclose(answer.force_N[:, 2], 0.5, atol=1e-9)
        self.assertLessEqual((np.linalg.norm(answer.force_N[:, 1:], axis=1) / np.abs(answer.force_N[:, 0])).max(), 0.5 + 1e-9)
        none = thenar.solve.grasp(points, axes, [0, 0, 0, 1, 0, 0], friction=0.5, internal_force_N=2.0)
        self.assertEqual(none.status, "infeasible")

    def test_grasp_forces_of_contacts_that_differ(self):
        """The second finger slips first: N = w / (2 mu_2) = 5, which is more than the mean squeeze of 4."""
        axes = np.array([np.c_[[1, 0, 0], [0, 1, 0], [0, 0, 1]], np.c_[[-1, 0, 0], [0, -1, 0], [0, 0, 1]]], float)
        points, wrench = [[-0.02, 0, 0], [0.02, 0, 0]], [0, 0, 1, 0, 0, 0]
        for cone in ("exact", "pyramid"):
            answer = thenar.solve.grasp(points, axes, wrench, friction=[0.5, 0.1], internal_force_N=[6, 2.0], cone=cone)
            self.assertEqual(answer.status, "optimal")
            np.testing.assert_allclose(answer.force_N, [[5, 0, 0.5], [-5, 0, 0.5]], atol=1e-9)
            one = thenar.solve.grasp(points, axes, wrench, friction=np.float32(0.5), internal_force_N=2, cone=cone)
            each = thenar.solve.grasp(points, axes, wrench, friction=np.full(2, 0.5), internal_force_N=(2, 2), cone=cone)
            np.testing.assert_array_equal(each.force_N, one.force_N)
            np.testing.assert_array_equal(each.multiplier, one.multiplier)
        without = thenar.solve.grasp(points, axes, wrench, friction=[0.5, 0.0], internal_force_N=1.0)
        self.assertEqual(without.status, "infeasible")

    def test_muscles(self):
        """A joint between two muscles: one pulls, the other rests."""
        answer = thenar.solve.muscles([[0.01, -0.02]], [0.1])
        np.testing.assert_allclose(answer.force_N, [10.0, 0.0], atol=1e-12)
        self.assertEqual(thenar.solve.muscles([[0.01, 0.02]], [-0.1]).status, "infeasible")

    def test_muscle_limits(self):
        """The stronger arm is at its limit, the other gives the rest; then both are too weak."""
        answer = thenar.solve.muscles([[0.02, 0.01]], [0.5], limit_N=[15.0, np.inf])
        np.testing.assert_allclose(answer.force_N, [15.0, 20.0], atol=1e-12)
        self.assertEqual(thenar.solve.muscles([[0.02, 0.01]], [1.0], limit_N=[15.0, 30.0]).status, "infeasible")

    def test_stiff_muscles(self):
        """One joint between two muscles, an object on a spring behind it: K_o = 100 - 100^2 / (100 + m)."""
        one = dict(finger_joints=[1], turn_m=[[0.0, 0.0]], fibre_per_m=[400.0, 400.0], D=[[100.0 * 0.1**2]],
                   A=np.diag([100.0, 1.0, 1.0, 1.0, 1.0, 1.0]), B=np.eye(6, 1) * 10.0)
        wanted = np.diag([20.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        answer = thenar.solve.stiff_muscles([[0.01, -0.01]], [0.1], K_des=wanted, **one)
        self.assertEqual(answer.status, "optimal")
        # 100 - 100 / (1 + M) = 20, M = 0.25 = 400 * 1e-4 (f_0 + f_1), f_0 - f_1 = 10 would give M = 0.4: stiff enough.
        np.testing.assert_allclose(answer.force_N, [10.0, 0.0], atol=1e-9)
        wanted[0, 0] = 50.0
        answer = thenar.solve.stiff_muscles([[0.01, -0.01]], [0.1], K_des=wanted, **one)
        # M = 1: f_0 + f_1 = 25.
        np.testing.assert_allclose(answer.force_N, [17.5, 7.5], atol=1e-6)
        np.testing.assert_allclose(answer.stiffness[0, 0], 50.0, rtol=1e-9)
        wanted[0, 0] = 120.0
        answer = thenar.solve.stiff_muscles([[0.01, -0.01]], [0.1], K_des=wanted, limit_N=[100.0, 100.0], **one)
        self.assertEqual(answer.status, "infeasible")
        self.assertGreaterEqual(answer.lacking_N_per_m, 20.0)
        np.testing.assert_allclose(np.abs(answer.lacking_direction), np.eye(6)[0], atol=1e-6)

    def test_bad_input(self):
        eye = np.eye(3)
        for kind, words, act in [
            (ValueError, "three rows a contact", lambda: thenar.solve.contact(np.eye(4), np.zeros(4), 0.5)),
            (ValueError, "three rows a contact", lambda: thenar.solve.contact(np.ones((3, 6)), np.zeros(3), 0.5)),
            (ValueError, "delta_free has the shape", lambda: thenar.solve.contact(eye, [0], 0.5)),
            (ValueError, "less than 0", lambda: thenar.solve.contact(eye, [0] * 3, -1.0)),
            (ValueError, "no method 'lemke'", lambda: thenar.solve.contact(eye, [0] * 3, 0.5, method="lemke")),
            (ValueError, "not finite", lambda: thenar.solve.contact(eye * np.nan, [0] * 3, 0.5)),
            (TypeError, "must be numbers", lambda: thenar.solve.contact("W", [0] * 3, 0.5)),
            (ValueError, "contacts", lambda: thenar.solve.contact(np.zeros((9000, 9000), np.float32), [0] * 9000, 0.5)),
            (ValueError, "orthonormal", lambda: thenar.solve.grasp([[0, 0, 0]], [2 * eye], [0] * 6, friction=1, internal_force_N=1)),
            (ValueError, "no cone", lambda: thenar.solve.grasp([[0, 0, 0]], [eye], [0] * 6, friction=1, internal_force_N=1, cone="x")),
            (ValueError, "friction has the shape", lambda: thenar.solve.grasp([[0, 0, 0]], [eye], [0] * 6, friction=[1, 1], internal_force_N=1)),
            (ValueError, "friction is less than 0", lambda: thenar.solve.grasp([[0, 0, 0]], [eye], [0] * 6, friction=[-1], internal_force_N=1)),
            (ValueError, "internal_force_N.* not finite", lambda: thenar.solve.grasp([[0, 0, 0]], [eye], [0] * 6, friction=1, internal_force_N=[np.inf])),
            (TypeError, "friction must be", lambda: thenar.solve.grasp([[0, 0, 0]], [eye], [0] * 6, friction="1", internal_force_N=1)),
            (ValueError, "muscles", lambda: thenar.solve.muscles(np.ones((40, 3)), np.ones(40))),
        ]:
            with self.assertRaisesRegex(kind, words):
                act()


if __name__ == "__main__":
    unittest.main()
