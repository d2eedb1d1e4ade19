// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <numbers>
#include <random>
#include <string>

#include "tests/imports/made_hands.h"

/// What made hands are made of.
namespace thenar::made {

using Vector = std::array<double, 3>;

/// Numbers by a seed.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : bits_(seed) {}

  double in(double least, double most) { return least + (most - least) * static_cast<double>(bits_() >> 11) * 0x1p-53; }
  int below(int number) { return static_cast<int>(in(0.0, number)); }
  bool is(double share = 0.5) { return in(0.0, 1.0) < share; }
  template <typename T>
  T one_of(std::initializer_list<T> all) {
    return *(all.begin() + below(static_cast<int>(all.size())));
  }
  Vector direction() {
    Vector v;
    double square = 0.0;
    do {
      v = {in(-1, 1), in(-1, 1), in(-1, 1)};
      square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    } while (square > 1.0 || square < 0.05);
    for (double& x : v) x /= std::sqrt(square);
    return v;
  }
  Vector near(const Vector& middle, double by) {
    return {middle[0] + in(-by, by), middle[1] + in(-by, by), middle[2] + in(-by, by)};
  }

 private:
  std::mt19937_64 bits_;
};

inline std::string text_of(const Vector& v) { return fmt::format("{:.9g} {:.9g} {:.9g}", v[0], v[1], v[2]); }

inline constexpr double kDegree = std::numbers::pi / 180.0;

/// What differs among the kinds; each function adds attributes or elements, in which single quotes enclose values.
struct Style {
  bool degrees = true;
  std::string compiler;              ///< Its other attributes.
  std::string before, after;         ///< Sections before and behind the world.
  std::string palm = "name='palm'";  ///< Attributes of the palm.
  std::function<std::string(const std::string&)> name = [](const std::string& n) { return "name='" + n + "'"; };
  std::function<std::string()> turn = [] { return ""; };  ///< Orientation of a body.
  /// Joints of a link, and what it has besides.
  std::function<std::string(int finger, int link)> joints, parts = [](int, int) { return ""; };
  std::string in_palm;
  std::string open_world, close_world;  ///< Bodies about the palm.
  std::string childclass;               ///< Attribute of the fingers' first bodies.
};

inline constexpr const char* kFingers = "tim";
inline constexpr int kLinks = 3;

inline std::string link_name(int finger, int link) { return fmt::format("{}{}", kFingers[finger], link + 1); }
inline double thumb_sign(int finger) { return finger == 0 ? -1.0 : 1.0; }

inline std::string angles(const Style& style, double low_deg, double high_deg) {
  const double unit = style.degrees ? 1.0 : kDegree;
  return fmt::format("{:.9g} {:.9g}", unit * low_deg, unit * high_deg);
}

/// Writes an MJCF of three fingers of three links.
[[nodiscard]] MadeHand written(Dice& dice, const Style& style);

/// A hinge that flexes a link, with limits.
[[nodiscard]] std::string plain_joint(Dice& dice, const Style& style, int finger, int link);

/// A capsule along a link.
[[nodiscard]] std::string plain_geom(Dice& dice);

[[nodiscard]] MadeHand strings(Dice& dice);
[[nodiscard]] MadeHand wraps(Dice& dice);
[[nodiscard]] MadeHand ties(Dice& dice);
[[nodiscard]] MadeHand actuators(Dice& dice);
[[nodiscard]] MadeHand urdf(Dice& dice, bool mimics);

}  // namespace thenar::made
