// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/foxglove.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <utility>

namespace thenar::foxglove {

using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

// ---- Schemas.

Json type(const char* name) { return {{"type", name}}; }

/// Returns the schema of an object with these required members.
Json object(const char* title, std::initializer_list<std::pair<const char*, Json>> members) {
  Json properties = Json::object(), required = Json::array();
  for (const auto& [name, schema] : members) {
    properties[name] = schema;
    required.push_back(name);
  }
  return {{"title", title}, {"type", "object"}, {"properties", properties}, {"required", required}};
}

Json list_of(Json items) { return {{"type", "array"}, {"items", std::move(items)}}; }

/// Returns the schema of an enumeration of named numbers.
Json choice(const char* title, std::initializer_list<std::pair<const char*, int>> names) {
  Json alternatives = Json::array();
  for (const auto& [name, number] : names) alternatives.push_back({{"title", name}, {"const", number}});
  return {{"title", title}, {"oneOf", alternatives}};
}

/// Returns the schema of "time", whose seconds count from 0, or "duration".
Json time_schema(const char* title) {
  Json sec = type("integer");
  if (std::string_view(title) == "time") sec["minimum"] = 0;
  const Json nsec = {{"type", "integer"}, {"minimum", 0}, {"maximum", 999999999}};
  return {{"type", "object"}, {"title", title}, {"properties", {{"sec", sec}, {"nsec", nsec}}}};
}

Json numbers(const char* title, std::initializer_list<const char*> names) {
  Json schema = object(title, {});
  for (const char* name : names) {
    schema["properties"][name] = type("number");
    schema["required"].push_back(name);
  }
  return schema;
}

Json vector_schema() { return numbers("foxglove.Vector3", {"x", "y", "z"}); }
Json points_schema() { return list_of(numbers("foxglove.Point3", {"x", "y", "z"})); }
Json quaternion_schema() { return numbers("foxglove.Quaternion", {"x", "y", "z", "w"}); }
Json color_schema() { return numbers("foxglove.Color", {"r", "g", "b", "a"}); }
Json pose_schema() {
  return object("foxglove.Pose", {{"position", vector_schema()}, {"orientation", quaternion_schema()}});
}
Json indices_schema() { return list_of({{"type", "integer"}, {"minimum", 0}}); }

Json line_schema() {
  return object("foxglove.LinePrimitive",
                {{"type", choice("foxglove.LineType", {{"LINE_STRIP", 0}, {"LINE_LOOP", 1}, {"LINE_LIST", 2}})},
                 {"pose", pose_schema()},
                 {"thickness", type("number")},
                 {"scale_invariant", type("boolean")},
                 {"points", points_schema()},
                 {"color", color_schema()},
                 {"colors", list_of(color_schema())},
                 {"indices", indices_schema()}});
}

Json text_schema() {
  return object("foxglove.TextPrimitive", {{"pose", pose_schema()},
                                           {"billboard", type("boolean")},
                                           {"font_size", type("number")},
                                           {"scale_invariant", type("boolean")},
                                           {"color", color_schema()},
                                           {"text", type("string")}});
}

Json model_schema() {
  return object("foxglove.ModelPrimitive", {{"pose", pose_schema()},
                                            {"scale", vector_schema()},
                                            {"color", color_schema()},
                                            {"override_color", type("boolean")},
                                            {"url", type("string")},
                                            {"media_type", type("string")},
                                            {"data", {{"type", "string"}, {"contentEncoding", "base64"}}}});
}

Json entity_schema() {
  const auto solid = [](const char* title) {
    return object(title, {{"pose", pose_schema()}, {"size", vector_schema()}, {"color", color_schema()}});
  };
  return object(
      "foxglove.SceneEntity",
      {{"timestamp", time_schema("time")},
       {"frame_id", type("string")},
       {"id", type("string")},
       {"lifetime", time_schema("duration")},
       {"frame_locked", type("boolean")},
       {"metadata", list_of(object("foxglove.KeyValuePair", {{"key", type("string")}, {"value", type("string")}}))},
       {"arrows", list_of(object("foxglove.ArrowPrimitive", {{"pose", pose_schema()},
                                                             {"shaft_length", type("number")},
                                                             {"shaft_diameter", type("number")},
                                                             {"head_length", type("number")},
                                                             {"head_diameter", type("number")},
                                                             {"color", color_schema()}}))},
       {"cubes", list_of(solid("foxglove.CubePrimitive"))},
       {"spheres", list_of(solid("foxglove.SpherePrimitive"))},
       {"cylinders", list_of(object("foxglove.CylinderPrimitive", {{"pose", pose_schema()},
                                                                   {"size", vector_schema()},
                                                                   {"bottom_scale", type("number")},
                                                                   {"top_scale", type("number")},
                                                                   {"color", color_schema()}}))},
       {"lines", list_of(line_schema())},
       {"triangles", list_of(object("foxglove.TriangleListPrimitive", {{"pose", pose_schema()},
                                                                       {"points", points_schema()},
                                                                       {"color", color_schema()},
                                                                       {"colors", list_of(color_schema())},
                                                                       {"indices", indices_schema()}}))},
       {"texts", list_of(text_schema())},
       {"models", list_of(model_schema())}});
}

// ---- Messages.

/// Rounds to a tenth of a micrometre, or as much of a unit vector: sufficient for display, in short numbers.
double rounded(double number) { return std::round(1e7 * number) / 1e7; }

Json time(double time_s) {
  const auto time_ns = static_cast<std::int64_t>(std::llround(1e9 * std::max(0.0, time_s)));
  return {{"sec", time_ns / 1'000'000'000}, {"nsec", time_ns % 1'000'000'000}};
}

Json vector(const Vector3d& v) { return {{"x", rounded(v.x())}, {"y", rounded(v.y())}, {"z", rounded(v.z())}}; }

Json quaternion(const Quaterniond& q) {
  return {{"x", rounded(q.x())}, {"y", rounded(q.y())}, {"z", rounded(q.z())}, {"w", rounded(q.w())}};
}

Json pose_json(const Vector3d& position, const Quaterniond& turn) {
  return {{"position", vector(position)}, {"orientation", quaternion(turn)}};
}

Json pose_json(const Isometry3d& pose) { return pose_json(pose.translation(), Quaterniond(pose.linear())); }

Json color_json(const Color& c) {
  return {{"r", rounded(c[0])}, {"g", rounded(c[1])}, {"b", rounded(c[2])}, {"a", rounded(c[3])}};
}

Json cylinder(const Json& pose, double radius_m, double length_m, const Color& color) {
  return {{"pose", pose},
          {"size", vector({2.0 * radius_m, 2.0 * radius_m, length_m})},
          {"bottom_scale", 1.0},
          {"top_scale", 1.0},
          {"color", color_json(color)}};
}

}  // namespace

Json scene_update_schema() {
  const Json deletion = object("foxglove.SceneEntityDeletion",
                               {{"timestamp", time_schema("time")},
                                {"type", choice("foxglove.SceneEntityDeletionType", {{"MATCHING_ID", 0}, {"ALL", 1}})},
                                {"id", type("string")}});
  return object("foxglove.SceneUpdate", {{"deletions", list_of(deletion)}, {"entities", list_of(entity_schema())}});
}

Json frame_transforms_schema() {
  const Json transform = object("foxglove.FrameTransform", {{"timestamp", time_schema("time")},
                                                            {"parent_frame_id", type("string")},
                                                            {"child_frame_id", type("string")},
                                                            {"translation", vector_schema()},
                                                            {"rotation", quaternion_schema()}});
  return object("foxglove.FrameTransforms", {{"transforms", list_of(transform)}});
}

Json log_schema() {
  const Json level = choice("foxglove.LogLevel",
                            {{"UNKNOWN", 0}, {"DEBUG", 1}, {"INFO", 2}, {"WARNING", 3}, {"ERROR", 4}, {"FATAL", 5}});
  return object("foxglove.Log", {{"timestamp", time_schema("time")},
                                 {"level", level},
                                 {"message", type("string")},
                                 {"name", type("string")},
                                 {"file", type("string")},
                                 {"line", {{"type", "integer"}, {"minimum", 0}}}});
}

Json entity(const std::string& id, const std::string& frame, double time_s, bool moves) {
  Json json = {
      {"timestamp", time(time_s)}, {"frame_id", frame}, {"id", id}, {"lifetime", time(0.0)}, {"frame_locked", moves}};
  for (const char* list :
       {"metadata", "arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models"}) {
    json[list] = Json::array();
  }
  return json;
}

Json arrow(const Vector3d& tail, const Vector3d& tip, double thickness_m, const Color& color) {
  const double length_m = (tip - tail).norm(), head_m = std::min(3.0 * thickness_m, 0.5 * length_m);
  return {{"pose", pose_json(tail, Quaterniond::FromTwoVectors(Vector3d::UnitX(), tip - tail))},
          {"shaft_length", rounded(length_m - head_m)},
          {"shaft_diameter", rounded(thickness_m)},
          {"head_length", rounded(head_m)},
          {"head_diameter", rounded(2.0 * thickness_m)},
          {"color", color_json(color)}};
}

Json sphere(const Isometry3d& pose, const Vector3d& half_m, const Color& color) {
  return {{"pose", pose_json(pose)}, {"size", vector(2.0 * half_m)}, {"color", color_json(color)}};
}

Json cylinder(const Isometry3d& pose, double radius_m, double length_m, const Color& color) {
  return cylinder(pose_json(pose), radius_m, length_m, color);
}

Json rod(const Vector3d& from, const Vector3d& to, double radius_m, const Color& color) {
  const Quaterniond turn = Quaterniond::FromTwoVectors(Vector3d::UnitZ(), to - from);
  return cylinder(pose_json(0.5 * (from + to), turn), radius_m, (to - from).norm(), color);
}

Json triangles(const Eigen::Matrix3Xd& points_m, const std::vector<int>& indices, const Color& color) {
  Json points = Json::array();
  for (const auto& point : points_m.colwise()) points.push_back(vector(point));
  return {{"pose", pose_json(Isometry3d::Identity())},
          {"points", points},
          {"color", color_json(color)},
          {"colors", Json::array()},
          {"indices", indices}};
}

Json scene_update(std::vector<Json> entities, double time_s, bool instead) {
  constexpr int kAll = 1;
  Json deletions = Json::array();
  if (instead) deletions.push_back({{"timestamp", time(time_s)}, {"type", kAll}, {"id", ""}});
  return {{"deletions", deletions}, {"entities", std::move(entities)}};
}

Json transform(const std::string& parent, const std::string& child, const Isometry3d& pose, double time_s) {
  return {{"timestamp", time(time_s)},
          {"parent_frame_id", parent},
          {"child_frame_id", child},
          {"translation", vector(pose.translation())},
          {"rotation", quaternion(Quaterniond(pose.linear()))}};
}

Json log(LogLevel level, const std::string& text, double time_s) {
  return {{"timestamp", time(time_s)},
          {"level", static_cast<int>(level)},
          {"message", text},
          {"name", "thenar"},
          {"file", ""},
          {"line", 0}};
}

}  // namespace thenar::foxglove
