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
  const Outcome run =
      thenar_program(arguments.substr(0, space) + " " + config("minimal.yaml") + arguments.substr(space));
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(run.text.find(GetParam().message), 0) << run.text;
}

INSTANTIATE_TEST_SUITE_P(
    Flags, TwoLoopsRefuse,
    testing::Values(
        BadFlag{"NoUnit", "profile --contact-rate 4000", "--contact-rate: 4000 has no unit: use Hz or kHz"},
        BadFlag{"WrongUnit", "profile --contact-rate '4 ms'", "--contact-rate: 4 ms is not a frequency"},
        BadFlag{"ZeroRate", "profile --control-rate 0Hz", "--control-rate: 0Hz must lie within 1 Hz"},
        BadFlag{"NegativeRate", "profile --contact-rate=-4kHz", "--contact-rate: -4kHz must lie within"},
        BadFlag{"NotARate", "profile --control-rate fast", "--control-rate: 'fast' is not a frequency"},
        BadFlag{"NoTime", "profile --duration 30", "--duration: 30 has no unit"},
        BadFlag{"RateForTime", "profile --spin 20kHz", "--spin: 20kHz is not a time"},
        BadFlag{"BadTolerance", "profile --tolerance 1mm", "--tolerance: 1mm must be a plain number"},
        BadFlag{"ControlFaster", "profile --contact-rate 1kHz --control-rate 2kHz",
                "--control-rate: 2kHz must not be faster than --contact-rate"},
        BadFlag{"ControlFasterThanTheDefault", "profile --control-rate 8kHz",
                "--control-rate: 8kHz must not be faster than the contact loop: give --contact-rate"},
        BadFlag{"NotATime", "run --time abc", "--time: 'abc' is not a time"},
        BadFlag{"ZeroTime", "run --time 0", "--time: 0 s must lie within"},
        BadFlag{"EmptyTime", "run --time ''", "--time: '' is not a time"},
        BadFlag{"EmptyOut", "run --out ''", "--out: needs a name"},
        BadFlag{"EmptyTrace", "profile --trace ''", "--trace: needs a name"},
        BadFlag{"TraceIntoAFolder", "profile --trace /", "--trace: / is a folder"},
        BadFlag{"TraceOverTheProfile", "profile --out nowhere --trace nowhere/../nowhere/profile.json",
                "--trace: nowhere/../nowhere/profile.json is a file of --out's own"},
        BadFlag{"RateOfOneLoop", "run --contact-rate 4kHz", "--contact-rate: needs --realtime or --lockstep"},
        BadFlag{"SpinOfLockstep", "run --lockstep --spin 50us", "--spin requires --realtime"},
        BadFlag{"NoSuchCore", "profile --core 4711", "--core: 4711 is none of the cores that the program may use: "},
        BadFlag{"NoCore", "profile --core last", "--core: last is none of the cores"},
        BadFlag{"CoreOfOneLoop", "run --core 0", "--core requires --realtime"},
        BadFlag{"DelayOfThreads", "run --realtime --control-delay 5ms", "--control-delay requires --lockstep"},
        BadFlag{"AutoOfLockstep", "run --lockstep --control-rate auto", "--control-rate: auto needs --realtime"},
        BadFlag{"TwoRunners", "run --realtime --lockstep", "--realtime excludes --lockstep"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace thenar::scene_flags_test
