// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/units.h"

#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "engine/scenes/config.h"
#include "engine/scenes/keys.h"
#include "tests/scenes/config_faults.h"

namespace thenar::units_test {
namespace {

using namespace config_faults;

/// Reads `value: <text>` as a quantity; the fault after its key if there is one.
std::string fault_of(const std::string& value, Dimension dimension) {
  const Lines lines = faults({key("value", kQuantity, "", dimension)}, "value: " + value,
                             [&](const ConfigMap& map) { (void)map.quantity("value"); });
  if (lines.empty()) return "";
  EXPECT_EQ(lines.size(), 1u);
  const std::string prefix = "1:8: value: ";
  EXPECT_TRUE(lines[0].starts_with(prefix)) << lines[0];
  return lines[0].substr(prefix.size());
}

TEST(Config, ReadsEveryUnit) {
  struct Case {
    Dimension dimension;
    const char* text;
    double value;
  };
  for (const Case& c : std::vector<Case>{
           {kNone, "-1.5e2", -150.0},
           {kNone, "+.5", 0.5},
           {kLength, "2 m", 2.0},
           {kLength, "2 cm", 0.02},
           {kLength, "2 mm", 0.002},
           {kLength, "2um", 2e-6},
           {kTime, "3 s", 3.0},
           {kTime, "3 ms", 3e-3},
           {kTime, "'3 us'", 3e-6},
           {kMass, "5 kg", 5.0},
           {kMass, "5 g", 5e-3},
           {kForce, "6 N", 6.0},
           {kForce, "6 mN", 6e-3},
           {kTorque, "7 N*m", 7.0},
           {kTorque, "7 N*mm", 7e-3},
           {kAngle, "8 rad", 8.0},
           {kAngle, "180 deg", std::numbers::pi},
           {kAcceleration, "-9.81 m/s^2", -9.81},
           {kPressure, "1 Pa", 1.0},
           {kPressure, "1 kPa", 1e3},
           {kPressure, "1 MPa", 1e6},
           {kStiffness, "1 N/m", 1.0},
           {kStiffness, "1 N/mm", 1e3},
           {kRotationalStiffness, "1 N*m/rad", 1.0},
           {kDamping, "1 N*s/m", 1.0},
           {kRotationalDamping, "1 N*m*s", 1.0},
           {kRotationalDamping, "1 N*m*s/rad", 1.0},
           {kIntegralGain, "1 N/(m*s)", 1.0},
           {kRotationalIntegralGain, "1 N*m/(rad*s)", 1.0},
           {kFrequency, "200 Hz", 200.0},
           {kFrequency, "4kHz", 4e3},
           {kForceRate, "2 N/s", 2.0},
           {kRate, "5 1/s", 5.0},
           {kSpeed, "20 mm/s", 0.02},
       }) {
    const Table table{key("value", kQuantity, "", c.dimension)};
    Config config(scene_file(std::string("value: ") + c.text), table);
    EXPECT_EQ(config.root().quantity("value"), c.value) << c.text;
    EXPECT_NO_THROW(config.finish()) << c.text;
  }
}

TEST(Config, RefusesWhatIsNoQuantity) {
  EXPECT_EQ(fault_of("5", kLength), "5 has no unit: use m, cm, mm or um");
  EXPECT_EQ(fault_of("5 kg", kLength), "5 kg is not a length: use m, cm, mm or um");
  EXPECT_EQ(fault_of("5 MM", kLength), "5 MM is not a length: use m, cm, mm or um");
  EXPECT_EQ(fault_of("5 N*m", kRotationalStiffness), "5 N*m is not a rotational stiffness: use N*m/rad");
  EXPECT_EQ(fault_of("five mm", kLength), "'five mm' is not a length: use m, cm, mm or um");
  EXPECT_EQ(fault_of("auto", kNone), "'auto' is not a plain number");
  EXPECT_EQ(fault_of("''", kNone), "'' is not a plain number");
  EXPECT_EQ(fault_of("5 mm", kNone), "5 mm must be a plain number, without 'mm'");
  EXPECT_EQ(fault_of("0x10", kNone), "0x10 must be a plain number, without 'x10'");
  EXPECT_EQ(fault_of(".nan", kNone), ".nan is not a finite number");
  EXPECT_EQ(fault_of("-.inf", kLength), "-.inf is not a finite number");
  EXPECT_EQ(fault_of("1e999 m", kLength), "1e999 m is not a finite number");
  EXPECT_EQ(fault_of("1e308 MPa", kPressure), "1e308 MPa is not a finite number");
  EXPECT_EQ(fault_of("0,5 mm", kLength), "0,5 mm is not a length: the mark in a number is '.', not ','");
  EXPECT_EQ(fault_of("0,5", kNone), "0,5 must be a plain number: the mark in a number is '.', not ','");
  EXPECT_EQ(fault_of("\u22125 mm", kLength), "'\u22125 mm' is not a length: its minus is a dash, write '-'");
  EXPECT_EQ(fault_of("5\u00A0mm", kLength), "5\u00A0mm is not a length: its blank is a no-break space, write a blank");
  EXPECT_EQ(fault_of("[1 m]", kLength), "must be a length, not a list");
  EXPECT_EQ(fault_of("{a: 1 m}", kLength), "must be a length, not a map");
}

}  // namespace
}  // namespace thenar::units_test
