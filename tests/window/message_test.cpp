// SPDX-License-Identifier: Apache-2.0
// Whatever a page sends: a message whose numbers are within their ranges, or a refusal with a reason.

#include "app/window/message.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "engine/loops/live_input.h"

namespace thenar::window::message_test {
namespace {

using Eigen::Vector3d;

template <class T>
T read_as(const std::string& text) {
  const ReadMessage read = read_message(text);
  EXPECT_EQ(read.refusal, "") << text;
  EXPECT_TRUE(read.message && std::holds_alternative<T>(*read.message)) << text;
  return read.message && std::holds_alternative<T>(*read.message) ? std::get<T>(*read.message) : T{};
}

std::string refusal_of(const std::string& text) {
  const ReadMessage read = read_message(text);
  EXPECT_FALSE(read.message.has_value()) << text;
  EXPECT_NE(read.refusal, "") << text;
  return read.refusal;
}

// One of each, with every key that it may have.
const std::vector<std::string> kSound = {
    R"({"type": "next"})",
    R"({"type": "ping", "t": 1234.5})",
    R"({"type": "pull", "point_m": [0.01, 0, -0.02], "handle_m": [0.1, 0.2, 0.3], "stamp_s": 12.5})",
    R"({"type": "release"})",
    R"({"type": "target", "shift_m": [0.05, -0.05, 0], "turn_rad": [0, 0.5, -0.5], "stamp_s": 12.5})",
    R"({"type": "poke", "force_N": [3, 0, 4], "stamp_s": 12.5})",
    R"({"type": "pause"})",
    R"({"type": "resume"})",
    R"({"type": "step"})",
    R"({"type": "reset"})",
    R"({"type": "speed", "value": 0.1})",
    R"({"type": "set", "friction": 0.2, "internal_force_N": 3, "max_sweeps": 60, "tolerance": 1e-7, "contact_Hz": 4000,
        "control_Hz": 200, "delay_periods": 2, "kernel": "gaussian", "level": 3,
        "asked_N_per_m": [0, 1000, 150], "asked_Nm_per_rad": [0, 0.5, 0.08]})",
    R"({"type": "find", "best": 20})",
    R"({"type": "stop_finding"})",
    R"({"type": "take", "search": 2, "grasp": 3})",
    R"({"type": "record"})",
    R"({"type": "stop_recording"})"};

TEST(ReadMessage, ReadsWhatAPageSends) {
  read_as<Next>(kSound[0]);
  EXPECT_EQ(read_as<Ping>(kSound[1]).t, 1234.5);
  const Pull pull = read_as<Pull>(kSound[2]);
  EXPECT_EQ(pull.point_m, Vector3d(0.01, 0.0, -0.02));
  EXPECT_EQ(pull.handle_m, Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(pull.stamp_s, 12.5);
  read_as<Release>(kSound[3]);
  const Target target = read_as<Target>(kSound[4]);
  EXPECT_EQ(target.shift_m, Vector3d(0.05, -0.05, 0.0));
  EXPECT_EQ(target.turn_rad, Vector3d(0.0, 0.5, -0.5));
  EXPECT_EQ(read_as<Poke>(kSound[5]).force_N, Vector3d(3.0, 0.0, 4.0));
  read_as<Pause>(kSound[6]);
  read_as<Resume>(kSound[7]);
  read_as<Step>(kSound[8]);
  read_as<Reset>(kSound[9]);
  EXPECT_EQ(read_as<Speed>(kSound[10]).value, 0.1);
  const LiveValues changes{{"friction", 0.2},
                           {"internal_force_N", 3.0},
                           {"max_sweeps", 60.0},
                           {"tolerance", 1e-7},
                           {"contact_Hz", 4000.0},
                           {"control_Hz", 200.0},
                           {"delay_periods", 2.0},
                           {"kernel", "gaussian"},
                           {"level", 3.0},
                           {"asked_N_per_m", Vector3d(0.0, 1000.0, 150.0)},
                           {"asked_Nm_per_rad", Vector3d(0.0, 0.5, 0.08)}};
  EXPECT_EQ(read_as<Set>(kSound[11]).changes, changes);
  EXPECT_EQ(read_as<Find>(kSound[12]).best, 20);
  read_as<StopFinding>(kSound[13]);
  EXPECT_EQ(read_as<Take>(kSound[14]), (Take{2, 3}));
  read_as<Record>(kSound[15]);
  read_as<StopRecording>(kSound[16]);
}

TEST(ReadMessage, LeavesOutWhatIsNotSent) {
  EXPECT_EQ(read_as<Pull>(R"({"type":"pull","point_m":[0,0,0],"handle_m":[0,0,0]})").stamp_s, std::nullopt);
  EXPECT_EQ(read_as<Set>(R"({"type":"set","friction":0})").changes, (LiveValues{{"friction", 0.0}}));
  EXPECT_EQ(read_as<Find>(R"({"type":"find"})").best, 5);
}

// A page pokes along an axis of its camera, with all the force that there is: the rounding of the axis makes the force
// longer in every fourth view.
TEST(ReadMessage, TakesVectorsThatRoundingMadeTooLong) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  int longer = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vector3d axis = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                              .normalized()
                              .toRotationMatrix()
                              .col(0);
    const Vector3d force_N = 5.0 * axis;
    longer += force_N.norm() > 5.0;
    const std::string text =
        fmt::format(R"({{"type":"poke","force_N":[{},{},{}]}})", force_N.x(), force_N.y(), force_N.z());
    const Vector3d read_N = read_as<Poke>(text).force_N;
    EXPECT_LE(read_N.norm(), 5.0);
    EXPECT_LT((read_N - force_N).norm(), 1e-10);
  }
  EXPECT_GT(longer, 50);
}

TEST(ReadMessage, SaysWhatIsWrong) {
  EXPECT_EQ(refusal_of("{"), "this is no JSON");
  EXPECT_EQ(refusal_of("[]"), "this is no JSON object");
  EXPECT_EQ(refusal_of("{}"), "type must say what this message is");
  EXPECT_EQ(refusal_of(R"({"type":"explode"})"), "there is no type 'explode'");
  EXPECT_EQ(refusal_of(R"({"type":"next","now":1})"), "there is no key 'now'");
  EXPECT_EQ(refusal_of(R"({"type":"next","type":"reset"})"), "there are two keys 'type'");
  EXPECT_EQ(refusal_of(R"({"type":"speed"})"), "value is missing");
  EXPECT_EQ(refusal_of(R"({"type":"speed","value":"1"})"), "value must be a number");
  EXPECT_EQ(refusal_of(R"({"type":"speed","value":2})"), "value must lie within 0.001 .. 1");
  EXPECT_EQ(refusal_of(R"({"type":"poke","force_N":[5,0,1]})"), "force_N must not be longer than 5 N");
  EXPECT_EQ(refusal_of(R"({"type":"poke","force_N":[1,2]})"), "force_N must be three numbers");
  EXPECT_EQ(refusal_of(R"({"type":"poke","force_N":[1,2,null]})"), "force_N must be a number");
  EXPECT_EQ(refusal_of(R"({"type":"poke","force_N":[1,2,[[3]]]})"), "force_N must be a number");
  EXPECT_EQ(refusal_of(R"({"type":"set"})"), "set needs something to set");
  EXPECT_EQ(refusal_of(R"({"type":"set","level":1.5})"), "level must be a whole number");
  EXPECT_EQ(refusal_of(R"({"type":"set","kernel":"cubic"})"), "kernel must be boussinesq or gaussian");
  EXPECT_EQ(refusal_of(R"({"type":"set","asked_N_per_m":150})"), "asked_N_per_m must be three numbers");
  EXPECT_EQ(refusal_of(R"({"type":"set","asked_N_per_m":[1,2,-3]})"), "asked_N_per_m must lie within 0 .. 1000");
  EXPECT_EQ(refusal_of(R"({"type":"find","best":0})"), "best must lie within 1 .. 20");
  EXPECT_EQ(refusal_of(R"({"type":"record","file":"/etc/passwd"})"), "there is no key 'file'");
  EXPECT_EQ(refusal_of(R"({"type":"take","search":1})"), "grasp is missing");
  EXPECT_EQ(refusal_of(R"({"type":"take","search":1,"grasp":1.5})"), "grasp must be a whole number");
}

TEST(ReadMessage, RefusesWhatIsNoFiniteNumber) {
  for (const char* number : {"NaN", "Infinity", "1e999", "-1e999", "nan", "1e308", "123456789012345678901234567890"}) {
    refusal_of(std::string(R"({"type":"poke","force_N":[0,0,)") + number + "]}");
    refusal_of(std::string(R"({"type":"set","max_sweeps":)") + number + "}");
  }
}

TEST(ReadMessage, RefusesWhatIsTooLong) {
  const std::string next = R"({"type":"next"})";
  read_as<Next>(next + std::string(kMaxMessage - next.size(), ' '));
  EXPECT_EQ(refusal_of(next + std::string(kMaxMessage + 1 - next.size(), ' ')), "a message has at most 4096 bytes");
  // Deep nesting is no reason to fail, either.
  refusal_of(std::string(kMaxMessage, '['));
  refusal_of(R"({"type":"next","x":)" + std::string(2000, '[') + std::string(2000, ']') + "}");
}

bool within(double value, double low, double high) { return value >= low && value <= high; }
bool within(const std::optional<double>& value, double low, double high) { return !value || within(*value, low, high); }
bool within(const Set& set, const char* name, double low, double high) {
  const auto value = set.changes.find(name);
  if (value == set.changes.end()) return true;
  if (const auto* number = std::get_if<double>(&value->second)) return within(*number, low, high);
  const auto& three = std::get<Vector3d>(value->second);
  return (three.array() >= low && three.array() <= high).all();
}

/// The ranges of docs/reference/window.md, written once more.
struct InRange {
  bool operator()(const Ping& ping) const { return std::isfinite(ping.t); }
  bool operator()(const Pull& pull) const {
    return pull.point_m.norm() <= 1.0 && pull.handle_m.norm() <= 1.0 && within(pull.stamp_s, 0.0, 1e9);
  }
  bool operator()(const Target& target) const {
    return target.shift_m.cwiseAbs().maxCoeff() <= 0.05 && target.turn_rad.cwiseAbs().maxCoeff() <= 0.5 &&
           within(target.stamp_s, 0.0, 1e9);
  }
  bool operator()(const Poke& poke) const { return poke.force_N.norm() <= 5.0 && within(poke.stamp_s, 0.0, 1e9); }
  bool operator()(const Speed& speed) const { return within(speed.value, 0.001, 1.0); }
  bool operator()(const Set& set) const {
    const auto kernel = set.changes.find("kernel");
    return within(set, "friction", 0.0, 2.0) && within(set, "internal_force_N", 0.1, 20.0) &&
           within(set, "max_sweeps", 1.0, 1000.0) && within(set, "tolerance", 1e-10, 0.1) &&
           within(set, "contact_Hz", 200.0, 10000.0) && within(set, "control_Hz", 20.0, 2000.0) &&
           within(set, "delay_periods", 0.0, 8.0) && within(set, "level", 0.0, 6.0) &&
           within(set, "asked_N_per_m", 0.0, 1000.0) && within(set, "asked_Nm_per_rad", 0.0, 0.5) &&
           (kernel == set.changes.end() || kernel->second == LiveValue("boussinesq") ||
            kernel->second == LiveValue("gaussian"));
  }
  bool operator()(const Find& find) const { return within(find.best, 1.0, 20.0); }
  bool operator()(const Take& take) const { return within(take.search, 0.0, 1e9) && within(take.grasp, 0.0, 20.0); }
  template <class Order>
  bool operator()(const Order&) const {
    return true;
  }
};

// Sound messages with bytes changed, cut, doubled, and with numbers put in that programs trip over.
TEST(ReadMessage, HoldsItsRangesWhateverTheText) {
  const std::vector<std::string> pieces = {"1e308", "-1e-308", "NaN",  "null", "-0",       "1e999",
                                           "{}",    "[]",      "\"\"", "true", "\xff",     "\\u0000",
                                           "0x1",   "1e-400",  ",",    ":",    "\"type\"", "5.1"};
  std::size_t taken = 0, refused = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
    for (int i = 0; i < 2000; ++i) {
      std::string text = kSound[below(kSound.size())];
      for (std::size_t changes = 1 + below(3); changes > 0 && !text.empty(); --changes) {
        const std::size_t place = below(text.size());
        switch (below(5)) {
          case 0:
            text[place] = static_cast<char>(below(256));
            break;
          case 1:
            text.insert(place, pieces[below(pieces.size())]);
            break;
          case 2:
            text.erase(place, 1 + below(8));
            break;
          case 3:
            text.insert(place, text.substr(below(text.size()), below(40)));
            break;
          default:  // A number in place of another.
            for (std::size_t at = text.find_first_of("0123456789", place); at != text.npos; at = text.npos) {
              const std::size_t end = text.find_first_not_of("0123456789.e-", at);
              text.replace(at, end - at, pieces[below(pieces.size())]);
            }
        }
      }
      const ReadMessage read = read_message(text);
      ASSERT_NE(read.message.has_value(), !read.refusal.empty()) << "seed " << seed << ": " << text;
      if (read.message) {
        ASSERT_TRUE(std::visit(InRange{}, *read.message)) << "seed " << seed << ": " << text;
      }
      ++(read.message ? taken : refused);
    }
  }
  EXPECT_GT(taken, 1000U) << "else the test shows little";
  EXPECT_GT(refused, 1000U);
}

// The limits are those that the contact loop holds, too.
TEST(ReadMessage, KeepsTheLimitsOfTheLoop) {
  EXPECT_EQ(thenar::kPokeLimit_N, 5.0);
  EXPECT_EQ(thenar::kShiftLimit_m, 0.05);
  EXPECT_EQ(thenar::kTurnLimit_rad, 0.5);
}

}  // namespace
}  // namespace thenar::window::message_test
