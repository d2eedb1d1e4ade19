# SPDX-License-Identifier: Apache-2.0
"""thenar.gym: an environment as Gymnasium asks for it. Where Gymnasium is missing, a stand-in has what is used of it."""
import os
import pathlib
import subprocess
import sys
import warnings

from support import QUICK, box, np, thenar, unittest

try:
    import gymnasium
    from gymnasium.utils.env_checker import check_env
except ImportError:
    sys.path.insert(0, str(pathlib.Path(__file__).parent / "stand_in"))
    import gymnasium
    check_env = None

import thenar.gym
from thenar.gym import GraspEnv


def quick(**options):
    return GraspEnv(box(), **options)


def draw(rng):
    return {"contact.friction": rng.uniform(0.5, 0.9), "object.mass": f"{rng.uniform(50, 120):.3f} g"}


class Interface(unittest.TestCase):
    def check(self, env):
        """What Gymnasium's check_env asks: types, shapes, spaces, and the same episode for the same seed."""
        self.assertIsInstance(env, gymnasium.Env)
        self.assertIs(env.unwrapped, env)
        env.action_space.seed(5)
        action = env.action_space.sample()
        self.assertIn(action, env.action_space)
        episodes = []
        for seed in (123, 123, 456):
            observation, info = env.reset(seed=seed)
            self.assertIn(observation, env.observation_space)
            self.assertEqual(info["time_s"], 0.0)
            steps = [observation, info]
            for _ in range(3):
                observation, reward, terminated, truncated, info = env.step(action)
                self.assertIn(observation, env.observation_space)
                self.assertEqual(observation.dtype, env.observation_space.dtype)
                self.assertEqual([type(x) for x in (reward, terminated, truncated, info)], [float, bool, bool, dict])
                steps += [observation, reward, terminated, truncated, info]
            episodes.append(steps)
        same = [[np.array_equal(x, y) if isinstance(x, np.ndarray) else x == y for x, y in zip(episodes[0], other)]
                for other in episodes[1:]]
        self.assertTrue(all(same[0]))
        self.assertFalse(all(same[1]), "another seed draws another scene")
        env.reset()
        env.reset(options={})
        env.close()
        env.close()

    def test_is_gymnasiums(self):
        self.check(quick(vary=draw, render_mode="ansi"))

    def test_passes_gymnasiums_check(self):
        if check_env is None:
            self.skipTest("gymnasium is missing: pip install gymnasium")
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            check_env(quick(vary=draw, render_mode="ansi"))
            made = gymnasium.make("thenar/Grasp-v0", scene=box(), render_mode="ansi")
            made.reset(seed=1)
            made.step(made.action_space.sample())
            self.assertTrue(made.render().startswith("0.020 s: "))
            self.assertEqual(made.spec.id, "thenar/Grasp-v0")
            made.close()
        # Forces have no bounds, and an environment that was not made by make() has no spec.
        said = [str(one.message) for one in said if "infinity" not in str(one.message)
                and "not having a spec" not in str(one.message)]
        self.assertEqual(said, [])

    def test_observations_have_names(self):
        env = quick(observation=("time_s", "object", "force_N", "margin", "lost"))
        self.assertEqual(env.observation_names[:3], ("time_s", "object[0,0]", "object[0,1]"))
        self.assertEqual(len(env.observation_names), 1 + 12 + 9 + 3 + 1)
        env.reset()
        first = env.step(np.zeros(6))[0]
        run = env.simulation
        self.assertAlmostEqual(run.time_s, 0.02)
        for name, number in zip(env.observation_names, first):
            field, _, index = name.partition("[")
            value = getattr(run, field)
            self.assertEqual(number, value[tuple(map(int, index[:-1].split(",")))] if index else value, name)
        # The margins of fingers without load are not numbers; in an observation they are 0.
        self.assertEqual(set(env.reset()[0][-4:-1]), {0.0})

    def test_renders_a_line(self):
        env = quick(render_mode="ansi")
        env.reset()
        env.step(np.zeros(6))
        self.assertRegex(env.render(), r"^0\.020 s: held, \d\.\d\d mm off the target; thumb \d\.\d\d N, index ")
        self.assertIsNone(quick().render())
        self.assertEqual(quick(period_s=0.05).metadata["render_fps"], 20)

    def test_says_what_to_install(self):
        program = "import sys; sys.modules['gymnasium'] = None\nimport thenar\nimport thenar.gym"
        result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
        self.assertIn("ImportError: thenar.gym needs Gymnasium, which is not installed: pip install gymnasium",
                      result.stderr)

    def test_bad_input(self):
        for words, options in [
            ("part is one of wrench, forces", {"part": "force"}),
            ("scale is a finite number", {"scale": [1.0, 2.0]}),
            ("scale is a finite number", {"scale": np.nan}),
            ("has no field 'forces_N'", {"observation": ["forces_N"]}),
            ("has no field 'step'", {"observation": ["step"]}),
            ("'contacts' is not made of numbers", {"observation": ["contacts"]}),
            ("no field that has numbers", {"observation": ["q_m"]}),
            ("come together", {"law": lambda period, action: action}),
            ("1 or more", {"law": lambda period, action: action, "actions": 0}),
            ("period_s has to be a tick", {"period_s": 1e-4}),
            ("render_mode is None or 'ansi'", {"render_mode": "human"}),
        ]:
            with self.assertRaisesRegex(ValueError, words):
                quick(**options)
        with self.assertRaisesRegex(ValueError, "torques drive the joints"):
            GraspEnv(box(control__muscles=False), part="muscles")
        env = quick()
        env.reset()
        for action in (np.zeros(5), np.full(6, np.nan), 0.0):
            with self.assertRaisesRegex(ValueError, "6 finite numbers"):
                env.step(action)
        with self.assertRaisesRegex(ValueError, "options has no 'friction': set"):
            env.reset(options={"friction": 0.5})
        with self.assertRaises(thenar.SceneError):
            env.reset(options={"set": {"contact.frction": 0.5}})
        env.step(np.zeros(6))  # What was refused has changed nothing.
        self.assertAlmostEqual(env.simulation.time_s, 0.02)


class Episodes(unittest.TestCase):
    def test_actions_act_through_the_law(self):
        """The bits are those of a Simulation whose law does the same, for each part of the controller."""
        for part, count in (("wrench", 6), ("forces", 9), ("torques", 12), ("muscles", 23)):
            env = quick(part=part)
            self.assertEqual(env.action_space.shape, (count,))
            action = 0.5 * np.cos(np.arange(count))
            scale = np.broadcast_to(thenar.gym.SCALE[part], count)

            def law(period):
                name = "published_muscle_forces" if part == "muscles" else f"published_{part}"
                asked = getattr(period, name)()
                sum_ = asked + (scale * action).reshape(asked.shape)
                return np.maximum(sum_, 0.0) if part == "muscles" else sum_

            run, without = thenar.Simulation(box(), **{part: law}), thenar.Simulation(box())
            env.reset()
            for _ in range(3):
                env.step(action)
            run.step(60)
            without.step(60)
            self.assertTrue(np.array_equal(env.simulation.object, run.object), part)
            self.assertFalse(np.array_equal(run.object, without.object), part)

    def test_a_law_of_ones_own(self):
        """A squeeze as the only number of an action."""
        env = quick(part="forces", actions=1, law=lambda period, action: (1 + action[0]) * period.published_forces())
        env.reset()
        for _ in range(5):
            weak = env.step([0.0])[0]
        env.reset()
        for _ in range(5):
            strong = env.step([1.0])[0]
        load = [i for i, name in enumerate(env.observation_names) if name.startswith("force_N")]
        self.assertGreater(np.linalg.norm(strong[load]), 1.2 * np.linalg.norm(weak[load]))
        env.step([7.0])  # is clipped to 1

    def test_end_at_the_scenes_end(self):
        env = quick(period_s=0.07)
        env.reset()
        ends = [env.step(np.zeros(6))[2:4] for _ in range(5)]  # of 300 ms
        self.assertEqual(ends, [(False, False)] * 4 + [(False, True)])
        self.assertAlmostEqual(env.simulation.time_s, 0.3)

    def test_end_with_the_object_lost(self):
        env = GraspEnv(thenar.Scene("box_grasp", {**QUICK, "time.duration": "3 s", "control.grasp.friction": 0.3}))
        env.reset(options={"set": {"contact.friction": 0.02}})
        terminated = truncated = False
        while not (terminated or truncated):
            _, reward, terminated, truncated, info = env.step(np.zeros(6))
        self.assertEqual((terminated, truncated, reward, info["outcome"]), (True, False, 0.0, "lost"))
        self.assertEqual(info["set"], {"contact.friction": 0.02})
        time_s = info["time_s"]
        self.assertLess(time_s, 2.9)
        self.assertTrue(env.step(np.zeros(6))[2])
        self.assertEqual(env.simulation.time_s, time_s)

    def test_options_are_of_one_episode(self):
        env = quick(vary=lambda rng: {"contact.friction": 0.7, "object.mass": "60 g"})
        env.reset(options={"set": {"contact.friction": 0.6}})
        self.assertEqual((env.simulation.scene.friction, env.simulation.scene.mass_kg), (0.6, 0.06))
        env.reset()
        self.assertEqual(env.simulation.scene.friction, 0.7)
        self.assertNotEqual(env.scene.friction, 0.7)

    def test_reward(self):
        given = []

        def reward(simulation, action):
            given.append((simulation.time_s, action))
            return 3

        env = quick(reward=reward)
        env.reset()
        self.assertEqual(env.step(np.full(6, 2.0))[1], 3.0)
        self.assertAlmostEqual(given[0][0], 0.02)
        self.assertTrue(np.array_equal(given[0][1], np.ones(6)))
        standing = quick()
        standing.reset()
        self.assertGreater(standing.step(np.zeros(6))[1], 0.9)

    def test_looks_ahead(self):
        """A state goes from one environment to another, which then goes on as the first one would."""
        env, ahead = quick(), quick()
        env.reset(seed=1)
        ahead.reset(seed=2)
        env.step(np.full(6, 0.2))
        ahead.simulation.set_state(env.simulation.state())
        action = np.full(6, -0.3)
        self.assertTrue(np.array_equal(ahead.step(action)[0], env.step(action)[0]))

    def test_episodes_are_freed(self):
        """The law that gives the action refers to no simulation, which would keep it for ever."""
        env = quick()
        env.reset()
        size = len(env.simulation.state())
        resident = resident_bytes()
        for _ in range(50):
            env.reset()
            env.step(np.zeros(6))
        self.assertLess(resident_bytes() - resident, 0.5 * 50 * size)


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


if __name__ == "__main__":
    unittest.main()
