# SPDX-License-Identifier: Apache-2.0
"""Learning to grip: how hard to squeeze a box whose friction and mass are others in each episode.

The policy has two numbers, a squeeze and how it rises as a finger's margin falls. A cross-entropy search finds what
holds the box without pressing more than it takes. Draws how the reward grows. Needs Gymnasium: pip install gymnasium
"""
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import thenar
import thenar.gym

GENERATIONS, EPISODES, BEST = 6, 8, 3
MOST_N = 4.0
SCENE = thenar.Scene("box_grasp", {"object.points": 6000, "time.duration": "500 ms", "task": {},
                                   "control.grasp.internal_force": "1 N", "control.muscles": False})


def squeeze(period: thenar.Period, action: NDArray[np.float64]) -> NDArray[np.float64]:
    """The published forces, and up to MOST_N more by which the thumb and the two fingers press against each other."""
    forces = period.published_forces()
    more_N = MOST_N * max(float(action[0]), 0.0) * np.array([[1.0], [0.5], [0.5]])
    return more_N * period.normal + (0.0 if forces is None else forces)


def gentle(simulation: thenar.Simulation, action: NDArray[np.float64]) -> float:
    """1 for a box at its place, less what the fingers press with: 0.02 for each newton."""
    return thenar.gym.nearness(simulation, action) - 0.02 * float(simulation.normal_N.sum())


def any_box(rng: np.random.Generator) -> dict[str, object]:
    return {"contact.friction": rng.uniform(0.2, 0.6), "object.mass": f"{rng.uniform(50, 120):.1f} g"}


env = thenar.gym.GraspEnv(SCENE, part="forces", law=squeeze, actions=1, vary=any_box, reward=gentle,
                          observation=["margin"])


def episode(policy: NDArray[np.float64], seed: int) -> float:
    """The mean reward of an episode."""
    observation, _ = env.reset(seed=seed)
    rewards, ended = [], False
    while not ended:
        least_margin = float(np.min(observation))
        observation, reward, lost, over, _ = env.step([policy[0] + policy[1] * (1.0 - least_margin)])
        rewards.append(reward)
        ended = lost or over
    return sum(rewards) / round(SCENE.duration_s / 0.02)  # A box that is lost early earns nothing from then on.


random = np.random.default_rng(1)
mean, spread = np.array([0.0, 0.0]), np.array([0.5, 0.5])
history = [np.mean([episode(mean, seed) for seed in range(EPISODES)])]
for generation in range(GENERATIONS):
    policies = mean + spread * random.standard_normal((EPISODES, 2))
    # All policies of a generation hold the same boxes.
    earned = [np.mean([episode(policy, 100 * generation + seed) for seed in range(4)]) for policy in policies]
    best = policies[np.argsort(earned)[-BEST:]]
    mean, spread = best.mean(axis=0), best.std(axis=0) + 0.02
    history.append(np.mean([episode(mean, seed) for seed in range(EPISODES)]))
env.close()
print(f"reward {history[0]:.3f} before, {history[-1]:.3f} after: "
      f"squeezes by {MOST_N * mean[0]:.2f} N, and {MOST_N * mean[1]:.2f} N more where a margin is gone")

figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
axes.plot(history, "o-", color="#2563a8")
axes.set(xlabel="generation", ylabel=f"mean reward of the same {EPISODES} boxes")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png"), dpi=110)
