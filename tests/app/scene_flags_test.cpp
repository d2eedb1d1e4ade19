// SPDX-License-Identifier: Apache-2.0
// The flags of the two loops that are refused, by name.

#include <gtest/gtest.h>

#include <string>

#include "tests/support/program.h"

namespace thenar::scene_flags_test {
namespace {

struct BadFlag {
  const char* name;
  const char* arguments;
  const char* message;
};

class TwoLoopsRefuse : public testing::TestWithParam<BadFlag> {};

TEST_P(TwoLoopsRefuse, NamingTheFlag) {
  const std::string arguments = GetParam().arguments;
  const auto space = arguments.find(' ');
  const ProgramResult run =
      thenar_program(arguments.substr(0, space) + " " + config("minimal.yaml") + arguments.substr(space));
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(run.text.find(GetParam().message), 0) << run.text;
}

INSTANTIATE_TEST_SUITE_P(
    Flags, TwoLoopsRefuse,
    testing::Values(
        BadFlag{"NoUnit", "run --realtime --contact-rate 4000", "--contact-rate: 4000 has no unit: use Hz or kHz"},
        BadFlag{"WrongUnit", "run --realtime --contact-rate '4 ms'", "--contact-rate: 4 ms is not a frequency"},
        BadFlag{"ZeroRate", "run --realtime --control-rate 0Hz", "--control-rate: 0Hz must lie within 1 Hz"},
        BadFlag{"NegativeRate", "run --realtime --contact-rate=-4kHz", "--contact-rate: -4kHz must lie within"},
        BadFlag{"NotARate", "run --realtime --control-rate fast", "--control-rate: 'fast' is not a frequency"},
        BadFlag{"RateForTime", "run --realtime --spin 20kHz", "--spin: 20kHz is not a time"},
        BadFlag{"BadTolerance", "run --realtime --tolerance 1mm", "--tolerance: 1mm must be a plain number"},
        BadFlag{"ControlFaster", "run --realtime --contact-rate 1kHz --control-rate 2kHz",
                "--control-rate: 2kHz must not be faster than --contact-rate"},
        BadFlag{"ControlFasterThanTheDefault", "run --realtime --control-rate 8kHz",
                "--control-rate: 8kHz must not be faster than the contact loop: give --contact-rate"},
        BadFlag{"NotATime", "run --time abc", "--time: 'abc' is not a time"},
        BadFlag{"ZeroTime", "run --time 0", "--time: 0 s must lie within"},
        BadFlag{"EmptyTime", "run --time ''", "--time: '' is not a time"},
        BadFlag{"EmptyOut", "run --out ''", "--out: needs a name"},
        BadFlag{"EmptyTrace", "run --realtime --trace ''", "--trace: needs a name"},
        BadFlag{"TraceIntoAFolder", "run --realtime --trace /", "--trace: / is a folder"},
        BadFlag{"TraceOverTheSummary", "run --realtime --out nowhere --trace nowhere/../nowhere/summary.json",
                "--trace: nowhere/../nowhere/summary.json is a file of --out's own"},
        BadFlag{"TraceOfOneLoop", "run --trace out.json", "--trace requires --realtime"},
        BadFlag{"FloorOfLockstep", "run --lockstep --floor", "--floor requires --realtime"},
        BadFlag{"RateOfOneLoop", "run --contact-rate 4kHz", "--contact-rate: needs --realtime or --lockstep"},
        BadFlag{"SpinOfLockstep", "run --lockstep --spin 50us", "--spin requires --realtime"},
        BadFlag{"NoSuchCore", "run --realtime --core 4711",
                "--core: 4711 is none of the cores that the program may use: "},
        BadFlag{"NoCore", "run --realtime --core last", "--core: last is none of the cores"},
        BadFlag{"CoreOfOneLoop", "run --core 0", "--core requires --realtime"},
        BadFlag{"DelayOfThreads", "run --realtime --control-delay 5ms", "--control-delay requires --lockstep"},
        BadFlag{"AutoOfLockstep", "run --lockstep --control-rate auto", "--control-rate: auto needs --realtime"},
        BadFlag{"TwoRunners", "run --realtime --lockstep", "--realtime excludes --lockstep"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace thenar::scene_flags_test
