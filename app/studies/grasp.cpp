// SPDX-License-Identifier: Apache-2.0
#include "app/studies/grasp.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/exit_code.h"
#include "app/progress.h"
#include "app/results.h"
#include "engine/control/control_tick.h"
#include "engine/figures/gnuplot.h"
#include "engine/figures/grasp_picture.h"
#include "engine/finder/finder.h"
#include "engine/finder/grasp_measures.h"
#include "engine/formats/files.h"
#include "engine/formats/point_cloud_file.h"
#include "engine/formats/text.h"
#include "engine/grasp/contact_tick.h"
#include "engine/models/new_scene.h"
#include "engine/models/object_surface.h"
#include "engine/models/scene_environment.h"
#include "engine/models/scene_grasp.h"
#include "engine/models/surface_model.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/scene_text.h"
#include "engine/scenes/shared_data.h"
#include "engine/scenes/units.h"

namespace thenar::app {

namespace fs = std::filesystem;

namespace {

double value_or(const std::string& text, Dimension dimension, double otherwise) {
  return text.empty() ? otherwise : read_quantity(text, dimension).value;
}

/// The hand's file: that of --hand, or the one that a new scene has.
fs::path hand_file(const Options& options) {
  return find_hand(options.hand_file.empty() ? "hand" : options.hand_file.string());
}

bool is_scene(const Options& options) {
  const std::string ending = fs::path(options.subject).extension().string();
  return ending == ".yaml" || ending == ".yml" || (ending.empty() && !fs::exists(options.subject));
}

/// The object of the command line.
ObjectWish wish_of(const Options& options, const fs::path& object) {
  ObjectWish wish{.object = object, .hand = hand_file(options)};
  if (!options.unit.empty()) {
    wish.unit_m = read_unit(options.unit).value;
    if (!(wish.unit_m > 0.0)) {
      throw FileError(object, "--unit " + options.unit + " is not above 0: it is what 1 in the file measures");
    }
  }
  wish.mass_kg = value_or(options.mass, Dimension::kMass, wish.mass_kg);
  wish.friction = options.friction.value_or(wish.friction);
  if (!options.press.empty()) wish.press_N = value_or(options.press, Dimension::kForce, 0.0);
  return wish;
}

/// What the command is about: its scene, and the files that it is made of.
struct Subject {
  Scene scene;
  fs::path hand, object;  ///< As the working folder sees them.
};

Subject subject_of(const Options& options) {
  const bool has_scene = is_scene(options);
  if (!has_scene && !options.overrides.empty()) throw ConfigError({{"--set", "", "changes a scene, not an object"}});
  if (has_scene && !options.unit.empty())
    throw ConfigError({{"--unit", "", "is of an object's file: a scene has its own"}});
  if (!has_scene) return {scene_of_object(wish_of(options, options.subject)), hand_file(options), options.subject};
  std::vector<std::string> changes = options.overrides;
  if (!options.mass.empty()) changes.push_back("object.mass=" + options.mass);
  if (!options.hand_file.empty()) changes.push_back("hand.model=" + fs::absolute(hand_file(options)).string());
  const fs::path file = find_scene(options.subject);
  Scene scene = load_scene(file, changes);
  if (scene.hand.slides) throw ConfigError({{file.string(), "hand.slides", "are no hand to find a grasp for"}});
  if (!scene.grasp) {
    // What the scene places by the object stays where it is, unless the object stands upright whichever way it is held.
    if (!scene.gravity_in_object_frame) place_by_object(scene);
    scene.grasp = GraspWish{};
  }
  if (options.friction) {
    // The controller's cones follow.
    double& friction = scene.contact.friction;
    if (scene.control && friction > 0.0) scene.control->grasp_friction *= *options.friction / friction;
    friction = *options.friction;
  }
  if (!options.press.empty()) scene.grasp->press_N = value_or(options.press, Dimension::kForce, 0.0);
  const auto* const cloud = std::get_if<CloudShape>(&scene.object.shape);
  return {scene, scene_files(file, changes)[1], cloud != nullptr ? cloud->file : fs::path()};
}

/// The measures that share a column of the table.
using Column = std::vector<const GraspMeasure*>;

std::vector<Column> table_columns() {
  std::vector<Column> columns;
  for (const GraspMeasure& measure : grasp_measures()) {
    if (measure.shown.empty()) continue;
    if (columns.empty() || columns.back().front()->shown != measure.shown) columns.emplace_back();
    columns.back().push_back(&measure);
  }
  return columns;
}

int width_of(const Column& column) {
  const int least = column.size() > 1 ? 11 : 8;  // A shared column has units in its cells.
  return std::max(least, static_cast<int>(column.front()->shown.size()) + 2);
}

std::string cell_of(const Column& column, const FoundGrasp& grasp) {
  const auto has = std::ranges::find_if(column, [&](const GraspMeasure* measure) { return measure->is_of(grasp); });
  if (has == column.end()) return "";
  const std::string number = shown_number(**has, grasp);
  return column.size() > 1 ? fmt::format("{} {}", number, (*has)->shown_unit) : number;
}

std::string finger_names(const FoundGrasp& grasp, const Hand& hand) {
  std::string names;
  for (const int finger : grasp.fingers) names += (names.empty() ? "" : ", ") + hand.fingertips[finger].finger;
  return names;
}

/// A sentence for each measure.
std::string table_legend(const std::vector<Column>& columns) {
  std::string legend;
  for (const Column& column : columns) {
    for (const GraspMeasure* measure : column) {
      legend += fmt::format("{:<17}{}\n", measure == column.front() ? measure->shown : "", measure->sentence);
    }
  }
  return legend;
}

std::string grasps_table(const FinderReport& report, const Hand& hand) {
  const std::vector<Column> columns = table_columns();
  std::string names = fmt::format("{:>4}  {:<24}", "rank", "fingers"), units = fmt::format("{:>4}  {:<24}", "", "");
  for (const Column& column : columns) {
    names += fmt::format("{:>{}}", column.front()->shown, width_of(column));
    units += fmt::format("{:>{}}", column.size() > 1 ? "" : column.front()->shown_unit, width_of(column));
  }
  std::string table = names + '\n' + units + '\n';
  for (std::size_t i = 0; i < report.grasps.size(); ++i) {
    table += fmt::format("{:>4}  {:<24}", i + 1, finger_names(report.grasps[i], hand));
    for (const Column& column : columns) {
      table += fmt::format("{:>{}}", cell_of(column, report.grasps[i]), width_of(column));
    }
    table += '\n';
  }
  return table + '\n' + table_legend(columns);
}

/// The state after the first tick: with pressed pulps.
State pressed(const Model& model) {
  State state(model);
  Controller controller(model);
  Frame frame(model);
  ContactMemory memory(model);
  ContactScratch work(model);
  (void)control_tick(model, state, controller, frame);
  (void)contact_tick(model, frame, memory, work, state);
  return state;
}

/// One grasp as a scene that runs, and what it looks like at its start.
void write_grasp(const Subject& subject, const FoundGrasp& grasp, const ImplicitSurface& surface, const fs::path& file,
                 int rank) {
  Scene scene = subject.scene;
  take_grasp(grasp, scene);
  scene.name += fmt::format(", grasp {}", rank);
  Scene standing = scene;
  stand_object(standing, surface);
  const Model model = surface_model(standing, surface);
  Scene written = model.scene;
  written.environment = scene.environment;  // What is under the object is written as such.
  SceneTextNotes notes;
  notes.schema = schema_file();
  notes.hand = hand_in_scene(subject.hand, seen_from(file.parent_path(), subject.hand));
  notes.object = seen_from(file.parent_path(), subject.object);
  notes.about = fmt::format("A grasp that thenar found, number {} of its search.", rank);
  notes.grasp = "How it holds: " + in_words(grasp, subject.scene.hand);
  notes.names_fingers = model.scene.hand.fingers() < subject.scene.hand.fingers();
  write_file(file, scene_text(written, notes));
  fs::path picture = file;
  picture.replace_extension(".png");
  if (!draw_figure(grasp_picture_script(model, pressed(model)), picture)) {
    std::cerr << "warning: no picture, for gnuplot is missing or failed\n";
  }
}

}  // namespace

int grasp(const Options& options) {
  Subject subject = subject_of(options);
  const NewFolders unless_used(options.out);
  std::optional<FileLock> lock;
  if (!options.out.empty()) lock.emplace(claim_folder(options.out, "--out"));
  std::vector<std::string> notes;
  const ImplicitSurface surface = make_object_surface(subject.scene, notes);
  if (!is_scene(options))
    subject.scene.object.centre_of_mass_m = object_solid(subject.scene, surface, notes).centroid_m;
  print_object_notes(notes, options.quiet);
  SearchWatch watch(options.quiet);
  const GraspWish& wish = *subject.scene.grasp;
  const FinderReport report =
      find_tried_grasps(subject.scene, surface, {.seed = wish.seed, .best = options.best}, watch.progress());
  watch.end();
  if (report.grasps.empty()) {
    if (stop_is_asked()) return kInterrupted;
    std::cerr << "no grasp: " << in_words(report.refusal.value_or(Refusal{"none was found", ""})) << '\n';
    return kFailed;
  }
  if (!options.quiet) std::cout << grasps_table(report, subject.scene.hand);
  if (!options.quiet && !report.shortfall.empty()) {
    std::cout << fmt::format("\n{} of {}: {}\n", counted(std::ssize(report.grasps), "grasp"), options.best,
                             report.shortfall);
  }
  Attempts results;
  for (int i = 0; i < static_cast<int>(report.grasps.size()) && !options.out.empty(); ++i) {
    const fs::path file = options.out / fmt::format("grasp-{}.yaml", i + 1);
    results.attempt([&] { write_grasp(subject, report.grasps[i], surface, file, i + 1); });
  }
  if (!options.out.empty() && !options.quiet) {
    std::cout << fmt::format("\n{} in {}: thenar run {}\n", counted(std::ssize(report.grasps), "scene"),
                             printable(options.out.string()), printable((options.out / "grasp-1.yaml").string()));
  }
  results.finish();
  return stop_is_asked() ? kInterrupted : kDone;
}

int new_scene(const Options& options) {
  const fs::path file = options.scene;
  const NewScene made = write_new_scene(file, wish_of(options, options.object));
  print_object_notes(made.notes, options.quiet);
  const Eigen::Vector3d size_mm = 1e3 * made.size_m;
  if (!options.quiet) {
    std::cout << fmt::format("{}: an object of {:.1f} x {:.1f} x {:.1f} mm; now: thenar run {}\n",
                             printable(file.string()), size_mm.x(), size_mm.y(), size_mm.z(), printable(file.string()));
  }
  return kDone;
}

}  // namespace thenar::app
