// SPDX-License-Identifier: Apache-2.0
#include "engine/sweeps/sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fstream>
#include <map>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/formats/files.h"
#include "engine/models/build_model.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/units.h"
#include "tests/support/scratch.h"
#include "tests/sweeps/small_sweeps.h"

namespace thenar::sweep_test {
namespace {

using namespace small_sweeps;

std::vector<std::size_t> all_rows(const SweepPlan& plan) {
  std::vector<std::size_t> rows(plan.rows());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = i;
  return rows;
}

std::map<std::size_t, SweepRow> rows_of(const SweepPlan& plan, int jobs, const RunScene& run) {
  std::map<std::size_t, SweepRow> rows;
  const auto done = [&](std::size_t row, SweepRow result) {
    EXPECT_TRUE(rows.emplace(row, std::move(result)).second) << "row " << row << " ran twice";
  };
  run_sweep(plan, all_rows(plan), jobs, run,
            {done, [](std::size_t row, const std::string& why) { ADD_FAILURE() << "row " << row << ": " << why; }});
  return rows;
}

/// Why rows have no result.
std::map<std::size_t, std::string> failures_of(const SweepPlan& plan, int jobs, const RunScene& run) {
  std::map<std::size_t, std::string> failures;
  run_sweep(
      plan, all_rows(plan), jobs, run,
      {[](std::size_t, const SweepRow&) {}, [&](std::size_t row, const std::string& why) { failures[row] = why; }});
  return failures;
}

SweepRow do_nothing(const Model& /*model*/) { return {}; }

std::string fault_of(const std::string& text) {
  try {
    static_cast<void>(read_variation(text));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(Sweep, RangesAreEvenOrByEqualRatiosAndKeepTheirBounds) {
  EXPECT_EQ(read_variation("contact.friction=0.1:0.5:5").values, (Texts{"0.1", "0.2", "0.3", "0.4", "0.5"}));
  EXPECT_EQ(read_variation("a=2 mm:-2 mm:3").values, (Texts{"2 mm", "0 mm", "-2 mm"}));
  EXPECT_EQ(read_variation("a=0.1 ms:10 ms:3:log").values, (Texts{"0.1 ms", "1 ms", "10 ms"}));
}

TEST(Sweep, ValuesOfARangeAreEvenToTheDigitsWritten) {
  for (const bool logarithmic : {false, true}) {
    const Variation variation =
        read_variation(std::string("time.step=0.37 ms:7.3 ms:11") + (logarithmic ? ":log" : ""));
    ASSERT_EQ(variation.values.size(), 11U);
    std::vector<double> s;
    for (const std::string& value : variation.values) {
      const Quantity step = read_quantity(value, Dimension::kTime);
      ASSERT_EQ(step.fault, "");
      s.push_back(logarithmic ? std::log(step.value) : step.value);
    }
    // 12 digits of each value: half a unit of the last one is 5e-12 of it at most.
    const double tolerance = 4.0 * 5e-12 * (logarithmic ? 1.0 : 7.3e-3);
    for (std::size_t i = 1; i + 1 < s.size(); ++i) EXPECT_NEAR(s[i + 1] - s[i], s[i] - s[i - 1], tolerance);
  }
}

TEST(Sweep, ListsAreCutOutsideBracketsOnly) {
  EXPECT_EQ(read_variation("control.law=paper, feedforward").values, (Texts{"paper", "feedforward"}));
  const Variation shapes = read_variation("object.shape={box: [50 mm, 50 mm, 50 mm]},{sphere: 25 mm}");
  EXPECT_EQ(shapes.key, "object.shape");
  EXPECT_EQ(shapes.values, (Texts{"{box: [50 mm, 50 mm, 50 mm]}", "{sphere: 25 mm}"}));
  EXPECT_EQ(read_variation("name='a,b:c',d").values, (Texts{"'a,b:c'", "d"}));
}

TEST(Sweep, SaysWhatIsWrongWithAVariation) {
  const std::map<std::string, std::string> faults = {
      {"contact.friction", "write it as key="},
      {"=1:2:3", "write it as key="},
      {"a=1:2", "write a range as"},
      {"a=1:2:3:lg", "write a range as"},
      {"a=x:2:3", "numbers with their unit"},
      {"a=inf:2:3", "numbers with their unit"},
      {"a=1 mm:2 m:3", "the same unit"},
      {"a=1 mm:2:3", "the same unit"},
      {"a=1:2:1", "'1' must be how many"},
      {"a=1:2:2.5", "'2.5' must be how many"},
      {"a=1:2:9999999", "'9999999' must be how many"},
      {"a=0:2:3:log", "equal ratios"},
      {"a=-1:2:3:log", "equal ratios"},
      {"a=1,,2", "a value is missing"},
      {"a=", "a value is missing"},
  };
  for (const auto& [text, fault] : faults) {
    EXPECT_NE(fault_of(text).find(fault), std::string::npos) << text << ": " << fault_of(text);
    EXPECT_EQ(fault_of(text).find("--vary " + text + ": "), 0U) << fault_of(text);
  }
}

TEST(Sweep, TheLastKeyTurnsFastest) {
  const SweepPlan plan = small_plan({"a=1,2", "b=x,y,z"});
  ASSERT_EQ(plan.rows(), 6U);
  EXPECT_EQ(plan.values(0), (Texts{"1", "x"}));
  EXPECT_EQ(plan.values(1), (Texts{"1", "y"}));
  EXPECT_EQ(plan.values(3), (Texts{"2", "x"}));
  EXPECT_EQ(plan.changes(5), (Texts{"object.points=2000", "time.duration=0.32 s", "a=2", "b=z"}));
}

TEST(Sweep, OnlyASweepWithoutAnySceneIsRefused) {
  EXPECT_EQ(first_scene(small_plan({"contact.friction=-1,0.5"})).contact.friction, 0.5);
  const auto fault = [](const Texts& vary) -> std::string {
    try {
      static_cast<void>(first_scene(small_plan(vary)));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(fault({"contact.frction=0.5,0.6"}),
            "--vary contact.frction: unknown key, did you mean 'contact.friction'?");
  EXPECT_NE(fault({"contact.friction=0.5", "contact.friction=0.6"}).find("varies twice"), std::string::npos);
  EXPECT_NE(fault({"contact.friction=0:1:1001", "time.step=1 ms:2 ms:1000"}).find("1000000 rows"), std::string::npos);
}

// What is borrowed or shared between rows and threads would show here: surfaces change in between, and come again.
TEST(Sweep, RowsAreTheBitsOfRunsOnTheirOwnForAnyNumberOfJobs) {
  const SweepPlan plan = small_plan({"control.grasp.internal_force=1 N,2 N",
                                     "object.shape={sphere: 26.09 mm},{sphere: 26.2 mm}", "contact.friction=0.3,0.8"});
  std::map<std::size_t, SweepRow> alone;
  for (std::size_t row = 0; row < plan.rows(); ++row) {
    alone[row] = run_row(build_model(load_scene(plan.scene, plan.changes(row))));
  }
  const std::string csv = rows_csv(plan, alone);
  for (const int jobs : {1, 2, 3, 8}) EXPECT_EQ(rows_csv(plan, rows_of(plan, jobs, run_row)), csv) << jobs << " jobs";
  EXPECT_TRUE(alone.at(3).measures.at("final_error_mm").is_number());
  EXPECT_NE(alone.at(1).measures, alone.at(3).measures) << "another ball, and the same numbers";
}

TEST(Sweep, ARefusedSceneIsARow) {
  const fs::path cloud = scratch() / "no_cloud.ply";
  std::ofstream(cloud) << "no cloud\n";
  const SweepPlan plan =
      small_plan({"contact.friction=0.5,-1", "object.shape={sphere: 26 mm},{cloud: " + cloud.string() + "}"});
  const auto rows = rows_of(plan, 2, do_nothing);
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows.at(0).verdict.outcome, Outcome::kHeld);
  EXPECT_EQ(rows.at(1).verdict.outcome, Outcome::kRefused);
  EXPECT_NE(rows.at(1).verdict.reason, "");
  EXPECT_EQ(rows.at(2).verdict.reason, "contact.friction: -1 must be at least 0");
}

// Scene and hand change, and then they are gone: all rows are those of the files as they were.
TEST(Sweep, AllRowsAreOfTheSameFiles) {
  SweepPlan plan = small_plan({"contact.friction=0.4:0.9:6"});
  plan.scene = copied_scene(scratch() / "scene", "own_hand.yaml");
  const std::string csv = rows_csv(plan, rows_of(plan, 1, run_row));
  const KeptFiles kept;
  keep_files(plan);
  int rows = 0;
  const RunScene disturbed = [&](const Model& model) {
    SweepRow row = run_row(model);
    if (++rows == 2) {
      std::ofstream(plan.scene, std::ios::app) << "unknown: key\n";
      fs::remove(plan.scene.parent_path() / "own_hand.yaml");
    }
    return row;
  };
  EXPECT_EQ(rows_csv(plan, rows_of(plan, 1, disturbed)), csv);
  EXPECT_EQ(rows, 6);
}

// The program has no hand of this name.
TEST(Sweep, AFileThatCannotBeReadIsNoOutcome) {
  SweepPlan plan = small_plan({"contact.friction=0.4,0.5"});
  plan.scene = copied_scene(scratch() / "scene", "own_hand.yaml");
  fs::remove(plan.scene.parent_path() / "own_hand.yaml");
  const auto failures = failures_of(plan, 1, do_nothing);
  ASSERT_EQ(failures.size(), 2U);
  EXPECT_NE(failures.at(0).find("own_hand.yaml: no such file"), std::string::npos) << failures.at(0);
  EXPECT_THROW(keep_files(plan), ReadError) << "known before the first row";
  EXPECT_THROW(keep_files(small_plan({"object.shape={sphere: 26 mm},{cloud: /no/such.ply}"})), ReadError);
}

TEST(Sweep, ARowWithoutMemoryIsNamedAndTheOthersRun) {
  const SweepPlan plan = small_plan({"contact.friction=0.5,0.6,0.7,0.8"});
  std::atomic<int> ran = 0;
  const RunScene large = [&](const Model& model) -> SweepRow {
    if (model.scene.contact.friction == 0.6) throw std::bad_alloc();
    if (model.scene.contact.friction == 0.7) throw std::length_error("vector::reserve");
    ++ran;
    return {};
  };
  for (const int jobs : {1, 2}) {
    ran = 0;
    const auto failures = failures_of(plan, jobs, large);
    EXPECT_EQ(ran, 2);
    ASSERT_EQ(failures.size(), 2U);
    for (const std::size_t row : {1U, 2U}) {
      EXPECT_NE(failures.at(row).find("not enough memory"), std::string::npos) << failures.at(row);
    }
  }
}

TEST(Sweep, WhatARowThrowsEndsTheSweep) {
  const SweepPlan plan = small_plan({"contact.friction=0.5,0.6,0.7"});
  const RunScene fail = [](const Model&) -> SweepRow { throw std::logic_error("a fault of ours"); };
  EXPECT_THROW(rows_of(plan, 2, fail), std::logic_error);
}

TEST(Sweep, TheTableHasUnitsInItsHeaderAndQuotesText) {
  const SweepPlan plan = small_plan({"contact.band=0.2 mm,0.3mm", "time.step=1 ms,0.001 s",
                                     "fingertips.stiffening=0 1/N,2 1/N", "object.shape={box: [1 m, 1 m, 1 m]}"});
  std::map<std::size_t, SweepRow> rows;
  rows[0] = row_of(Outcome::kHeld, "", R"({"final_error_mm": 0.1, "rms_error_mm": null, "lost_at_s": 2})");
  rows[7].verdict = {Outcome::kUnstable, "it said \"no\", twice"};
  rows[7].left_out = "left out: muscles";
  std::istringstream lines(rows_csv(plan, rows));
  std::string header, first, second, rest;
  std::getline(lines, header);
  std::getline(lines, first);
  std::getline(lines, second);
  EXPECT_FALSE(std::getline(lines, rest));
  EXPECT_EQ(header.find("contact.band [mm],time.step,fingertips.stiffening "
                        "[1/N],object.shape,outcome,reason,left_out,final_error_mm,"),
            0U)
      << header;
  EXPECT_EQ(first.find("0.2,1 ms,0,\"{box: [1 m, 1 m, 1 m]}\",held,,,0.1,,"), 0U) << first;
  EXPECT_EQ(second.find(
                "0.3,0.001 s,2,\"{box: [1 m, 1 m, 1 m]}\",unstable,\"it said \"\"no\"\", twice\",left out: muscles,,"),
            0U)
      << second;
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), std::count(second.begin(), second.end(), ',') - 3)
      << "as many cells, but for the commas in two texts: " << second;
}

}  // namespace
}  // namespace thenar::sweep_test
