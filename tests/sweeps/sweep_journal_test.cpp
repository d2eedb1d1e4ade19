// SPDX-License-Identifier: Apache-2.0
#include "engine/sweeps/sweep_journal.h"

#include <gtest/gtest.h>

#include <fstream>
#include <optional>
#include <string>

#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/units.h"
#include "engine/sweeps/sweep.h"
#include "tests/support/scratch.h"
#include "tests/sweeps/small_sweeps.h"

namespace thenar::sweep_journal_test {
namespace {

using namespace small_sweeps;

TEST(SweepJournal, GivesBackWhatWasAddedAndDropsATornLine) {
  const fs::path folder = scratch();
  const SweepPlan plan = small_plan({"contact.friction=0.1:0.9:5"});
  const auto json = plan_json(plan, "test");
  static_cast<void>(claim_sweep_folder(folder, json));
  SweepRow failed =
      row_of(Outcome::kSolverFailed, "a \"reason\",\nin two lines", R"({"max_slip_mm": 0.30000000000000004})");
  failed.left_out = "left out: muscles, and why";
  SweepJournal(folder, 0, json).add(3, failed);
  std::ofstream(folder / "journal-0.jsonl", std::ios::app) << R"({"row":4,"outcome":"held","rea)";
  const SweepRow held = row_of(Outcome::kHeld, "", R"({"final_error_mm": 5e-324, "lost_at_s": null})");
  SweepJournal(folder, 0, json).add(1, held);
  SweepJournal(folder, 7, json).add(0, {});
  const FinishedRows rows(folder, plan, json);
  ASSERT_EQ(rows.count(), 3U);
  EXPECT_EQ(rows.read(3)->verdict.outcome, failed.verdict.outcome);
  EXPECT_EQ(rows.read(3)->verdict.reason, failed.verdict.reason);
  EXPECT_EQ(rows.read(3)->measures, failed.measures);
  EXPECT_EQ(rows.read(3)->left_out, failed.left_out);
  EXPECT_EQ(rows.read(1)->measures, held.measures);
  EXPECT_FALSE(rows.contains(4));
  EXPECT_FALSE(rows.read(4));
  EXPECT_EQ(FinishedRows(folder, plan, plan_json(plan, "lockstep")).count(), 0U) << "rows of another plan";
}

TEST(SweepJournal, OneSweepAtATimeBeginsInAFolder) {
  const fs::path folder = scratch();
  const auto one = plan_json(small_plan({"contact.friction=0.1:0.9:5"}), "test");
  const auto other = plan_json(small_plan({"contact.friction=0.1:0.9:6"}), "test");
  std::optional<FileLock> claim = claim_sweep_folder(folder, one);
  EXPECT_THROW(static_cast<void>(claim_sweep_folder(folder, other)), ConfigError);
  EXPECT_THROW(static_cast<void>(claim_sweep_folder(folder, one)), ConfigError) << "both would look for missing rows";
  const SweepJournal journal(folder, 0, one);
  claim.reset();
  EXPECT_THROW(static_cast<void>(claim_sweep_folder(folder, other)), ConfigError);
  // A process that has read other files than the one that claimed the folder.
  EXPECT_THROW(SweepJournal(folder, 1, other), ConfigError);
}

// What a killed process left of its plan is written anew; what is no part of the plan is somebody's.
TEST(SweepJournal, ATornPlanIsNobodys) {
  const fs::path folder = scratch(), file = folder / "plan.json";
  const auto plan = plan_json(small_plan({"contact.friction=0.1:0.9:5"}), "test");
  static_cast<void>(claim_sweep_folder(folder, plan));
  const std::string whole = read(file);
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, whole.size() / 2, whole.size() - 1}) {
    fs::resize_file(file, size);
    static_cast<void>(claim_sweep_folder(folder, plan));
    EXPECT_EQ(read(file), whole);
  }
  std::ofstream(file) << "a plan of mine";
  EXPECT_THROW(static_cast<void>(claim_sweep_folder(folder, plan)), ConfigError);
  EXPECT_EQ(read(file), "a plan of mine");
}

TEST(SweepJournal, TheLastProcessToEndIsTheOneThatKnowsIt) {
  const fs::path folder = scratch();
  const SweepPlan plan = small_plan({"contact.friction=0.1:0.9:5"});
  const auto json = plan_json(plan, "test");
  static_cast<void>(claim_sweep_folder(folder, json));
  SweepJournal one(folder, 0, json), other(folder, 1, json);
  EXPECT_THROW(SweepJournal(folder, 1, json), ConfigError) << "two processes would run the same rows";
  other.add(4, {});
  EXPECT_FALSE(one.finish(plan));
  EXPECT_FALSE(fs::exists(folder / "rows.csv"));
  other.add(2, row_of(Outcome::kLost, "it fell", "{}"));
  EXPECT_EQ(other.finish(plan), (SweepJournal::Outcomes{{SweepRow().verdict.outcome, 1}, {Outcome::kLost, 1}}));
  EXPECT_EQ(read(folder / "rows.csv"), rows_csv(plan, {{2, row_of(Outcome::kLost, "it fell", "{}")}, {4, {}}}));
}

// Wherever a journal is cut, the rows before the cut are whole, and the one that was cut is missing, also after another
// process has gone on behind it.
TEST(SweepJournal, ACutLineIsNoRowWhereverItIsCut) {
  const fs::path folder = scratch();
  const SweepPlan plan = small_plan({"contact.friction=0.1:0.9:5"});
  const auto json = plan_json(plan, "test");
  static_cast<void>(claim_sweep_folder(folder, json));
  const SweepRow row = row_of(Outcome::kHeld, R"(of "}}" and {"row":3})", R"({"final_error_mm": 0.25})");
  SweepJournal(folder, 0, json).add(1, row);
  const std::string first = read(folder / "journal-0.jsonl");
  SweepJournal(folder, 0, json).add(2, row);
  const std::string both = read(folder / "journal-0.jsonl");
  for (std::size_t size = first.size(); size < both.size(); ++size) {
    std::ofstream(folder / "journal-0.jsonl") << both.substr(0, size);
    SweepJournal(folder, 0, json).add(4, row);
    const FinishedRows rows(folder, plan, json);
    EXPECT_TRUE(rows.contains(1) && rows.contains(4) && rows.count() == (size + 1 < both.size() ? 2U : 3U))
        << rows.count() << " rows of " << size << " bytes";
    EXPECT_EQ(rows.read(4)->verdict.reason, row.verdict.reason);
  }
}

// A letter that is another one, as a disk or a hand may leave it, makes a row missing, which then runs again.
TEST(SweepJournal, ADamagedLineIsNoRow) {
  const fs::path folder = scratch();
  const SweepPlan plan = small_plan({"contact.friction=0.1:0.9:5"});
  const auto json = plan_json(plan, "test");
  static_cast<void>(claim_sweep_folder(folder, json));
  SweepJournal(folder, 0, json).add(1, row_of(Outcome::kHeld, "a reason", R"({"final_error_mm": 0.25})"));
  const std::string whole = read(folder / "journal-0.jsonl");
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = damaged[at] == '7' ? '8' : '7';
    std::ofstream(folder / "journal-0.jsonl") << damaged;
    EXPECT_EQ(FinishedRows(folder, plan, json).count(), 0U) << damaged;
  }
  std::ofstream(folder / "journal-0.jsonl") << whole;
  EXPECT_TRUE(FinishedRows(folder, plan, json).contains(1));
}

// A row's line does not carry the plan, however many values this has: a sweep of many rows takes time with its rows.
TEST(SweepJournal, LinesAreShortHoweverLongThePlan) {
  const fs::path folder = scratch();
  const SweepPlan plan = small_plan({"contact.friction=0.1:0.9:50000"});
  const auto json = plan_json(plan, "test");
  static_cast<void>(claim_sweep_folder(folder, json));
  SweepJournal journal(folder, 0, json);
  for (std::size_t row = 0; row < 50000; ++row) journal.add(row, {});
  EXPECT_LT(fs::file_size(folder / "journal-0.jsonl"), 50000U * 200U);
  const auto outcomes = journal.finish(plan);
  ASSERT_TRUE(outcomes);
  EXPECT_EQ(outcomes->at(SweepRow().verdict.outcome), 50000U);
}

TEST(SweepJournal, AFolderStaysTheSweepsThatItIs) {
  const fs::path folder = scratch();
  const SweepPlan plan = small_plan({"contact.friction=0.1:0.9:5"});
  const auto json = plan_json(plan, "test");
  static_cast<void>(claim_sweep_folder(folder, json));
  static_cast<void>(claim_sweep_folder(folder, json));
  const std::string before = read(folder / "plan.json");
  const auto refused = [&](const SweepPlan& other, const std::string& runner, const std::string& part) {
    try {
      static_cast<void>(claim_sweep_folder(folder, plan_json(other, runner)));
    } catch (const ConfigError& error) {
      return std::string(error.what()).find("another '" + part + "'") != std::string::npos;
    }
    return false;
  };
  SweepPlan set = plan;
  set.overrides.pop_back();
  EXPECT_TRUE(refused(small_plan({"contact.friction=0.1:0.9:6"}), "test", "vary"));
  EXPECT_TRUE(refused(set, "test", "set"));
  EXPECT_TRUE(refused(plan, "lockstep", "runner"));
  // Neither its name nor its place makes a scene another one, but a letter in the hand that it names does.
  const fs::path copy = folder / "scene";
  SweepPlan moved = plan;
  moved.scene = copied_scene(copy);
  EXPECT_EQ(plan_json(moved, "test"), json);
  std::ofstream(copy / "hand.yaml", std::ios::app) << "#";
  EXPECT_TRUE(refused(moved, "test", "files"));
  EXPECT_EQ(read(folder / "plan.json"), before);
  // Rows of nobody are not written over.
  const fs::path foreign = folder / "foreign";
  fs::create_directories(foreign);
  std::ofstream(foreign / "rows.csv") << "mine\n";
  EXPECT_THROW(static_cast<void>(claim_sweep_folder(foreign, json)), ConfigError);
  EXPECT_EQ(read(foreign / "rows.csv"), "mine\n");
}

}  // namespace
}  // namespace thenar::sweep_journal_test
