# SPDX-License-Identifier: Apache-2.0
"""python/thenar/client.py against the program: client_test.py THENAR-WINDOW CONFIGS [unittest's arguments]"""

import importlib.util
import pathlib
import subprocess
import sys
import unittest

try:
    import numpy as np
except ImportError:
    print("skipped: there is no numpy (Debian: python3-numpy)")
    sys.exit(77)

PATIENCE_S = 60.0  # of what must happen: machines may be slow
TOKEN = "a-token-of-this-test"
PROGRAM, CONFIGS = sys.argv[1:3]

path = pathlib.Path(__file__).parents[2] / "python" / "thenar" / "client.py"
spec = importlib.util.spec_from_file_location("thenar_client", path)
client = importlib.util.module_from_spec(spec)
spec.loader.exec_module(client)


class Client(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # Without its integrals the controller is a spring, of which a steady push is answered by a steady shift.
        cls.program = subprocess.Popen(
            [PROGRAM, "demo", f"{CONFIGS}/box_grasp.yaml", "--port", "0", "--no-browser", "--quiet", "--token", TOKEN,
             "--set", "control.position.i=0 N/(m*s)", "--set", "control.rotation.i=0 N*m/(rad*s)"],
            stdout=subprocess.PIPE, text=True)
        cls.url = cls.program.stdout.readline().strip()
        cls.place = cls.url.split("/")[2]

    @classmethod
    def tearDownClass(cls):
        cls.program.terminate()
        cls.program.wait(PATIENCE_S)
        cls.program.stdout.close()

    def connect(self):
        window = client.connect(self.url, timeout_s=PATIENCE_S)
        self.addCleanup(window.__exit__)
        return window

    def until(self, window, condition):
        """The first of the next states of which it holds."""
        begin_s = None
        for state in window:
            if condition(state):
                return state
            begin_s = state["time_s"][0] if begin_s is None else begin_s
            self.assertLess(state["time_s"][0], begin_s + PATIENCE_S, "nothing happens")

    def test_states_have_what_the_scene_says(self):
        window = self.connect()
        state = self.until(window, lambda state: state["active"][0] > 0)
        self.assertEqual(window.scene["name"], "box grasp")
        self.assertEqual(set(state), {field["name"] for field in window.scene["fields"]} | {"contact"})
        for field in window.scene["fields"]:
            self.assertEqual(state[field["name"]].shape, (field["count"],))
        rows = state["contact"]
        self.assertEqual(rows["point_m"].shape, (int(state["contacts"][0]), 3))
        # Each finger's force is the sum of its contacts': both are of one tick, so they differ by rounding alone.
        for finger in range(3):
            force_N = rows["force_N"][rows["finger"][:, 0] == finger].sum(axis=0)
            np.testing.assert_allclose(force_N, state["force_N"].reshape(-1, 3)[finger], atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(rows["normal"], axis=1), 1.0, atol=1e-12)
        self.assertEqual(window.geometry[:4], b"THNR")
        self.assertTrue(window.status["running"])

    def test_a_pull_moves_the_object(self):
        window = self.connect()
        # The task's own move has ended, and what it left has faded.
        before = self.until(window, lambda state: state["time_s"][0] > 2.5)
        p = window.scene["position_gain_N_per_m"]
        up = before["object"][3:].reshape(3, 3)[:, 1]
        stood = before
        def pulled(state):
            nonlocal stood
            window.send("pull", point_m=np.zeros(3), handle_m=state["object"][:3] + 0.02 * up)
            # At rest when it has stayed within 0.1 mm for 0.3 s. If other work kept this program from repeating the pull in
            # time it has let go: the object moves, and is waited for again.
            away_m = np.linalg.norm((state["object"] - stood["object"])[:3])
            if np.isnan(state["pull_force_N"]).any() or away_m > 1e-4:
                stood = state
            return state["time_s"][0] > stood["time_s"][0] + 0.3
        after = self.until(window, pulled)
        force_N = after["pull_force_N"]
        self.assertGreater(np.linalg.norm(force_N), 1.0)
        moved_m = (after["object"] - before["object"])[:3]
        # The controller is a spring of p N/m: what it pulls back with is the pull. Its steady force error, and what is
        # left of the way, are within 10 %.
        np.testing.assert_allclose(p * moved_m @ force_N, force_N @ force_N, rtol=0.1)
        window.send("release")
        self.until(window, lambda state: np.isnan(state["pull_force_N"]).all())

    def test_orders_are_followed_and_bad_ones_refused(self):
        window = self.connect()
        friction = next(window)["friction"][0]
        window.send("set", friction=1.25)
        self.until(window, lambda state: state["friction"][0] == 1.25)
        window.send("set", friction=friction)
        window.send("set", friction=-1.0)
        with self.assertRaisesRegex(client.WindowError, "friction must lie within"):
            for _ in range(100):
                next(window)
        window.send("pause")
        while not window.status["paused"]:
            next(window)
        window.send("resume")
        self.until(window, lambda state: not window.status["paused"])

    def test_a_message_of_every_length_arrives(self):
        window = self.connect()
        for size in (1, 90, 91, 92, 93, 94, 200, 4000):  # lengths have one form below 126 bytes, and another one
            window.send("x" * size)
            with self.assertRaisesRegex(client.WindowError, "there is no type 'x"):
                for _ in range(100):
                    next(window)

    def test_what_is_wrong_is_said(self):
        with self.assertRaisesRegex(client.WindowError, "must end in the token"):
            client.connect(self.place, "another-token-here")
        with client.connect(self.place, TOKEN, timeout_s=PATIENCE_S) as window:
            self.assertGreater(next(window)["time_s"][0], 0.0)
        with self.assertRaisesRegex(client.WindowError, "no window is there"):
            client.connect("127.0.0.1:1", TOKEN)
        with self.assertRaisesRegex(client.WindowError, "no window is there"):
            client.connect("127.0.0.1:port", TOKEN)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
