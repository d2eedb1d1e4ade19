// SPDX-License-Identifier: Apache-2.0
// The program as a user meets it: what it prints, what it writes, and how it refuses bad input.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "collision/shapes.h"
#include "engine/formats/ply_file.h"
#include "tests/support/program.h"
#include "thenar/palette.h"

namespace thenar::main_test {
namespace {

namespace fs = std::filesystem;

/// Whether gnuplot has drawn something in a colour "#rrggbb", which it writes as rgb( 47, 127, 224).
bool has_color(const std::string& svg, const std::string& hex) {
  const auto part = [&](std::size_t at) { return std::stoi(hex.substr(at, 2), nullptr, 16); };
  return svg.find(fmt::format("rgb({:3}, {:3}, {:3})", part(1), part(3), part(5))) != std::string::npos;
}

TEST(Program, WritesEveryResultOfARun) {
  const fs::path out = scratch();
  const ProgramResult run =
      thenar_program("run " + config("box_grasp.yaml") + " --time '0.35 s' --out " + out.string());
  ASSERT_EQ(run.code, 0) << run.text;
  EXPECT_NE(run.text.find("contact computation, total"), std::string::npos);
  const auto summary = nlohmann::json::parse(read(out / "summary.json"));
  EXPECT_EQ(summary.at("scene"), "box grasp");
  EXPECT_TRUE(summary.at("grasp").at("held").get<bool>());
  EXPECT_DOUBLE_EQ(summary.at("simulated_s").get<double>(), 0.35);
  for (const char* stage : {"find", "assemble", "solve", "deform", "interpolate", "contact_total", "grasp_lcp",
                            "muscle_lcp", "control_total"}) {
    EXPECT_GT(summary.at("stages").at(stage).at("p50_us").get<double>(), 0.0) << stage;
  }
  // A header and a row a tick.
  const std::string signals = read(out / "signals.csv");
  EXPECT_EQ(std::count(signals.begin(), signals.end(), '\n'), 351);
  for (const char* figure : {"path.svg", "forces.svg", "muscles.svg", "grip.svg"}) {
    EXPECT_NE(read(out / figure).find("</svg>"), std::string::npos) << figure;
  }
  EXPECT_TRUE(has_color(read(out / "forces.svg"), palette::kNormal));
  EXPECT_TRUE(has_color(read(out / "forces.svg"), palette::kTangential));
  for (const char* color : {palette::kX, palette::kY, palette::kZ})
    EXPECT_TRUE(has_color(read(out / "path.svg"), color)) << color;
  EXPECT_TRUE(has_color(read(out / "grip.svg"), palette::kFingers.front()));
  EXPECT_EQ(read(out / "grasp.png").substr(1, 3), "PNG");
  for (const auto& entry : fs::directory_iterator(out)) EXPECT_NE(entry.path().extension(), ".part");
}

TEST(Program, ReadsNoPipeAndNoDevice) {
  const fs::path pipe = scratch() / "pipe.json";  // The ending tells `solve` what to expect.
  ASSERT_EQ(std::system(("mkfifo " + pipe.string()).c_str()), 0);
  // A pipe without a writer, a device without an end: each was read for ever.
  for (const std::string& arguments :
       {"run " + pipe.string(), "check " + pipe.string(), "solve " + pipe.string(),
        "export --csv /dev/null " + pipe.string(), std::string("run /dev/zero"), std::string("check /dev/zero")}) {
    const ProgramResult refused = thenar_program(arguments, "timeout 20 ");
    EXPECT_EQ(refused.code, 3) << arguments << ": " << refused.text;
    EXPECT_NE(refused.text.find("is a pipe or a device, not a file"), std::string::npos) << refused.text;
  }
}

TEST(Program, SaysThatItsWordsWereLost) {
  for (const std::string& arguments :
       {std::string("--help"), std::string("--version"), "check " + config("minimal.yaml"),
        "run " + config("minimal.yaml") + " --time '50 ms'"}) {
    const ProgramResult run = thenar_program(arguments, "sh -c '\"$@\" 3>&1 >/dev/full 2>&3' - ");
    EXPECT_EQ(run.code, 3) << arguments;
    EXPECT_NE(run.text.find("standard output: could not be written in full"), std::string::npos) << run.text;
  }
}

/// For scenes whose surface shall soon be there.
const std::string kSoon = " --set object.points=2000 ";

/// The program, sent a signal once a shell's condition holds, in which $pid is its number: however long it takes to
/// begin.
ProgramResult interrupted(const std::string& arguments, const std::string& signal, const std::string& condition) {
  // A shell has what it starts in the background ignore SIGINT.
  return thenar_program(arguments + " & pid=$!; for i in $(seq 6000); do if " + condition +
                            "; then break; fi; sleep 0.01; done; kill -" + signal + " $pid; wait $pid",
                        "exec 2>&1; env --default-signal=INT ");
}

TEST(Program, InterruptedItKeepsItsResults) {
  const fs::path folder = scratch();
  const std::string film = (folder / "film.mcap").string();
  for (const char* runner : {"", "--lockstep ", "--realtime "}) {
    for (const char* signal : {"INT", "TERM"}) {
      const fs::path out = folder / "out";
      fs::remove(film);
      const ProgramResult run = interrupted("run " + config("box_grasp.yaml") + kSoon + runner +
                                                "--time 1000 --record " + film + " --out " + out.string(),
                                            signal, "[ $(stat -c %s " + film + " 2>/dev/null || echo 0) -gt 300000 ]");
      EXPECT_EQ(run.code, 130) << run.text;
      const auto summary = nlohmann::json::parse(read(out / "summary.json"));
      const auto simulated_s = summary.at("simulated_s").get<double>();
      EXPECT_GT(simulated_s, 0.0);
      EXPECT_LT(simulated_s, 1000.0);
      EXPECT_EQ(summary.at("grasp").at("outcome"), "unknown");
      EXPECT_NE(summary.at("grasp").at("reason").get<std::string>().find("the run was interrupted at "),
                std::string::npos);
      EXPECT_NE(run.text.find("the run was interrupted at "), std::string::npos) << run.text;
      EXPECT_EQ(read(out / "grasp.png").substr(1, 3), "PNG");
      const ProgramResult exported = thenar_program("export " + film + " --csv " + (folder / "film.csv").string());
      EXPECT_EQ(exported.code, 0);
      EXPECT_EQ(exported.text.find("cut off"), std::string::npos) << exported.text;
      fs::remove_all(out);
    }
  }
}

// A stream that the program is started without must not be a file of its own: what is said there would go into that.
TEST(Program, NeedsNoStandardStream) {
  const fs::path folder = scratch(), film = folder / "film.mcap", picture = folder / "hand.png";
  const std::string run = "run " + config("minimal.yaml") + kSoon + "--time 50ms --quiet --record " + film.string();
  for (const char* closed : {"<&-", "2>&-", ">&-", "<&- >&- 2>&-"}) {
    const ProgramResult outcome = thenar_program(run + " " + closed + "; echo ended with $?");
    EXPECT_NE(outcome.text.find("ended with 0\n"), std::string::npos) << closed << outcome.text;
    const ProgramResult exported = thenar_program("export " + film.string() + " --csv " + (folder / "a.csv").string());
    EXPECT_EQ(exported.code, 0) << closed << exported.text;
    EXPECT_EQ(exported.text, "") << closed;
    fs::remove(film);
  }
  for (const char* closed : {"2>&-", ">&-"}) {
    fs::remove(picture);
    (void)thenar_program("hand " + config("hand.yaml") + " --out " + picture.string() + " " + closed + "; true",
                         "timeout 60 ");
    EXPECT_EQ(read(picture).substr(1, 3), "PNG") << closed;
  }
}

/// A gnuplot that says when it has begun, and takes its time: half of a figure, then the other half.
void write_slow_gnuplot(const fs::path& folder) {
  std::ofstream(folder / "gnuplot") << "#!/bin/sh\nprintf '<svg>'\ntouch " << (folder / "begun").string()
                                    << "\nsleep 0.2\nprintf '</svg>'\n";
  fs::permissions(folder / "gnuplot", fs::perms::owner_all);
}

TEST(Program, ASignalCutsNoFigure) {
  for (const char* signal : {"INT", "TERM", "HUP"}) {
    const fs::path folder = scratch(), out = folder / "out";
    write_slow_gnuplot(folder);
    const ProgramResult run =
        thenar_program("run " + config("minimal.yaml") + kSoon + "--time 50ms --quiet --out " + out.string() +
                           " & pid=$!; while [ ! -e " + (folder / "begun").string() +
                           " ] && kill -0 $pid; do sleep 0.01; done; kill -" + signal + " $pid; wait $pid",
                       "exec 2>&1; PATH=" + folder.string() + ":$PATH env --default-signal=INT ");
    EXPECT_EQ(run.code, 130) << run.text;
    for (const char* figure : {"path.svg", "forces.svg", "grip.svg"}) {
      EXPECT_EQ(read(out / figure), "<svg></svg>") << figure;
    }
  }
}

TEST(Program, APipeThatNobodyReadsIsRefused) {
  const fs::path pipe = scratch() / "pipe";
  ASSERT_EQ(std::system(("mkfifo " + pipe.string()).c_str()), 0);
  const std::string run = "run " + config("minimal.yaml") + kSoon + "--time 50ms --quiet --record " + pipe.string();
  const ProgramResult refused = thenar_program(run, "timeout 60 ");
  EXPECT_EQ(refused.code, 3) << refused.text;
  EXPECT_NE(refused.text.find("nobody reads this pipe"), std::string::npos) << refused.text;
  const ProgramResult gone = thenar_program(run, "head -c 100 " + pipe.string() + " > /dev/null & timeout 60 ");
  EXPECT_EQ(gone.code, 3) << gone.text;
  EXPECT_NE(gone.text.find("could not be written in full"), std::string::npos) << gone.text;
}

TEST(Program, SmallStacksAreRefusedByName) {
  for (const char* kilobytes : {"64", "128"}) {
    for (const std::string& arguments : {std::string("keys"), "check " + config("minimal.yaml")}) {
      const ProgramResult run = thenar_program(arguments, std::string("ulimit -s ") + kilobytes + "; ");
      EXPECT_EQ(run.code, 2) << arguments << run.text;
      EXPECT_NE(run.text.find("ulimit -s"), std::string::npos) << run.text;
    }
  }
}

TEST(Program, NamesOfFoldersAreNoOrders) {
  const fs::path folder = scratch() / "a\nb\x1b[2J";
  const ProgramResult run =
      thenar_program("run " + config("minimal.yaml") + kSoon + "--time 50ms --out '" + folder.string() + "'");
  EXPECT_EQ(run.code, 0) << run.text;
  EXPECT_EQ(run.text.find('\x1b'), std::string::npos) << run.text;
  EXPECT_NE(read(folder / "path.svg").find("</svg>"), std::string::npos);
}

// gnuplot does not look whether a disk is full.
TEST(Program, AFigureIsWholeOrMissing) {
  const fs::path folder = scratch(), whole = folder / "whole", disk = folder / "disk";
  const std::string run = "run " + config("minimal.yaml") + kSoon + "--time '0.5 s' --out ";
  ASSERT_EQ(thenar_program(run + whole.string()).code, 0);
  // Room for the numbers and half of the first figure.
  const std::uintmax_t room = fs::file_size(whole / "summary.json") + fs::file_size(whole / "signals.csv") +
                              fs::file_size(whole / "path.svg") / 2 + 8192;
  fs::create_directories(disk);
  const std::string mount = "mount -t tmpfs -o size=" + std::to_string(room) + " tmpfs " + disk.string();
  if (std::system((mount + " 2>/dev/null").c_str()) != 0) GTEST_SKIP() << "needs the right to mount a small disk";
  const ProgramResult full = thenar_program(run + disk.string());
  const std::string summary = read(disk / "summary.json"), signals = read(disk / "signals.csv");
  std::string left;
  for (const auto& entry : fs::directory_iterator(disk)) {
    const std::string name = entry.path().filename().string();
    if (name != "summary.json" && name != "signals.csv") left += name + " ";
  }
  EXPECT_EQ(std::system(("umount " + disk.string()).c_str()), 0);
  EXPECT_EQ(full.code, 3) << full.text;
  EXPECT_NE(full.text.find("path.svg: could not be written in full"), std::string::npos) << full.text;
  EXPECT_EQ(left, "") << "cut figures, or drafts";
  EXPECT_TRUE(nlohmann::json::accept(summary));
  EXPECT_EQ(signals, read(whole / "signals.csv"));
}

TEST(Program, PrintsTheSummaryAsJson) {
  const ProgramResult run = thenar_program("run " + config("minimal.yaml") + " --time '50 ms' --format json");
  ASSERT_EQ(run.code, 0) << run.text;
  const auto summary = nlohmann::json::parse(run.text);
  EXPECT_EQ(summary.at("contacts").at("max"), nullptr) << "nothing is measured before 0.3 s";
  EXPECT_EQ(summary.at("lcp").at("grasp_infeasible"), 0);
}

TEST(Program, QuietPrintsNothing) {
  EXPECT_EQ(thenar_program("run " + config("minimal.yaml") + " --time '50 ms' --quiet").text, "");
}

TEST(Program, RunsWhatASceneNeeds) {
  const ProgramResult run = thenar_program("run " + config("box_grasp.yaml") +
                                           " --set object.points=2000 --set model=auto --time '0.4 s' --format json");
  ASSERT_EQ(run.code, 0) << run.text;
  const auto summary = nlohmann::json::parse(run.text);
  EXPECT_TRUE(summary.at("muscles").is_null());
  EXPECT_NE(summary.at("parts").dump().find("left out: muscles (control.muscles)"), std::string::npos) << run.text;
}

// What the README shows is what is built and run.
/// A scan of the box: its samples with measurement noise on points and normals.
PointCloud scanned_box() {
  PointCloud cloud = sample_box({0.05, 0.05, 0.05}, 20000, 7);
  std::srand(1);  // Eigen's Random
  cloud.points_m += 0.01e-3 * Eigen::Matrix3Xd::Random(3, cloud.points_m.cols());
  cloud.normals += 0.02 * Eigen::Matrix3Xd::Random(3, cloud.normals.cols());
  cloud.normals.colwise().normalize();
  return cloud;
}

// Writes the cloud that configs/scan_grasp.yaml names, then grasps it as the scene stands.
TEST(Program, GraspsAScannedObject) {
  const fs::path file = fs::path(THENAR_CONFIGS).parent_path() / "out" / "scan" / "box.ply";
  fs::create_directories(file.parent_path());
  save_ply(file, scanned_box(), PlyFormat::kBinaryLittleEndian);
  const ProgramResult run = thenar_program("run " + config("scan_grasp.yaml") + " --format json");
  ASSERT_EQ(run.code, 0) << run.text;
  const auto summary = nlohmann::json::parse(run.text);
  EXPECT_TRUE(summary.at("grasp").at("held").get<bool>());
  // Twice what the clean box is held to: points are off by up to 10 um, normals by about a degree.
  EXPECT_LE(summary.at("object").at("final_error_mm").get<double>(), 0.2);
}

TEST(Program, RefusesBrokenClouds) {
  const fs::path folder = scratch();
  const PointCloud cloud = scanned_box();
  save_ply(folder / "whole.ply", cloud, PlyFormat::kBinaryLittleEndian);
  const std::string bytes = read(folder / "whole.ply");
  std::ofstream(folder / "truncated.ply", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  PointCloud a_point = cloud;
  a_point.points_m.setConstant(0.01);
  save_ply(folder / "point.ply", a_point, PlyFormat::kAscii);
  PointCloud flipped = cloud;
  for (Eigen::Index i = 0; i < flipped.normals.cols(); i += 5) flipped.normals.col(i) *= -1.0;
  save_ply(folder / "flipped.ply", flipped, PlyFormat::kBinaryLittleEndian);
  PointCloud repeated = cloud;
  for (Eigen::Index i = 0; i < repeated.points_m.cols(); ++i) repeated.points_m.col(i) = cloud.points_m.col(i % 12);
  save_ply(folder / "repeated.ply", repeated, PlyFormat::kBinaryLittleEndian);
  std::ofstream(folder / "bare.ply") << "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                                        "property float z\nend_header\n0 0 0\n";
  for (const char* name : {"truncated.ply", "point.ply", "bare.ply", "flipped.ply", "repeated.ply"}) {
    const ProgramResult run =
        thenar_program("run " + config("scan_grasp.yaml") + " --set object.shape.cloud=" + (folder / name).string() +
                       " --out " + (folder / "out").string());
    EXPECT_EQ(run.code, 3) << name;
    EXPECT_NE(run.text.find(name), std::string::npos) << run.text;
    EXPECT_FALSE(fs::exists(folder / "out"));
  }
}

}  // namespace
}  // namespace thenar::main_test
