// One list of fields, of which all that is said of a tick is made.

#include "engine/results/tick_fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "engine/results/scene_run.h"
#include "engine/results/signal_columns.h"
#include "engine/results/signals.h"
#include "engine/scenes/build_model.h"
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
    EXPECT_NE(field.at == nullptr, field.make == nullptr);
    EXPECT_GT(field.sentence.size(), 10U);
    EXPECT_TRUE(field.sentence.ends_with('.'));
    EXPECT_EQ(tick_field(field.name), &field);
    std::string suffix;  // The longest that fits.
    for (const auto& [end, unit] : units) {
      if (field.name.ends_with(end) && end.size() > suffix.size()) suffix = end;
    }
    if (!suffix.empty()) EXPECT_EQ(field.unit, units.at(suffix));
  }
  EXPECT_EQ(tick_field("no_such_field"), nullptr);
}

// What is known of every tick is in signals.csv: each number once, under a name of its own, with the value that the
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
    std::vector<double> muscle_N(run.muscle_forces_N.rows());
    for (std::size_t m = 0; m < muscle_N.size(); ++m)
      muscle_N[m] = run.muscle_forces_N(static_cast<Eigen::Index>(m), last);
    const TickView view = view_of(model, run.ticks.back(), muscle_N);
    std::size_t all = 0;
    for (const TickField& field : tick_fields()) {
      if (field.from != From::kTick || field.of == Of::kShape || !field.is_in(model)) continue;
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
        if (!std::isnan(numbers[i])) EXPECT_EQ(shown, column.factor * numbers[i]) << column.name;
      }
    }
    EXPECT_EQ(all, table.names.size());
  }
}

}  // namespace
}  // namespace thenar::tick_fields_test
