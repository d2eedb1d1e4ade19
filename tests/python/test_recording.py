# SPDX-License-Identifier: Apache-2.0
"""Recordings: what a run shows is what is read back."""
import base64
import html
import json
import os
import pathlib
import re
import struct
import tempfile

from support import box, np, thenar, unittest, wet


def odd_recording(contact_fields, numbers):
    """An MCAP file with one state, of which nothing is known but its time and its contacts."""

    def record(kind, content):
        return bytes([kind]) + struct.pack("<Q", len(content)) + content

    def text(words):
        return struct.pack("<I", len(words)) + words.encode()

    scene = dict(name="odd", fingers=[], joints=[], muscles=[], contact_fields=contact_fields)
    scene["fields"] = [dict(name="time_s", unit="s", begin=0, count=1)]
    whole = b"\x89MCAP0\r\n" + record(1, text("") + text("odd"))
    for channel, topic in ((1, "/scene"), (2, "/state")):
        whole += record(4, struct.pack("<HH", channel, 0) + text(topic) + text("json") + struct.pack("<I", 0))
    state = b"THNR" + struct.pack("<HH", 1, 2) + struct.pack(f"<{len(numbers)}d", *numbers)
    for channel, content in ((1, json.dumps(scene).encode()), (2, state)):
        whole += record(5, struct.pack("<HIQQ", channel, 0, 0, 0) + content)
    return whole


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

    def test_touch(self):
        """What fingertips feel is recorded where a scene names it."""
        file = os.path.join(self.folder.name, "wet.mcap")
        scene = wet(time__duration="100 ms")
        thenar.run(scene, record=file)
        recording = thenar.Recording(file)
        again = thenar.Simulation(scene)
        again.run(until=float(recording.time_s[-1]))
        for name in ("stick", "rim_friction", "slip_speed_m_per_s", "torsion_Nm", "friction_felt", "squeeze_N"):
            self.assertTrue(np.array_equal(recording[name][-1], getattr(again, name), equal_nan=True), name)
        self.assertNotIn("stick", self.recording)

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

    def test_contacts_of_ticks(self):
        """Every contact of every tick, whose forces are those of the simulation's contacts in their axes."""
        file = os.path.join(self.folder.name, "ticks.mcap")
        thenar.run(box(), record=file, record_contacts=True, record_rate=20, record_fields=["time_s", "margin"])
        recording = thenar.Recording(file)
        self.assertEqual(recording.keys(), ["time_s", "tick", "margin"])
        self.assertEqual(len(recording), 6)
        rows = recording.tick_contacts
        self.assertEqual(len(np.unique(rows["time_s"].round(9))), 300)
        simulation = thenar.Simulation(box())
        for time_s in (0.1, 0.3):
            simulation.run(until=time_s)
            now = rows[np.isclose(rows["time_s"], time_s, rtol=0, atol=1e-6)]
            contacts = simulation.contacts
            self.assertEqual(len(now), len(contacts))
            self.assertTrue(np.array_equal(now["control_point"], contacts["control_point"]))
            # The axes are those of the block's first tick, and floats: 1e-3 of a finger's force.
            normal = np.einsum("ij,ij->i", contacts["force_N"], contacts["normal"])
            self.assertLess(np.abs(now["force_N"][:, 0] - normal).max(), 1e-3)

    def test_settings_that_are_none(self):
        file = os.path.join(self.folder.name, "none.mcap")
        for settings, words in [
            (dict(record_rate=0), "within 0.1"),
            (dict(record_rate="3 kg"), "record_rate"),
            (dict(record_rate=True), "number"),
            (dict(record_fields=[1]), "list of names"),
            (dict(record_fields=[]), "no field"),
            (dict(record_rate=2000), "1000 Hz"),
            (dict(record_rate=float("nan")), "record_rate"),
            (dict(record_fields=["q_red"]), "q_rad"),
            (dict(record_fields="q_rad"), "list"),
        ]:
            with self.assertRaisesRegex((ValueError, TypeError), words):
                thenar.run(box(), record=file, **settings)
        self.assertFalse(os.path.exists(file))
        with self.assertRaisesRegex(ValueError, "need record"):
            thenar.run(box(), record_contacts=True)

    def test_notebook(self):
        """The page with the recording, and with a simulation's instant, which a step later does not change."""
        if not (pathlib.Path(thenar.__file__).parent / "share" / "page.html").exists():
            self.assertIn("is missing", self.recording._repr_html_())
            self.skipTest("the page was not built")
        frame = self.recording._repr_html_()
        self.assertRegex(frame, r'^<iframe srcdoc="[^"]*" style="[^"]*"></iframe>$')
        simulation = thenar.Simulation(box())
        simulation.step(10)
        frame = simulation._repr_html_()
        simulation.step(10)
        text = re.search(r'id="recording" type="text/plain">([^<]*)<', html.unescape(frame)).group(1)
        file = os.path.join(self.folder.name, "now.mcap")
        with open(file, "wb") as to:
            to.write(base64.b64decode(text))
        shown = thenar.Recording(file)
        self.assertEqual(shown.time_s.tolist(), [0.01])
        os.remove(file)
        self.assertRegex(shown._repr_html_(), "^<pre>.*is gone")
        simulation.close()
        self.assertRegex(simulation._repr_html_(), "^<pre>.*closed")

    def test_others_of_our_names(self):
        """A recording whose fields have our names and other sizes, or lie nowhere: NaN, or refused."""
        for fields, numbers in [
            ([("a", 0, 1000), ("force_N", 1000, 1)], 1001),
            ([("force_N", 0, 1)], 1),
            ([("a", 0, 1), ("force_N", 2**64 - 80000, 80000)], 1),
        ]:
            contact_fields = [dict(name=n, unit="", begin=b, count=c) for n, b, c in fields]
            file = os.path.join(self.folder.name, "odd.mcap")
            with open(file, "wb") as to:
                to.write(odd_recording(contact_fields, [0.0] + [7.0] * numbers))
            try:
                contacts = thenar.Recording(file).contacts
            except thenar.FileError:
                continue
            self.assertTrue(np.isnan(contacts["force_N"]).all())
            self.assertTrue((contacts["control_point"] == -1).all())

    def test_is_none(self):
        for name in ("nowhere.mcap", __file__):
            with self.assertRaises(thenar.FileError) as raised:
                thenar.Recording(name)
            self.assertEqual(raised.exception.filename, name)
            self.assertIn(name, str(raised.exception))


if __name__ == "__main__":
    unittest.main()
