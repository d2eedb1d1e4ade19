# SPDX-License-Identifier: Apache-2.0
"""What `thenar export` makes of a recording, as NumPy and a reader of OpenSim's storages have it: python3 tables_test.py
THENAR CONFIGS. Ends with 77 where there is no NumPy (Debian: python3-numpy)."""

import csv
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

try:
    import numpy as np
except ImportError:
    print("skipped: no NumPy here")
    sys.exit(77)

PROGRAM, CONFIGS = sys.argv[1:3]


def thenar(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True, text=True)


def read_storage(file):
    """(header, names, rows) of a storage: `key=value` lines and words up to `endheader`, names, numbers."""
    lines = file.read_text(encoding="utf-8").splitlines()
    end = lines.index("endheader")
    header = dict(line.split("=", 1) for line in lines[:end] if "=" in line)
    rows = np.array([[float(cell) for cell in line.split("\t")] for line in lines[end + 2:]])
    return header, lines[end + 1].split("\t"), rows


class Tables(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        folder = Path(cls.folder.name)
        film = folder / "film.mcap"
        thenar("run", Path(CONFIGS) / "box_grasp.yaml", "--time", "0.4 s", "--record", film, "--record-rate", "200",
               "--record-contacts", "--quiet")
        thenar("export", film, "--npz", folder / "film.npz", "--sto", folder / "film.sto", "--csv", folder / "film.csv")
        # Without pickle: numbers and names alone.
        cls.arrays = np.load(folder / "film.npz", allow_pickle=False)
        cls.storage = read_storage(folder / "film.sto")
        with open(folder / "film.csv", encoding="utf-8", newline="") as table:
            cls.table = list(csv.DictReader(table))

    @classmethod
    def tearDownClass(cls):
        cls.arrays.close()
        cls.folder.cleanup()

    def test_every_array_is_read_and_has_a_row_a_state(self):
        of_states = [name for name in self.arrays.files if not name.startswith(("contact_t", "contact_f", "contact_p",
                     "contact_n", "contact_c", "contact_s", "tick_contact_")) and not name.endswith("_names")]
        self.assertGreater(len(of_states), 60)
        for name in of_states:
            self.assertEqual(self.arrays[name].shape[0], 80, name)  # 0.4 s at 200 Hz
            self.assertEqual(self.arrays[name].dtype, np.float64, name)
        np.testing.assert_allclose(self.arrays["time_s"], np.arange(1, 81) / 200, atol=1e-12)

    def test_names_say_whose_numbers_they_are(self):
        self.assertEqual(list(self.arrays["finger_names"]), ["thumb", "index", "major"])
        self.assertEqual(len(self.arrays["joint_names"]), self.arrays["q_rad"].shape[1])
        self.assertEqual(len(self.arrays["muscle_names"]), self.arrays["muscles_N"].shape[1])

    def test_numbers_are_those_of_the_table(self):
        for i, finger in enumerate(self.arrays["finger_names"]):
            column = np.array([float(row[f"{finger}_normal_N"]) for row in self.table])
            np.testing.assert_array_equal(self.arrays["normal_N"][:, i], column)

    def test_contacts_of_a_state_are_those_of_its_tick(self):
        arrays = self.arrays
        self.assertEqual(arrays["contact_time_s"].shape[0], arrays["contacts"].sum())
        for time_s in arrays["time_s"][[9, 40, 79]]:
            state = np.isclose(arrays["contact_time_s"], time_s, atol=1e-9)
            tick = np.isclose(arrays["tick_contact_time_s"], time_s, atol=1e-9)
            self.assertGreater(state.sum(), 10)
            np.testing.assert_array_equal(arrays["contact_control_point"][state],
                                          arrays["tick_contact_control_point"][tick])
            # Axes are those of the frame's first tick; the normal part is as good as single precision.
            normal_N = np.sum(arrays["contact_force_N"][state] * arrays["contact_normal"][state], axis=1)
            np.testing.assert_allclose(arrays["tick_contact_force_N"][tick][:, 0], normal_N, atol=1e-6)

    def test_every_tick_has_its_contacts(self):
        times_s = np.unique(np.round(self.arrays["tick_contact_time_s"], 9))
        np.testing.assert_allclose(times_s, np.arange(1, 401) * 1e-3, atol=1e-9)

    def test_a_storage_says_what_it_holds(self):
        header, names, rows = self.storage
        self.assertEqual(header["inDegrees"], "no")
        self.assertEqual((int(header["nRows"]), int(header["nColumns"])), rows.shape)
        self.assertEqual(names, ["time", *self.arrays["joint_names"], *self.arrays["muscle_names"]])
        self.assertEqual(len(set(names)), len(names))
        self.assertTrue(np.all(np.diff(rows[:, 0]) > 0))
        np.testing.assert_array_equal(rows[:, 1:13], self.arrays["q_rad"])
        np.testing.assert_array_equal(rows[:, 13:], self.arrays["muscles_N"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
