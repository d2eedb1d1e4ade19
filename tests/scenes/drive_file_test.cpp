// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/drive_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "engine/control/control_tick.h"
#include "engine/formats/files.h"
#include "engine/models/build_model.h"
#include "engine/recordings/signals.h"
#include "engine/results/scene_run.h"
#include "engine/scenes/config.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::drive_file_test {
namespace {

const Hand& hand() {
  static const Hand hand = scene_of("box_grasp").hand;
  return hand;
}

std::string torque_header() {
  std::string names = "time_s";
  for (const Joint& joint : hand().joints) names += "," + joint.name + "_Nm";
  return names + "\n";
}

std::string row(double time_s, double value) {
  std::string text = std::to_string(time_s);
  for (std::size_t i = 0; i < hand().joints.size(); ++i) text += "," + std::to_string(value + static_cast<double>(i));
  return text + "\n";
}

std::filesystem::path written(const std::string& text) {
  const std::filesystem::path file = scratch() / "drive.csv";
  std::ofstream(file) << text;
  return file;
}

std::string fault(const std::string& text) {
  const std::filesystem::path file = written(text);
  try {
    (void)load_drive(file, hand());
  } catch (const FileError& error) {
    return std::string(error.what()).substr(file.string().size() + 2);
  }
  return "";
}

// Between its times a table is linear, before and after them constant: at the middle the mean, exactly, since these
// numbers have few binary digits.
TEST(DriveFile, IsLinearBetweenItsTimes) {
  const DriveTable drive = load_drive(written(torque_header() + row(0.5, 1.0) + row(1.0, 3.0)), hand());
  EXPECT_FALSE(drive.muscles);
  for (Eigen::Index i = 0; i < drive.values.rows(); ++i) {
    const auto joint = static_cast<double>(i);
    EXPECT_EQ(drive.at(0.0)[i], 1.0 + joint);
    EXPECT_EQ(drive.at(0.75)[i], 2.0 + joint);
    EXPECT_EQ(drive.at(1.0)[i], 3.0 + joint);
    EXPECT_EQ(drive.at(9.0)[i], 3.0 + joint);
  }
}

TEST(DriveFile, RefusesWithLineAndColumn) {
  EXPECT_EQ(fault(torque_header() + row(0.0, 1.0) + row(0.0, 1.0)), "line 3: time_s must rise from row to row");
  EXPECT_EQ(fault(torque_header() + "0,1\n"), "line 2: 2 values below 13 names");
  EXPECT_EQ(fault(torque_header()), "is no table: a line of names, and lines of numbers with commas between");
  EXPECT_EQ(fault("time_s,x\n0,1\n"),
            "drives nothing: it has neither torques of joints, such as 'T_CMC_FE_Nm', nor "
            "forces of muscles, such as '" +
                hand().muscles[0].name + "_N'");
  EXPECT_EQ(fault("time_s,T_CMC_FE_Nm,T_CMC_A_Nm\n0,1,1\n"), "has no column 'T_CMC_AA_Nm', did you mean 'T_CMC_A_Nm'?");
  std::string text = torque_header() + row(0.0, 1.0);
  text.replace(text.rfind(','), std::string::npos, ",x\n");
  EXPECT_NE(fault(text).find("line 2: 'x'"), std::string::npos) << fault(text);
  text.replace(text.rfind(','), std::string::npos, ",\n");
  EXPECT_EQ(fault(text), "line 2: M_DIP_FE_Nm has no number");
}

// A run's own muscle forces, from its signals.csv, hold the object as the run did: without the controller that answers
// to what it sees, over 0.3 s, within 0.1 mm of it.
TEST(DriveFile, MuscleForcesOfARunHoldItsObject) {
  Scene scene = scene_of("box_grasp", {kCoarseBox, "time.duration=300 ms"});
  const Model model = build_model(scene);
  State state(model);
  const Recording run = run_scene(model, state);
  const std::filesystem::path file = written(signals_csv(model, run));

  Scene driven = scene_of("box_grasp", {kCoarseBox, "time.duration=300 ms", "control.drive=" + file.string()});
  ASSERT_TRUE(driven.control->drive && driven.control->drive->muscles);
  const Model replay = build_model(driven);
  State after(replay);
  const Recording again = run_scene(replay, after);
  EXPECT_FALSE(again.verdict.lost_s);
  EXPECT_LE((after.X_WO.translation() - state.X_WO.translation()).norm(), 1e-4);
  // The same forces in the same ticks; a CSV has nine digits.
  EXPECT_LE((again.muscle_forces_N - run.muscle_forces_N).cwiseAbs().maxCoeff(), 1e-7);
}

// Muscles that take time get what the run asked them for, not what they had come to.
TEST(DriveFile, OfMusclesThatActIsWhatWasAskedFor) {
  const std::vector<std::string> changes = {kCoarseBox, "time.duration=40 ms",
                                            "control.muscles={activation: 12 ms, deactivation: 45 ms}"};
  const Model model = build_model(scene_of("box_grasp", changes));
  State state(model);
  const Recording run = run_scene(model, state);
  EXPECT_GT((run.muscles_asked_N - run.muscle_forces_N).cwiseAbs().maxCoeff(), 0.1);
  std::vector<std::string> driven = changes;
  driven.push_back("control.drive=" + written(signals_csv(model, run)).string());
  const Model replay = build_model(scene_of("box_grasp", driven));
  State after(replay);
  const Recording again = run_scene(replay, after);
  // The same forces in the same ticks; a CSV has nine digits.
  EXPECT_LE((again.muscles_asked_N - run.muscles_asked_N).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_LE((again.muscle_forces_N - run.muscle_forces_N).cwiseAbs().maxCoeff(), 1e-7);
}

// The scene says where: a file that is not there, or does not fit, is the key's fault.
TEST(DriveFile, SceneNamesTheKey) {
  try {
    (void)scene_of("box_grasp", {"control.drive=/nowhere.csv"});
    FAIL();
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("control.drive"), std::string::npos) << error.what();
  }
  std::string names = "time_s", numbers = "0";
  for (const Muscle& muscle : hand().muscles) {
    names += "," + muscle.name + "_N";
    numbers += ",1";
  }
  const std::filesystem::path file = written(names + "\n" + numbers + "\n");
  try {
    (void)scene_of("box_grasp", {"control.muscles=false", "control.drive=" + file.string()});
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("has muscle forces, which need control.muscles: true"), std::string::npos);
  }
}

}  // namespace
}  // namespace thenar::drive_file_test
