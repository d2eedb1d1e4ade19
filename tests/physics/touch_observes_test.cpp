// SPDX-License-Identifier: Apache-2.0
// To feel changes nothing: what fingertips feel is read off the state, and a reflex that nothing wakes leaves forces as
// they are.

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/recordings/signals.h"
#include "engine/results/scene_run.h"
#include "tests/support/scenes.h"

namespace thenar::touch_observes_test {
namespace {

struct Unfeeling {
  const char* scene;
  bool lockstep;
  std::vector<std::string> changes;  ///< So that the run is short, and something happens in it.
};

std::ostream& operator<<(std::ostream& out, const Unfeeling& of) { return out << of.scene; }

class TouchObserves : public testing::TestWithParam<Unfeeling> {
 protected:
  [[nodiscard]] static SignalTable signals_with(const std::vector<std::string>& named) {
    std::vector<std::string> changes = GetParam().changes;
    changes.insert(changes.end(), named.begin(), named.end());
    const Model model = build_model(scene_of(GetParam().scene, changes));
    EXPECT_EQ(model.feels(), !named.empty());
    State state(model);
    RunSettings settings;
    if (GetParam().lockstep) settings.lockstep.emplace();
    return signal_table(model, run_scene(model, state, settings));
  }

  /// Every column of the one is in the other, with the same bits.
  static void expect_same_bits(const SignalTable& plain, const SignalTable& feeling) {
    ASSERT_EQ(plain.numbers.rows(), feeling.numbers.rows());
    ASSERT_GT(feeling.names.size(), plain.names.size());
    ASSERT_GT(plain.numbers.rows(), 0);
    for (std::size_t i = 0; i < plain.names.size(); ++i) {
      const auto same = std::ranges::find(feeling.names, plain.names[i]);
      ASSERT_NE(same, feeling.names.end()) << plain.names[i];
      const auto column = static_cast<Eigen::Index>(i), other = same - feeling.names.begin();
      for (Eigen::Index tick = 0; tick < plain.numbers.rows(); ++tick) {
        ASSERT_EQ(std::bit_cast<std::uint64_t>(plain.numbers(tick, column)),
                  std::bit_cast<std::uint64_t>(feeling.numbers(tick, other)))
            << plain.names[i] << " in tick " << tick;
      }
    }
  }
};

// However late and noisy it is: there is nobody to notice.
// And with a reflex: no load comes so fast, no share of a patch is too small, and the squeeze is not regulated.
TEST_P(TouchObserves, WithoutAnAnswerNothingChanges) {
  const SignalTable plain = signals_with({});
  expect_same_bits(plain, signals_with({"fingertips.touch={delay: 20 ms, noise: 10 %}"}));
  if (!scene_of(GetParam().scene).control) return;
  const std::string never = "control.reflex={load_rate: 1e9 N/s, stick: 0, regulation: 0 1/s}";
  expect_same_bits(plain, signals_with({"fingertips.touch={delay: 20 ms}", never}));
}

// Of each runner of one thread; with muscles and without; a move, a turn, a push; boxes that slip, curved and soft
// objects, and hands of other fingers.
INSTANTIATE_TEST_SUITE_P(
    Scenes, TouchObserves,
    testing::Values(Unfeeling{"box_grasp", false, {kCoarseBox, "time.duration=0.6 s", "contact.max_per_finger=20"}},
                    Unfeeling{"box_grasp",
                              true,
                              {kCoarseBox, "time.duration=0.5 s", "time.control_period=5 ms", "time.control_delay=5 ms",
                               "contact.friction=0.2", "control.grasp.friction=0.3"}},
                    Unfeeling{"box_turn", false, {kCoarseBox, "time.duration=0.5 s", "task.rotate.from=0.3 s"}},
                    Unfeeling{"box_push", false, {kCoarseBox, "time.duration=0.5 s", "task.push.from=0.35 s"}},
                    Unfeeling{"box_grasp",
                              false,
                              {kCoarseBox, "time.duration=0.35 s", "contact.max_per_finger=10",
                               "object.compliance={reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 5 ms}"}},
                    Unfeeling{"slide", false, {}}, Unfeeling{"capsule", false, {"time.duration=0.35 s"}},
                    Unfeeling{"leap_carry", false, {"time.duration=0.35 s"}}));

}  // namespace
}  // namespace thenar::touch_observes_test
