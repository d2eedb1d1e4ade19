// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/recording_schemas.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/formats/foxglove.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

/// What the raw messages hold, in words.
std::string state_schema(const std::vector<Field>& fields, const ordered_json& contact_fields) {
  std::string text = "THNR, version and kind (2) as uint16, then float64, little-endian:\n";
  const auto add = [&text](const Field& field) {
    text += fmt::format("{} [{}] at {}, {} numbers\n", field.name, field.unit.empty() ? "1" : field.unit, field.begin,
                        field.count);
  };
  for (const Field& field : fields) add(field);
  text += "then a row for each contact:\n";
  for (const ordered_json& of : contact_fields) add({of.at("name"), of.at("unit"), of.at("begin"), of.at("count")});
  return text;
}

ordered_json signals_schema(const std::vector<SignalColumn>& columns) {
  ordered_json properties = ordered_json::object();
  for (const SignalColumn& column : columns) {
    properties[column.name] = {{"type", "number"}, {"description", column.unit.empty() ? "no unit" : column.unit}};
  }
  return {{"title", "thenar.Signals"}, {"type", "object"}, {"properties", properties}};
}

ordered_json status_schema() {
  ordered_json example = {{"type", "status"},
                          {"running", true},
                          {"paused", false},
                          {"speed", 1.0},
                          {"outcome", "held"},
                          {"reason", ""},
                          {"warnings", {"a sentence"}},
                          {"note", ""},
                          {"scheduling", ""}};
  example["settings"] = {{"friction", 1.0},   {"internal_force_N", 1.0}, {"max_sweeps", 1},    {"tolerance", 1.0},
                         {"contact_Hz", 1.0}, {"control_Hz", 1.0},       {"delay_periods", 1}, {"kernel", ""},
                         {"level", 1}};
  ordered_json schema = schema_like(example);
  schema["title"] = "thenar.Status";
  schema["required"] = {"type", "outcome", "reason"};
  return schema;
}

/// Members of both, where either has them.
void merge(ordered_json& schema, const ordered_json& more) {
  for (const auto& [name, member] : more.at("properties").items()) {
    if (!schema["properties"].contains(name)) schema["properties"][name] = member;
  }
}

/// Null where there is no word for it.
ordered_json member_like(const ordered_json& value) {
  if (value.is_object()) return schema_like(value);
  if (value.is_string()) return {{"type", "string"}};
  if (value.is_boolean()) return {{"type", "boolean"}};
  if (value.is_number_float()) return {{"type", "number"}};
  if (value.is_number()) return {{"type", "integer"}};
  if (!value.is_array() || value.empty()) return nullptr;
  ordered_json items = member_like(value[0]);
  if (items.is_null() || value[0].is_array()) return nullptr;
  if (value[0].is_object()) {
    for (const ordered_json& other : value) merge(items, schema_like(other));
  }
  return {{"type", "array"}, {"items", items}};
}

}  // namespace

ordered_json schema_like(const ordered_json& message) {
  ordered_json properties = ordered_json::object();
  for (const auto& [name, value] : message.items()) {
    const ordered_json member = member_like(value);
    if (!member.is_null()) properties[name] = member;
  }
  return {{"type", "object"}, {"properties", properties}};
}

std::vector<McapChannel> recording_channels(const ordered_json& scene, const std::vector<Field>& fields,
                                            const std::vector<SignalColumn>& columns) {
  ordered_json scene_schema = schema_like(scene);
  scene_schema["title"] = "thenar.Scene";
  scene_schema["required"] = {"type", "version", "name", "fields", "contact_fields", "fingers", "segments", "object"};
  const std::string entities = foxglove::scene_update_schema().dump();
  const auto shown = [&](const char* topic) {
    return McapChannel{topic, "json", "foxglove.SceneUpdate", "jsonschema", entities};
  };
  return {
      {"/scene", "json", "thenar.Scene", "jsonschema", scene_schema.dump()},
      {"/geometry", "thenar", "thenar.Geometry", "text",
       "THNR, version and kind (1) as uint16, then float32, little-endian: points and normals as /scene counts them"},
      {"/state", "thenar", "thenar.State", "text", state_schema(fields, scene.at("contact_fields"))},
      {"/signals", "json", "thenar.Signals", "jsonschema", signals_schema(columns).dump()},
      {"/status", "json", "thenar.Status", "jsonschema", status_schema().dump()},
      {"/contacts", "thenar", "thenar.Contacts", "text",
       "THNR, version and kind (3) as uint16, then forces and slips of the same contacts in some ticks"},
      {"/tf", "json", "foxglove.FrameTransforms", "jsonschema", foxglove::frame_transforms_schema().dump()},
      shown("/hand"),
      shown("/object"),
      shown("/forces"),
      shown("/pressures"),
      {"/log", "json", "foxglove.Log", "jsonschema", foxglove::log_schema().dump()}};
}

ordered_json without_unknowns(const ordered_json& message) {
  if (message.is_array()) {
    ordered_json list = ordered_json::array();
    for (const ordered_json& value : message) list.push_back(without_unknowns(value));
    return list;
  }
  if (!message.is_object()) return message;
  ordered_json kept = ordered_json::object();
  for (const auto& [name, value] : message.items()) {
    const bool unknown = value.is_null() || (value.is_number_float() && !std::isfinite(value.get<double>()));
    if (!unknown) kept[name] = without_unknowns(value);
  }
  return kept;
}

}  // namespace thenar
