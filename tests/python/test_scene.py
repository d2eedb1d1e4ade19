# SPDX-License-Identifier: Apache-2.0
"""Scenes: names, changes, and every fault with its place."""
import copy
import os
import pathlib
import pickle
import subprocess
import tempfile
import time

from support import PROGRAM, box, np, thenar, unittest


class Build(unittest.TestCase):
    def test_is_that_of_the_program(self):
        said = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout
        self.assertEqual(said.splitlines()[:2], [f"thenar {thenar.__version__}", f"  commit  {thenar.__commit__}"])


class Scenes(unittest.TestCase):
    def test_those_that_come_with_it_load(self):
        self.assertIn("box_grasp", thenar.scenes())
        self.assertIn("leap", thenar.hands())
        scene = thenar.Scene("box_grasp")
        self.assertEqual(scene.fingers, ["thumb", "index", "major"])
        self.assertEqual((len(scene.joints), len(scene.muscles)), (12, 23))

    def test_set_changes_nothing_but_its_copy(self):
        scene = box()
        heavier = scene.set({"object.mass": "150 g", "contact.friction": np.float64(0.7)})
        self.assertEqual(heavier.mass_kg, 0.15)
        self.assertEqual(heavier.friction, 0.7)
        self.assertNotEqual(scene.mass_kg, 0.15)
        self.assertIn("object.mass=150 g", heavier.changes)

    def test_is_its_own_copy(self):
        scene = box()
        self.assertIs(copy.copy(scene), scene)
        self.assertIs(copy.deepcopy({"scene": scene})["scene"], scene)

    def test_set_after_a_start_is_the_same_scene(self):
        """What a scene has made serves a changed one, and makes no difference to it."""
        first = thenar.Scene("box_grasp", {"object.points": 3000})
        first.prepare()
        for change in ({"contact.friction": 0.5}, {"fingertips.leaves": 160}, {"object.points": 2500}):
            fresh = thenar.Simulation(thenar.Scene("box_grasp", {"object.points": 3000, **change}))
            taken = thenar.Simulation(first.set(change))
            fresh.step(50)
            taken.step(50)
            self.assertTrue((fresh.force_N == taken.force_N).all(), change)
            self.assertTrue((fresh.object == taken.object).all(), change)

    def test_scenes_share_their_surface(self):
        """What one scene has made serves each other one with the same object, whether or not it came of it by set():
        to make a simulation of another friction takes a small part of the time of the first one."""
        points = {"object.points": 20011}  # No other test has this surface.
        scene = thenar.Scene("box_grasp", points)
        times_s = []
        for friction in (0.5, 0.6, 0.7, 0.8):
            begin_s = time.process_time()
            thenar.Simulation(scene.set({"contact.friction": friction}))
            times_s.append(time.process_time() - begin_s)
        begin_s = time.process_time()
        thenar.Simulation(thenar.Scene("box_grasp", points))
        times_s.append(time.process_time() - begin_s)
        self.assertLess(max(times_s[1:]), 0.3 * times_s[0])  # It is 0.02 of it: the copy of some megabytes.

    def test_a_mesh_that_changes_is_read_again(self):
        """The name of a file is not its surface."""
        with tempfile.TemporaryDirectory() as folder:
            mesh = pathlib.Path(folder, "box.obj")

            def load_on(size_mm):
                half_mm = size_mm / 2
                corners = [(x, y, z) for x in (-half_mm, half_mm) for y in (-25, 25) for z in (-25, 25)]
                faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
                mesh.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners)
                                + "".join(f"f {face}\n" for face in faces))
                scene = thenar.Scene("box_grasp", {"object.shape": {"cloud": {"file": mesh, "unit": "1 mm"}},
                                                   "object.points": 3000})
                run = thenar.Simulation(scene)
                run.step(5)
                return run.normal_N.sum()

            wide, narrow, again = load_on(50), load_on(40), load_on(50)
            self.assertGreater(wide, 0.1)
            self.assertEqual(narrow, 0.0)  # The fingers do not reach it.
            self.assertEqual(again, wide)

    def test_values_of_all_kinds(self):
        scene = box()
        self.assertEqual(scene.set({"name": "x"}).name, "x")
        self.assertEqual(scene.set({"control.muscles": False}).muscles, [])
        scene.set({"object.shape": {"box": ["50 mm", "60 mm", "40 mm"]}})
        scene.set({"object.points": np.int64(3000)})
        scene.set({"gravity": ("0 m/s^2", "0 m/s^2", "-9.81 m/s^2")})

    def test_values_without_end(self):
        """Lists may contain themselves, or one another many times: no stack and no memory is big enough for that."""
        ring, deep, wide = {}, [], ["x"]
        ring["a"] = ring
        for _ in range(100_000):
            deep = [deep]
        for _ in range(30):
            wide = [wide, wide]
        for value in (ring, deep, wide):
            with self.assertRaisesRegex(ValueError, "task is (nested|longer)"):
                thenar.Scene("minimal", {"task": value})

    def test_half_a_character(self):
        for changes in ({"name": "\ud800"}, {"\ud800": 1}, {"object.shape": {"box": "\udfff"}}, {"task": {"\ud800": 1}}):
            with self.assertRaisesRegex(ValueError, "no text"):
                thenar.Scene("minimal", changes)
        with self.assertRaisesRegex(ValueError, "no text"):
            thenar.sweep(thenar.Scene("minimal"), {"name": "\ud800"})

    def test_never_made(self):
        """An instance that no constructor has made is refused, not read."""
        for kind in (thenar.Simulation, thenar.Scene, thenar.Realtime, thenar.Recording, thenar.Grasp, thenar.Period):
            names = [name for name in dir(kind) if not name.startswith("__") or name in ("__repr__", "__len__")
                     and getattr(kind, name) is not getattr(object, name, None)]
            for name in names:
                with self.assertRaises(TypeError):
                    value = getattr(kind.__new__(kind), name)
                    value() if callable(value) else value

        class Early(thenar.Simulation):
            def __init__(self, scene):
                self.early = self.time_s

        with self.assertRaises(TypeError):
            Early(box())

    def test_faults_have_places(self):
        with tempfile.TemporaryDirectory() as folder:
            text = pathlib.Path(thenar.Scene("minimal").file).read_text()
            file = pathlib.Path(folder, "mine.yaml")
            line = next(i for i, row in enumerate(text.splitlines(), 1) if row.startswith("contact:"))
            file.write_text(text.replace("contact:", "contct:", 1))
            with self.assertRaises(thenar.SceneError) as caught:
                thenar.Scene(file)
        error = caught.exception
        self.assertIsInstance(error, ValueError)
        self.assertEqual((error.file, error.line, error.key), (os.fspath(file), line, "contct"))
        self.assertIn("did you mean 'contact'?", str(error))
        self.assertTrue(all(isinstance(one, thenar.Diagnostic) for one in error.diagnostics))

    def test_faults_of_set(self):
        scene = box()
        for changes, words in [
            ({"object.mass": 0.15}, "0.15 has no unit"),
            ({"object.mas": "150 g"}, "did you mean 'object.mass'"),
            ({"object.mass": "-1 g"}, "greater than zero"),
            ({"contact.friction": "nan"}, "contact.friction"),
            ({"object.points": 2.5}, "object.points"),
        ]:
            with self.assertRaisesRegex(thenar.SceneError, words) as caught:
                scene.set(changes)
            self.assertIsNone(caught.exception.line)
        for changes, kind in [({3: 4}, TypeError), ({"contact.friction": None}, TypeError),
                              ({"contact.friction": float("nan")}, ValueError), ({"name": object()}, TypeError)]:
            with self.assertRaises(kind):
                scene.set(changes)

    def test_faults_travel(self):
        """Between processes, as errors of workers do."""
        with self.assertRaises(thenar.SceneError) as caught:
            box().set({"object.mass": "1 m"})
        again = pickle.loads(pickle.dumps(caught.exception))
        self.assertEqual((str(again), again.key), (str(caught.exception), "object.mass"))

    def test_files(self):
        with self.assertRaisesRegex(thenar.FileError, "did you mean 'box_grasp'"):
            thenar.Scene("box_gasp")
        with self.assertRaises(OSError):
            thenar.Scene("nowhere/scene.yaml")


class Grasps(unittest.TestCase):
    def test_found_holds(self):
        """What the finder offers holds in a run, as its own trial said."""
        found = thenar.grasp(thenar.Scene("box_grasp", {"object.points": 6000, "time.duration": "500 ms"}))
        self.assertEqual(len(found), 1)
        grasp = found[0]
        self.assertGreaterEqual(len(grasp.fingers), 2)
        self.assertEqual(grasp.points_m.shape, (len(grasp.fingers), 3))
        self.assertIn("margin", str(grasp))
        self.assertIn(f"{1e3 * grasp.width_m:.1f} mm", str(grasp))
        self.assertGreater(grasp.press_N, 0)
        scene = grasp.scene()
        self.assertEqual(thenar.run(scene).outcome, "held")
        self.assertEqual(scene.set({"object.mass": "20 g"}).mass_kg, 0.02)

    def test_none(self):
        with self.assertRaisesRegex(thenar.NoGrasp, "wide"):
            thenar.grasp(thenar.Scene("box_grasp", {"object.shape": {"box": ["200 mm"] * 3}, "object.points": 6000,
                                                    "object.position": ["90 mm", "0 mm", "200 mm"]}))


if __name__ == "__main__":
    unittest.main()
