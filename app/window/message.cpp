// SPDX-License-Identifier: Apache-2.0
#include "app/window/message.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "engine/loops/live_input.h"
#include "engine/scenes/key_table.h"

namespace thenar::window {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

constexpr double kPointLimit_m = 1.0;
constexpr double kRounding = 1e-12;    // Of a length, relative.
constexpr double kStampLimit_s = 1e9;  // Thirty years of a clock that begins when the machine does.

/// The keys of a message, each of which is asked for. The first thing that is wrong is kept; what is asked for after it
/// is harmless.
class Keys {
 public:
  explicit Keys(const json& message) : message_(message) {}

  double number(std::string_view key, double low, double high) { return number_of(find(key, true), key, low, high); }
  std::optional<double> number_or_none(std::string_view key, double low, double high, bool is_whole = false) {
    const json* const value = find(key, false);
    if (value == nullptr) return std::nullopt;
    const double number = number_of(value, key, low, high);
    if (is_whole && number != std::floor(number)) refuse(fmt::format("{} must be a whole number", key));
    return number;
  }
  std::optional<int> whole_or_none(std::string_view key, int low, int high) {
    const std::optional<double> value = number_or_none(key, low, high, true);
    return value ? std::optional(static_cast<int>(*value)) : std::nullopt;
  }
  /// What a key of a scene is to be that messages call by its live name.
  std::optional<LiveValue> live_or_none(const thenar::Key& row) {
    const thenar::LiveKey& live = row.live;
    if (row.items > 1) return vector_or_none(live.name, live.least, live.most);
    if (live.least < live.most) return number_or_none(live.name, live.least, live.most, live.whole);
    return one_of(live.name, words_of(row));
  }

  int whole(std::string_view key, int low, int high) {
    const std::optional<int> value = whole_or_none(key, low, high);
    if (!value) refuse(fmt::format("{} is missing", key));
    return value.value_or(low);
  }

  /// Three numbers, each within +-limit.
  Vector3d vector(std::string_view key, double limit) {
    const json* const list = find(key, true);
    return list == nullptr ? Vector3d::Zero() : three_of(*list, key, -limit, limit);
  }
  std::optional<Vector3d> vector_or_none(std::string_view key, double low, double high) {
    const json* const list = find(key, false);
    return list == nullptr ? std::nullopt : std::optional(three_of(*list, key, low, high));
  }
  /// Three numbers whose length is at most `limit`. Who sends a vector just as long may have rounded it up: it is cut.
  Vector3d vector_within(std::string_view key, double limit, const char* unit) {
    const Vector3d value = vector(key, std::numeric_limits<double>::max());
    const double length = value.norm();
    if (length <= limit) return value;
    if (length > (1.0 + kRounding) * limit) refuse(fmt::format("{} must not be longer than {} {}", key, limit, unit));
    return value * ((1.0 - kRounding) * limit / length);
  }

  std::optional<std::string> one_of(std::string_view key, const std::vector<std::string_view>& values) {
    const json* const value = find(key, false);
    if (value == nullptr) return std::nullopt;
    if (value->is_string() && std::ranges::find(values, value->get<std::string>()) != values.end()) return *value;
    refuse(fmt::format("{} must be {}", key, fmt::join(values, " or ")));
    return std::nullopt;
  }

  /// When the input was made, by the server's clock.
  std::optional<double> stamp() { return number_or_none("stamp_s", 0.0, kStampLimit_s); }

  void refuse(const std::string& why) {
    if (refusal_.empty()) refusal_ = why;
  }
  /// Why the message is refused, now that all of its keys were asked for; empty: it is not.
  std::string refusal() {
    for (const auto& [key, value] : message_.items()) {
      if (!asked_.contains(key)) refuse(fmt::format("there is no key '{:.40}'", key));
    }
    return refusal_;
  }

 private:
  const json* find(std::string_view key, bool needed) {
    asked_.emplace(key);
    const auto place = message_.find(key);
    if (place != message_.end()) return &*place;
    if (needed) refuse(fmt::format("{} is missing", key));
    return nullptr;
  }

  double number_of(const json* value, std::string_view key, double low, double high) {
    if (value == nullptr) return low;
    if (!value->is_number()) {
      refuse(fmt::format("{} must be a number", key));
      return low;
    }
    const double number = value->get<double>();
    if (number >= low && number <= high) return number;
    refuse(fmt::format("{} must lie within {} .. {}", key, low, high));
    return low;
  }

  Vector3d three_of(const json& list, std::string_view key, double low, double high) {
    Vector3d value = Vector3d::Zero();
    if (!list.is_array() || list.size() != 3) {
      refuse(fmt::format("{} must be three numbers", key));
      return value;
    }
    for (int i = 0; i < 3; ++i) value[i] = number_of(&list[i], key, low, high);
    return value;
  }

  const json& message_;
  std::set<std::string> asked_ = {"type"};
  std::string refusal_;
};

/// All keys of a scene that can be changed while it runs, in the ranges of the table of keys.
Set read_set(Keys& keys) {
  Set set;
  for (const thenar::Key& row : thenar::scene_keys()) {
    if (row.live.name.empty()) continue;
    if (std::optional<LiveValue> value = keys.live_or_none(row)) set.changes.emplace(row.live.name, *std::move(value));
  }
  return set;
}

/// The message of that type; nothing if there is none.
std::optional<Message> read_type(const std::string& type, Keys& keys) {
  using thenar::kPokeLimit_N, thenar::kShiftLimit_m, thenar::kTurnLimit_rad;
  if (type == "next") return Next{};
  if (type == "ping") return Ping{keys.number("t", -1e15, 1e15)};
  if (type == "pull") {
    const Vector3d point_m = keys.vector_within("point_m", kPointLimit_m, "m");
    const Vector3d handle_m = keys.vector_within("handle_m", kPointLimit_m, "m");
    return Pull{point_m, handle_m, keys.stamp()};
  }
  if (type == "release") return Release{};
  if (type == "target") {
    const Vector3d shift_m = keys.vector("shift_m", kShiftLimit_m);
    const Vector3d turn_rad = keys.vector("turn_rad", kTurnLimit_rad);
    return Target{shift_m, turn_rad, keys.stamp()};
  }
  if (type == "poke") {
    const Vector3d force_N = keys.vector_within("force_N", kPokeLimit_N, "N");
    return Poke{force_N, keys.stamp()};
  }
  if (type == "pause") return Pause{};
  if (type == "resume") return Resume{};
  if (type == "step") return Step{};
  if (type == "reset") return Reset{};
  if (type == "speed") return Speed{keys.number("value", 0.001, 1.0)};
  if (type == "set") return read_set(keys);
  if (type == "find") return Find{keys.whole_or_none("best", 1, 20).value_or(Find{}.best)};
  if (type == "stop_finding") return StopFinding{};
  if (type == "record") return Record{};
  if (type == "stop_recording") return StopRecording{};
  if (type == "take") return Take{keys.whole("search", 0, 1'000'000'000), keys.whole("grasp", 0, 20)};
  return std::nullopt;
}

/// The object that the text is; else what is wrong with it.
json parse(std::string_view text, std::string& fault) {
  std::set<std::string> keys;
  std::string doubled;
  const auto look = [&](int depth, json::parse_event_t event, json& parsed) {
    if (depth == 1 && event == json::parse_event_t::key && !keys.insert(parsed.get<std::string>()).second) {
      doubled = parsed.get<std::string>();
    }
    return depth <= 2;  // A list of numbers in an object; what is deeper is left out, and missed.
  };
  json message = json::parse(text.begin(), text.end(), look, false);
  if (message.is_discarded())
    fault = "this is no JSON";
  else if (!message.is_object())
    fault = "this is no JSON object";
  else if (!doubled.empty())
    fault = fmt::format("there are two keys '{:.40}'", doubled);
  return message;
}

}  // namespace

ReadMessage read_message(std::string_view text) {
  if (text.size() > kMaxMessage) return {{}, fmt::format("a message has at most {} bytes", kMaxMessage)};
  std::string fault;
  const json object = parse(text, fault);
  if (!fault.empty()) return {{}, fault};
  const auto type = object.find("type");
  if (type == object.end() || !type->is_string()) return {{}, "type must say what this message is"};
  Keys keys(object);
  std::optional<Message> message = read_type(*type, keys);
  if (!message) return {{}, fmt::format("there is no type '{:.40}'", type->get<std::string>())};
  if (std::holds_alternative<Set>(*message) && object.size() == 1) keys.refuse("set needs something to set");
  const std::string refusal = keys.refusal();
  if (!refusal.empty()) return {{}, refusal};
  return {std::move(message), ""};
}

}  // namespace thenar::window
