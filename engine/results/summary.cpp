// SPDX-License-Identifier: Apache-2.0
#include "engine/results/summary.h"

#include <string_view>

#include "engine/results/run_measures.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

ordered_json as_json(std::monostate /*nothing*/) { return nullptr; }
ordered_json as_json(const Percentiles& us) { return {{"p50_us", us.p50}, {"p99_us", us.p99}}; }
template <typename T>
ordered_json as_json(const T& value) {
  return value;
}

/// The object of this key: a dot is an object within.
ordered_json& place(ordered_json& json, std::string_view key) {
  if (key.empty()) return json;
  const std::size_t dot = key.find('.');
  return place(json[std::string(key.substr(0, dot))], dot == key.npos ? "" : key.substr(dot + 1));
}

/// A section of what is at hand.
ordered_json section(const char* key, const RunView& view) { return summary_json(measure(view)).at(key); }

}  // namespace

ordered_json to_json(const MeasureValue& value) {
  return std::visit([](const auto& one) { return as_json(one); }, value);
}

ordered_json summary_json(const std::vector<MeasuredSection>& measures) {
  ordered_json summary;
  for (const auto& [section, items] : measures) {
    if (section->heading == Heading::kSweepAlone) continue;
    ordered_json& at = place(summary, section->key);
    const bool is_list = section->items != nullptr;
    if (is_list) at = ordered_json::array();
    for (const std::vector<Measured>& item : items) {
      ordered_json& object = is_list ? at.emplace_back() : at;
      for (const auto& [measure, value] : item) place(object, measure->key) = to_json(value);
    }
  }
  return summary;
}

ordered_json build_settings() { return section("build", {}); }
ordered_json loop_settings(const Scene& scene) { return section("settings", {.scene = &scene}); }
ordered_json ledger_json(const Ledger& ledger) { return section("ledger", {.ledger = &ledger}); }
ordered_json verdict_json(const Verdict& verdict) { return section("grasp", {.verdict = &verdict}); }
ordered_json summarize(const Model& model, const Recording& recording) {
  return summary_json(measure(view_of(model, recording)));
}

}  // namespace thenar
