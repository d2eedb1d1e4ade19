"""Recordings: what a run shows is what is read back."""
import os
import tempfile

from support import box, np, thenar, unittest


class Recordings(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.file = os.path.join(cls.folder.name, "box.mcap")
        cls.run_ = thenar.run(box(), record=cls.file)
        cls.recording = thenar.Recording(cls.file)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_states_are_the_runs(self):
        """Fifty a second, and their numbers are those that a simulation has at those times, to the last bit."""
        recording = self.recording
        self.assertEqual(len(recording), 15)
        self.assertEqual(recording.fingers, ["thumb", "index", "major"])
        again = thenar.Simulation(box())
        for i, time_s in enumerate(recording.time_s):
            again.run(until=float(time_s))
            self.assertTrue(np.array_equal(recording["q_rad"][i], again.q_rad))
            self.assertTrue(np.array_equal(recording["object"][i], again.object))
            self.assertTrue(np.array_equal(recording["force_N"][i], again.force_N))
            self.assertTrue(np.array_equal(recording["margin"][i], again.margin, equal_nan=True))
            rows = recording.contacts["time_s"] == time_s
            self.assertTrue(np.array_equal(recording.contacts["force_N"][rows], again.contacts["force_N"]))

    def test_names(self):
        self.assertIn("slip_m", self.recording)
        self.assertIn("residual", self.recording.keys())
        with self.assertRaisesRegex(KeyError, "did you mean 'slip_m'"):
            self.recording["slips_m"]

    def test_cut_off(self):
        """Wherever it was cut off, the states that are whole are there; before the first one it is refused."""
        with open(self.file, "rb") as file:
            whole = file.read()
        for size in (len(whole) // 2, len(whole) - 1, 9):
            cut = os.path.join(self.folder.name, "cut.mcap")
            with open(cut, "wb") as file:
                file.write(whole[:size])
            try:
                states = thenar.Recording(cut)
                self.assertTrue(np.array_equal(states["q_rad"], self.recording["q_rad"][: len(states)]))
            except thenar.FileError as error:
                self.assertTrue(str(error))

    def test_is_none(self):
        for name in ("nowhere.mcap", __file__):
            with self.assertRaises(thenar.FileError):
                thenar.Recording(name)


if __name__ == "__main__":
    unittest.main()
