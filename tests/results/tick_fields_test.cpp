// SPDX-License-Identifier: Apache-2.0
// One list of fields, of which all that is said of a tick is made.

#include "engine/results/tick_fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "engine/models/build_model.h"
#include "engine/recordings/signal_columns.h"
#include "engine/recordings/signals.h"
#include "engine/results/scene_run.h"
#include "tests/support/scenes.h"

namespace thenar::tick_fields_test {
namespace {

// A name says its unit, as all names of the engine do, and every field is explained by a whole sentence.
TEST(TickFields, AreNamedAndExplained) {
  const std::map<std::string, std::string> units = {
      {"_s", "s"},   {"_m", "m"},   {"_N", "N"},         {"_Nm", "N m"},      {"_rad", "rad"},           {"_J", "J"},
      {"_us", "us"}, {"_Hz", "Hz"}, {"_m_per_s", "m/s"}, {"_N_per_m", "N/m"}, {"_Nm_per_rad", "N m/rad"}};
  std::set<std::string_view> names;
  for (const TickField& field : tick_fields()) {
    SCOPED_TRACE(field.name);
    EXPECT_TRUE(names.insert(field.name).second);
    EXPECT_NE(field.at == nullptr, field.compute == nullptr);
    EXPECT_GT(field.sentence.size(), 10U);
    EXPECT_TRUE(field.sentence.ends_with('.'));
    EXPECT_EQ(tick_field(field.name), &field);
    std::string suffix;  // The longest that fits.
    for (const auto& [end, unit] : units) {
      if (field.name.ends_with(end) && end.size() > suffix.size()) suffix = end;
    }
    if (!suffix.empty()) {
      EXPECT_EQ(field.unit, units.at(suffix));
    }
  }
  EXPECT_EQ(tick_field("no_such_field"), nullptr);
}

// What signals.csv has of a tick is in it once, under a name of its own, with the value that the
// field has. A list that forgets a field cannot be made any more; a field without room for its numbers could.
TEST(TickFields, AreAllInTheTableOfSignals) {
  for (const char* name : {"box_wet", "box_stiff", "pick_and_place", "slides_ball", "human5_carry"}) {
    SCOPED_TRACE(name);
    const Model model = build_model(scene_of(name, {kCoarseBox, "time.duration=50 ms"}));
    State state(model);
    const Recording run = run_scene(model, state);
    const SignalTable table = signal_table(model, run);
    EXPECT_EQ(std::set(table.names.begin(), table.names.end()).size(), table.names.size());
    ASSERT_FALSE(run.ticks.empty());
    const auto last = std::ssize(run.ticks) - 1;
    const auto in_last = [&](const Eigen::MatrixXd& all) {
      std::vector<double> numbers;
      for (Eigen::Index m = 0; m < all.rows(); ++m) numbers.push_back(all(m, last));
      return numbers;
    };
    const std::vector<double> muscle_N = in_last(run.muscle_forces_N), asked_N = in_last(run.muscles_asked_N);
    const TickView view = view_of(model, run.ticks.back(), muscle_N, asked_N);
    std::size_t all = 0;
    for (const TickField& field : tick_fields()) {
      if (!field.is_in_signals() || !field.is_in(model)) continue;
      SCOPED_TRACE(field.name);
      std::vector<double> numbers;
      add_numbers(field, view, numbers);
      ASSERT_FALSE(numbers.empty() && field.of != Of::kMuscle);
      all += numbers.size();
      for (std::size_t i = 0; i < numbers.size(); ++i) {
        const SignalColumn column = signal_column({std::string(field.name), std::string(field.unit), 0, numbers.size()},
                                                  i, signal_names(model));
        const auto at = std::ranges::find(table.names, column.name);
        ASSERT_NE(at, table.names.end()) << column.name;
        const double shown = table.numbers(last, at - table.names.begin());
        if (!std::isnan(numbers[i])) {
          EXPECT_EQ(shown, column.factor * numbers[i]) << column.name;
        }
      }
    }
    EXPECT_EQ(all, table.names.size());
  }
}

// A row takes its numbers from where its name says: one row of each kind of place and of each computation, against the
// record itself.
TEST(TickFields, HaveTheNumbersThatTheyName) {
  const Model model = build_model(scene_of("box_wet", {kCoarseBox, "time.duration=0.1 s"}));
  State state(model);
  const Recording run = run_scene(model, state);
  const TickRecord& tick = run.ticks.back();
  const TickView view = view_of(model, tick, {});
  const auto numbers = [&](const char* name) {
    std::vector<double> all;
    add_numbers(*tick_field(name), view, all);
    return all;
  };
  EXPECT_EQ(numbers("time_s"), std::vector{tick.time_s});
  EXPECT_EQ(numbers("tick"), std::vector{100.0});
  EXPECT_EQ(numbers("active"), std::vector{static_cast<double>(tick.contact.active)});
  EXPECT_EQ(numbers("sweeps"), std::vector{static_cast<double>(tick.contact.solve.sweeps)});
  EXPECT_EQ(numbers("penetration_m"), std::vector{tick.contact.penetration_m});
  EXPECT_EQ(numbers("dissipated_J"), std::vector{tick.ledger.dissipated_J});
  EXPECT_EQ(numbers("q_rad"), std::vector<double>(state.q.begin(), state.q.end()));
  EXPECT_EQ(numbers("position_m"), std::vector<double>(tick.position_m.begin(), tick.position_m.end()));
  const std::vector<double> object = numbers("object"), force_N = numbers("force_N"), normal_N = numbers("normal_N"),
                            slip_m = numbers("slip_m"), walk_m = numbers("walk_m"), stick = numbers("stick"),
                            squeeze_N = numbers("squeeze_N"), felt_N = numbers("felt_tangential_N"),
                            desired_N = numbers("desired_N");
  EXPECT_EQ(object[1], state.X_WO.translation().y());
  EXPECT_EQ(object[4], state.X_WO.linear()(0, 1)) << "rotation by rows";
  for (int k = 0; k < model.fingers(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    EXPECT_EQ(normal_N[i], tick.force[k].normal_N);
    EXPECT_EQ(slip_m[i], tick.slip_m[k]);
    EXPECT_EQ(walk_m[3 * i + 1], tick.walk_m[k].y());
    EXPECT_EQ(stick[i], state.touch[k].stick);
    EXPECT_EQ(squeeze_N[i], tick.reflex.grips[k].internal_force_N);
    EXPECT_EQ(force_N[3 * i + 2], state.load[k].force_N.z());
    EXPECT_EQ(desired_N[3 * i + 1], tick.desired_N[k].y());
    EXPECT_EQ(felt_N[3 * i], state.touch[k].tangential_N.x());
  }
}

}  // namespace
}  // namespace thenar::tick_fields_test
