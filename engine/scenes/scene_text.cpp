#include "engine/scenes/scene_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <list>
#include <utility>
#include <vector>

#include "engine/finder/effort.h"
#include "engine/formats/text.h"
#include "engine/scenes/describe.h"
#include "engine/scenes/units.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

/// Words as comment lines of at most 120 columns.
std::string comment(const std::string& words) {
  std::string result, line = "#";
  std::size_t at = 0;
  while (at < words.size()) {
    const std::size_t end = std::min(words.find(' ', at), words.size());
    if (line.size() + 1 + end - at > 118) {
      result += line + "\n";
      line = "#";
    }
    line += " " + words.substr(at, end - at);
    at = end + 1;
  }
  return words.empty() ? "" : result + line + "\n";
}

/// Makes a file of a description. Maps below the first level are written in a line where that is short.
class SceneWriter final : public Visitor {
 public:
  /// The hand is that of the scene, which tells the joints of each finger.
  explicit SceneWriter(const Hand& hand) : hand_(hand), open_{&root_} {}

  [[nodiscard]] std::string text() const {
    std::string out;
    for (const Node& node : root_.below) out += comment(std::string(node.heading)) + block(node, "");
    return out;
  }

  void per_joint(const KeyRow& row, Eigen::VectorXd& values, Eigen::Index) override {
    Node& node = add(row);
    for (const Fingertip& tip : hand_.fingertips) {
      const std::string of_finger =
          to_text(Eigen::VectorXd(values.segment(tip.first_joint, tip.joints)), row.dimension);
      node.rows.push_back({of_finger.substr(1, of_finger.size() - 2), tip.finger});
    }
  }
  std::string word(const KeyRow& row, std::string_view now) override {
    if (!now.empty()) add(row).text = now;
    return std::string(now);
  }
  bool chooses(std::string_view, bool now) override { return now; }
  bool is_there(std::string_view, bool now) override { return now; }

 private:
  struct Row {
    std::string text, note = {};
  };
  struct Node {
    enum Kind { kValue, kMap, kList };
    Kind kind = kValue;
    std::string_view key, heading;
    std::string text = {};
    std::vector<Row> rows = {};  ///< Of a list of numbers that is written in several lines.
    std::list<Node> below = {};
  };

  void number(const KeyRow& row, double& value) override { add_value(row, to_text(value, row.dimension)); }
  void numbers(const KeyRow& row, Eigen::Ref<Eigen::VectorXd> values) override {
    add_value(row, to_text(Eigen::VectorXd(values), row.dimension));
  }
  void count(const KeyRow& row, Eigen::Index& value) override { add_value(row, std::to_string(value)); }
  void rotation(const KeyRow& row, Eigen::Matrix3d& value) override {
    Node& node = add(row);
    for (int i = 0; i < 3; ++i) node.rows.push_back({to_text(Eigen::VectorXd(value.row(i)), row.dimension)});
  }
  void flag(const KeyRow& row, bool& value) override { add_value(row, value ? "true" : "false"); }
  void text(const KeyRow& row, std::string& value) override {
    Node& node = add(row);
    node.text = thenar::quoted(value);
    node.heading = "";
  }
  void texts(const KeyRow& row, std::vector<std::string>& value) override {
    std::vector<std::string> items;
    for (const std::string& item : value) items.push_back(quoted(item));
    add_value(row, fmt::format("[{}]", fmt::join(items, ", ")));
  }
  void path(const KeyRow& row, std::filesystem::path& value) override { add_value(row, quoted(value.string())); }
  std::string choice_of(const KeyRow& row, std::string_view now) override {
    add_value(row, std::string(now));
    return std::string(now);
  }
  void enter(const KeyRow& row, KeyKind) override {
    Node& node = add(row);
    node.kind = Node::kMap;
    open_.push_back(&node);
  }
  bool enters_map(const KeyRow& row, std::filesystem::path&) override {
    enter(row, KeyKind::kMap);
    return true;
  }
  std::size_t begin_list(const KeyRow& row, std::size_t now) override {
    Node& node = add(row);
    node.kind = Node::kList;
    open_.push_back(&node);
    return now;
  }
  void begin_item(const KeyRow&, std::size_t) override {
    open_.push_back(&open_.back()->below.emplace_back(Node{.kind = Node::kMap, .key = "", .heading = ""}));
  }
  /// A map of which nothing is to be said is left out.
  void leave() override {
    open_.pop_back();
    std::list<Node>& beside = open_.back()->below;
    if (open_.back()->kind == Node::kMap && beside.back().below.empty()) beside.pop_back();
  }
  void end_list() override { leave(); }

  Node& add(const KeyRow& row) {
    return open_.back()->below.emplace_back(Node{.key = row.name, .heading = row.sentence});
  }
  /// A value that a file has without naming it is left out.
  void add_value(const KeyRow& row, std::string text) {
    if (text != row.without) add(row).text = std::move(text);
  }

  static bool is_short(const Node& node) {
    return node.rows.empty() && node.kind != Node::kList && std::ranges::all_of(node.below, is_short);
  }
  static std::string line(const Node& node) {
    if (node.kind == Node::kValue) return node.text;
    std::vector<std::string> entries;
    for (const Node& one : node.below) entries.push_back(fmt::format("{}: {}", one.key, line(one)));
    return fmt::format("{{{}}}", fmt::join(entries, ", "));
  }
  static std::string rows(const Node& node, std::size_t indent) {
    std::string text = "[";
    for (const Row& row : node.rows) {
      const bool is_last = &row == &node.rows.back();
      if (&row != &node.rows.front()) text += std::string(indent + 1, ' ');
      text += row.text + (is_last ? "]" : ",") + (row.note.empty() ? "" : "  # " + row.note) + (is_last ? "" : "\n");
    }
    return text;
  }
  /// The node in lines of its own, each of which begins with `indent`.
  static std::string block(const Node& node, const std::string& indent) {
    constexpr std::size_t kColumns = 118;
    const std::string key = fmt::format("{}{}:", indent, node.key);
    if (!node.rows.empty()) return key + " " + rows(node, key.size() + 1) + "\n";
    const bool is_in_line = node.kind == Node::kValue || (is_short(node) && !indent.empty());
    if (is_in_line && (node.kind == Node::kValue || key.size() + line(node).size() < kColumns)) {
      return key + " " + line(node) + "\n";
    }
    std::string text = key + "\n";
    for (const Node& one : node.below) text += node.kind == Node::kList ? item(one, indent) : block(one, indent + "  ");
    return text;
  }
  static std::string item(const Node& node, const std::string& indent) {
    if (is_short(node)) return fmt::format("{}  - {}\n", indent, line(node));
    std::string text;
    for (const Node& one : node.below) text += block(one, indent + "    ");
    return text.replace(indent.size() + 2, 1, "-");
  }

  const Hand& hand_;
  Node root_{.kind = Node::kMap, .key = "", .heading = ""};
  std::vector<Node*> open_;
};

}  // namespace

std::string scene_text(const Scene& scene, const SceneTextNotes& notes) {
  SceneFile file;
  file.scene = scene;
  file.hand = notes.hand;
  if (notes.names_fingers) {
    for (const Fingertip& tip : scene.hand.fingertips) file.fingers.push_back(tip.finger);
  }
  if (auto* cloud = std::get_if<CloudShape>(&file.scene.object.shape)) cloud->file = notes.object;
  SceneWriter writer(scene.hand);
  describe(writer, file);
  const std::string schema =
      notes.schema.empty() ? "" : "# yaml-language-server: $schema=" + notes.schema.string() + "\n";
  return schema + comment(notes.about) + comment(notes.grasp) + writer.text();
}

Scene scene_to_begin_with(const Hand& hand, const CloudShape& object, double mass_kg, double friction) {
  Scene scene;
  scene.name = object.file.stem().string();
  scene.duration_s = 2.0;
  scene.step_s = scene.control_period_s = 1e-3;
  scene.gravity = {7.01862, 5.581331, 3.977916};  // the palm looks up and to the side, as in the published experiment
  scene.hand = hand;
  scene.posture = hand.at_zero();
  scene.joint_viscosity = 0.05;
  scene.grasp = GraspWish{};
  scene.fingertips = FingertipSettings{2400, 320, {0.24e6, 0.5, 2e-3}};
  scene.object.shape = object;
  scene.object.points = 20000;
  scene.object.mass_kg = mass_kg;
  scene.object.translation_damping = 10.0;
  scene.object.rotation_damping = 0.005;
  scene.contact = {.friction = friction, .band_m = 0.3e-3, .max_per_finger = 30, .tolerance = 1e-7, .max_sweeps = 200};
  ControlSettings control;
  control.pulp_normal_N_per_m = 2000.0;
  control.pulp_tangential_N_per_m = 1330.0;
  control.grasp_friction = 0.7 * friction;
  // What carries the weight, and the push by which grasps are tried, by friction on both sides, and as much again.
  const double needed_N = (mass_kg * 9.81 + kPush_N) / std::max(friction, 0.1);
  control.internal_force_N = std::max(1.0, std::ceil(10.0 * needed_N) / 10.0);
  control.position = {300.0, 900.0, 0.0};
  control.rotation = {0.48, 1.5, 0.0};
  control.posture_Nm_per_rad = 0.5;
  if (!hand.muscles.empty()) control.muscles.emplace();
  scene.control = control;
  return scene;
}

Vector3d enclosed_centroid_m(const PointCloud& cloud) {
  // By Gauss: V = 1/3 sum x.n A, V c_i = 1/2 sum x_i^2 n_i A, about the middle of the box; all A are alike.
  const Vector3d low = cloud.points_m.rowwise().minCoeff(), high = cloud.points_m.rowwise().maxCoeff();
  const Vector3d middle = 0.5 * (low + high);
  const Eigen::Matrix3Xd x = cloud.points_m.colwise() - middle;
  const double volume = x.cwiseProduct(cloud.normals).sum() / 3.0;
  const Vector3d moment = 0.5 * x.cwiseAbs2().cwiseProduct(cloud.normals).rowwise().sum();
  if (!(volume > 0.0)) return middle;
  const Vector3d off = moment / volume;
  return (off.array().abs() < 0.5 * (high - low).array()).all() ? Vector3d(middle + off) : middle;
}

}  // namespace thenar
