// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/hand_request.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>

#include "engine/formats/byte_source.h"
#include "engine/formats/text.h"
#include "engine/scenes/config.h"
#include "engine/scenes/units.h"

namespace thenar {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

[[noreturn]] void refuse_flag(const char* flag, const std::string& text, const std::string& what) {
  throw ConfigError({{fmt::format("{} {}", flag, printable(text)), "", printable(what)}});
}

/// Splits at separators that stand in no double quotes, which stay.
std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts(1);
  bool is_quoted = false;
  for (const char c : text) {
    if (c == '"') is_quoted = !is_quoted;
    if (c == separator && !is_quoted) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

constexpr const char* kHowToQuote = "a name with ':' or ',' stands in quotes, as in 'thumb=\"robot0:tip\":9mm'";

/// Reads a name that may be in double quotes, in which two are one; nothing if they do not enclose it.
std::optional<std::string> unquoted(std::string_view text) {
  if (!text.starts_with('"')) return std::string(text);
  if (text.size() < 2 || !text.ends_with('"')) return std::nullopt;
  text = text.substr(1, text.size() - 2);
  std::string name;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"' && (++i == text.size() || text[i] != '"')) return std::nullopt;
    name += text[i];
  }
  return name;
}

/// "-x" as a unit vector.
std::optional<Vector3d> signed_axis(std::string_view text) {
  double sign = 1.0;
  if (text.starts_with('+') || text.starts_with('-')) {
    if (text.front() == '-') sign = -1.0;
    text.remove_prefix(1);
  }
  const std::size_t axis = std::string_view("xyz").find(text);
  if (text.size() != 1 || axis == std::string_view::npos) return std::nullopt;
  return sign * Vector3d::Unit(static_cast<Eigen::Index>(axis));
}

/// Three numbers between slashes.
std::optional<Vector3d> triple(std::string_view text) {
  const std::vector<std::string> parts = split(text, '/');
  if (parts.size() != 3) return std::nullopt;
  Vector3d v;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const std::optional<double> number = number_in<double>(parts[static_cast<std::size_t>(i)]);
    if (!number || !(std::abs(*number) <= 1e6)) return std::nullopt;
    v[i] = *number;
  }
  return v;
}

/// "0/-36/14.5mm" in m.
std::optional<Vector3d> place_m(std::string_view text) {
  const std::size_t unit = text.find_first_not_of("+-0123456789.eE/");
  if (unit == std::string_view::npos) return std::nullopt;
  const Quantity one = read_quantity("1 " + std::string(text.substr(unit)), Dimension::kLength);
  const std::optional<Vector3d> numbers = triple(text.substr(0, unit));
  if (!one.fault.empty() || !numbers) return std::nullopt;
  return one.value * *numbers;
}

/// Whether it is a part of a name with colons: it begins as no detail does.
bool continues_name(const std::string& part) {
  return !part.empty() && std::isalpha(static_cast<unsigned char>(part.front())) != 0 && !signed_axis(part);
}

void read_detail(const std::string& part, TipRequest& tip) {
  constexpr const char* kFlag = "--tips";
  if (part.starts_with('@')) {
    tip.centre_m = place_m(std::string_view(part).substr(1));
    if (!tip.centre_m) refuse_flag(kFlag, tip.text, fmt::format("'{}' is no place: write it as @0/-36/14.5mm", part));
    return;
  }
  std::optional<Vector3d> normal = signed_axis(part);
  if (!normal) normal = triple(part);
  if (normal) {
    if (!(normal->norm() > 1e-10)) refuse_flag(kFlag, tip.text, "a direction must not be zero");
    tip.normal = normal->normalized();
    return;
  }
  const Quantity radius = read_quantity(part, Dimension::kLength);
  if (!radius.fault.empty()) {
    refuse_flag(kFlag, tip.text,
                fmt::format("'{}' is no radius (9mm), no place (@0/-36/14.5mm) and no direction (-x, or 0/1/0.3); {}",
                            part, kHowToQuote));
  }
  if (radius.value < 1e-3 || radius.value > 0.05) {
    refuse_flag(kFlag, tip.text, fmt::format("the radius {} must be within 1 mm and 50 mm", part));
  }
  tip.radius_m = radius.value;
}

}  // namespace

std::vector<std::string> split_tips(std::string_view text) {
  std::vector<std::string> tips = split(text, ',');
  for (std::string& tip : tips) {
    const std::size_t first = std::min(tip.find_first_not_of(' '), tip.size());
    tip = tip.substr(first, tip.find_last_not_of(' ') + 1 - first);
  }
  return tips;
}

TipRequest read_tip(const std::string& text) {
  TipRequest tip;
  tip.text = text;
  const std::size_t equals = text.find('=');
  if (first_unprintable(text) != std::string::npos || equals == std::string::npos || equals == 0) {
    refuse_flag("--tips", text,
                fmt::format("write it as FINGER=BODY, such as thumb=th_tip, or thumb=th_tip:9mm; {}", kHowToQuote));
  }
  tip.finger = text.substr(0, equals);
  const std::vector<std::string> parts = split(std::string_view(text).substr(equals + 1), ':');
  const std::optional<std::string> name = unquoted(parts.front());
  if (!name) refuse_flag("--tips", text, fmt::format("its quotes enclose no name: {}", kHowToQuote));
  tip.place = *name;
  std::size_t next = 1;
  const bool may_go_on = !parts.front().starts_with('"');
  while (may_go_on && next < parts.size() && continues_name(parts[next])) tip.place += ":" + parts[next++];
  if (tip.place.empty()) refuse_flag("--tips", text, "names no body or site");
  for (; next < parts.size(); ++next) read_detail(parts[next], tip);
  return tip;
}

LockRequest read_lock(const std::string& text) {
  LockRequest lock;
  const std::size_t equals = text.find('=');
  lock.joint = text.substr(0, equals);
  if (lock.joint.empty()) refuse_flag("--lock", text, "write it as JOINT, or JOINT=20deg");
  if (equals == std::string::npos) return lock;
  const Quantity angle = read_quantity(text.substr(equals + 1), Dimension::kAngle);
  if (!angle.fault.empty()) refuse_flag("--lock", text, angle.fault);
  lock.value = angle.value;
  return lock;
}

Matrix3d read_axes(const std::string& text) {
  const std::vector<std::string> parts = split(text, ',');
  const std::optional<Vector3d> x = signed_axis(parts.front()), y = signed_axis(parts.back());
  if (parts.size() != 2 || !x || !y || x->dot(*y) != 0.0) {
    refuse_flag("--axes", text, "write it as the two axes of the base that the hand's X and Y are, such as z,-x");
  }
  Matrix3d R;
  R << *x, *y, x->cross(*y);
  return R;
}

}  // namespace thenar
