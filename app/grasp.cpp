#include "app/grasp.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "app/exit_code.h"
#include "app/progress.h"
#include "app/results.h"
#include "app/shared_data.h"
#include "engine/finder/finder.h"
#include "engine/formats/files.h"
#include "engine/formats/point_cloud_file.h"
#include "engine/grasp/contact_tick.h"
#include "engine/grasp/control_tick.h"
#include "engine/results/gnuplot.h"
#include "engine/results/grasp_picture.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/object_surface.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/scene_grasp.h"
#include "engine/scenes/scene_text.h"
#include "engine/scenes/surface_model.h"
#include "engine/scenes/units.h"

namespace {

using namespace thenar;
namespace fs = std::filesystem;

constexpr double kMass_kg = 0.1, kFriction = 0.6;

double value_or(const std::string& text, Dimension dimension, double otherwise) {
  return text.empty() ? otherwise : read_quantity(text, dimension).value;
}

/// What the files of a scene are, as the folder that it will stand in sees them.
struct SceneFiles {
  fs::path hand, object;
};
fs::path seen_from(const fs::path& folder, const fs::path& file) {
  if (file.empty()) return file;
  std::error_code none;
  const fs::path relative = fs::proximate(fs::absolute(file), fs::absolute(folder.empty() ? "." : folder), none);
  return relative.empty() ? fs::absolute(file) : relative;
}

/// The hand's file: the one that is named, beside the working folder or among those that come with the program.
fs::path hand_file(const fs::path& asked) {
  const fs::path hand = asked.empty() ? fs::path("hand.yaml") : asked;
  if (is_readable(hand)) return hand;
  if (const fs::path known = known_hand(hand); !known.empty()) return known;
  throw FileError(hand, "cannot be read, nor does a hand of this name come with the program");
}

/// A scene's file says which hand by name where it comes with the program.
fs::path hand_in_scene(const Options& options, const fs::path& folder) {
  if (options.hand_file.empty()) return "hand.yaml";
  return is_readable(options.hand_file) ? seen_from(folder, options.hand_file) : options.hand_file;
}

bool is_scene(const Options& options) {
  const std::string ending = fs::path(options.subject).extension().string();
  return ending == ".yaml" || ending == ".yml" || (ending.empty() && !fs::exists(options.subject));
}

/// A scene for an object's file, with the centre of its mass where a solid of its surface has it.
Scene scene_of_object(const Options& options, const fs::path& object) {
  if (!is_readable(object)) throw FileError(object, "cannot be read");
  const double unit_m =
      options.unit.empty()
          ? 1.0
          : read_quantity((std::isdigit(options.unit.front()) ? "" : "1 ") + options.unit, Dimension::kLength).value;
  Scene scene =
      scene_to_begin_with(load_hand(hand_file(options.hand_file)), {object, unit_m},
                          value_or(options.mass, Dimension::kMass, kMass_kg), options.friction.value_or(kFriction));
  if (!is_mesh_file(object)) scene.object.points = 0;
  if (!options.press.empty()) scene.grasp->press_N = value_or(options.press, Dimension::kForce, 0.0);
  return scene;
}

/// What the command is about: its scene, and the files that it is made of.
struct Subject {
  Scene scene;
  fs::path hand, object;  ///< As the working folder sees them.
};

Subject subject_of(const Options& options) {
  if (!is_scene(options)) return {scene_of_object(options, options.subject), options.hand_file, options.subject};
  std::vector<std::string> changes = options.overrides;
  if (!options.mass.empty()) changes.push_back("object.mass=" + options.mass);
  if (!options.hand_file.empty()) {
    const fs::path hand = is_readable(options.hand_file) ? fs::absolute(options.hand_file) : options.hand_file;
    changes.push_back("hand.model=" + hand.string());
  }
  const fs::path file = find_scene(options.subject);
  Scene scene = load_scene(file, changes);
  if (!scene.grasp) scene.grasp = GraspWish{};
  if (options.friction) {
    // The controller's cones follow.
    double& friction = scene.contact.friction;
    if (scene.control && friction > 0.0) scene.control->grasp_friction *= *options.friction / friction;
    friction = *options.friction;
  }
  if (!options.press.empty()) scene.grasp->press_N = value_or(options.press, Dimension::kForce, 0.0);
  const std::vector<fs::path> files = scene_files(file, changes);
  return {scene, files.size() > 1 ? files[1] : fs::path(), files.size() > 2 ? files[2] : fs::path()};
}

std::string grasps_table(const FinderReport& report, const Hand& hand) {
  std::string table =
      fmt::format("{:>4}  {:<24}{:>8}{:>8}{:>8}{:>10}{:>8}{:>9}{:>8}{:>9}{:>9}{:>9}\n", "rank", "fingers", "width",
                  "press", "margin", "friction", "limit", "effort", "patch", "epsilon", "volume", "isotropy");
  table +=
      fmt::format("{:>4}  {:<24}{:>8}{:>8}{:>8}{:>10}{:>8}{:>9}\n", "", "", "mm", "N", "", "needed", "deg", "% or N m");
  for (std::size_t i = 0; i < report.grasps.size(); ++i) {
    const FoundGrasp& grasp = report.grasps[i];
    std::string fingers;
    double press_N = 1e9, patch = 1.0;
    for (std::size_t k = 0; k < grasp.fingers.size(); ++k) {
      const FingerPlace& place = grasp.places[k];
      fingers += (k > 0 ? ", " : "") + hand.fingertips[grasp.fingers[k]].finger;
      press_N = std::min(press_N, -(grasp.X_WO.linear() * place.normal_O).dot(place.force_W));
      patch = std::min(patch, place.patch);
    }
    const std::string effort = grasp.muscle_share > 0.0 ? fmt::format("{:.0f} %", 100.0 * grasp.muscle_share)
                                                        : fmt::format("{:.3f}", grasp.torque_Nm);
    table += fmt::format(
        "{:>4}  {:<24}{:>8.1f}{:>8.2f}{:>8.2f}{:>10.2f}{:>8.0f}{:>9}{:>8.2f}{:>9.3f}{:>9.1e}{:>9.2f}\n", i + 1, fingers,
        1e3 * grasp.width_m, press_N, grasp.margin, grasp.needed_friction, grasp.limit_rad * 180.0 / std::numbers::pi,
        effort, patch, grasp.quality.epsilon, grasp.quality.volume, grasp.quality.isotropy);
  }
  return table;
}

/// The state after the first tick: with pressed pulps.
State pressed(const Model& model) {
  State state(model);
  Controller controller(model);
  Frame frame(model);
  ContactWorkspace work(model);
  (void)control_tick(model, state, controller, frame);
  (void)contact_tick(model, frame, work, state);
  return state;
}

/// One grasp as a scene that runs, and what it looks like at its start.
void write_grasp(const Subject& subject, const FoundGrasp& grasp, const ImplicitSurface& surface, const fs::path& file,
                 int rank) {
  Scene scene = subject.scene;
  const Hand hand = scene.hand;
  take_grasp(grasp, scene);
  scene.name += fmt::format(", grasp {}", rank);
  const Model model = surface_model(scene, surface);
  SceneTextNotes notes;
  notes.hand = subject.hand.empty() ? fs::path("hand.yaml") : seen_from(file.parent_path(), subject.hand);
  notes.object = seen_from(file.parent_path(), subject.object);
  notes.about = fmt::format("A grasp that thenar found, number {} of its search.", rank);
  notes.grasp = "How it holds: " + in_words(grasp, hand);
  notes.names_fingers = model.scene.hand.fingers() < hand.fingers();
  write_file(file, scene_text(model.scene, notes));
  fs::path picture = file;
  picture.replace_extension(".png");
  if (!draw_figure(grasp_picture_script(model, pressed(model)), picture)) {
    std::cerr << "warning: no picture, for gnuplot is missing or failed\n";
  }
}

}  // namespace

int grasp(const Options& options) {
  Subject subject = subject_of(options);
  std::optional<FileLock> lock;
  if (!options.out.empty()) lock.emplace(claim_folder(options.out, "--out"));
  std::vector<std::string> notes;
  const ImplicitSurface surface = make_object_surface(subject.scene, notes);
  if (!is_scene(options)) subject.scene.object.centre_of_mass_m = enclosed_centroid_m(surface.cloud());
  if (!options.quiet) {
    for (const std::string& note : notes) std::cout << "object: " << note << '\n';
  }
  SearchWatch watch(options.quiet);
  const GraspWish& wish = *subject.scene.grasp;
  const FinderReport report =
      find_tried_grasps(subject.scene, surface, {.seed = wish.seed, .best = options.best}, watch.progress());
  watch.end();
  if (report.grasps.empty()) {
    if (watch.interrupted()) return kInterrupted;
    std::cerr << "no grasp: " << in_words(report.refusal.value_or(Refusal{"none was found", ""})) << '\n';
    return kFailed;
  }
  if (!options.quiet) std::cout << grasps_table(report, subject.scene.hand);
  Attempts results;
  for (int i = 0; i < static_cast<int>(report.grasps.size()) && !options.out.empty(); ++i) {
    const fs::path file = options.out / fmt::format("grasp-{}.yaml", i + 1);
    results.attempt([&] { write_grasp(subject, report.grasps[i], surface, file, i + 1); });
  }
  if (!options.out.empty() && !options.quiet) {
    std::cout << fmt::format("\n{} scenes in {}: thenar run {}\n", report.grasps.size(), options.out.string(),
                             (options.out / "grasp-1.yaml").string());
  }
  results.finish();
  return watch.interrupted() ? kInterrupted : kDone;
}

int new_scene(const Options& options) {
  const fs::path file = options.scene;
  if (fs::exists(file)) throw FileError(file, "is there already, and is not replaced");
  Scene scene = scene_of_object(options, options.object);
  std::vector<std::string> found;
  const ImplicitSurface surface = make_object_surface(scene, found);
  scene.object.centre_of_mass_m = enclosed_centroid_m(surface.cloud());
  SceneTextNotes notes;
  notes.hand = hand_in_scene(options, file.parent_path());
  notes.object = seen_from(file.parent_path(), options.object);
  notes.about = fmt::format(
      "{}, held by a hand: written by thenar new. thenar check says what is modelled, thenar run "
      "runs it, thenar keys lists all that a scene may say.",
      scene.name);
  const Eigen::Vector3d size_mm = 1e3 * surface.bounds().sizes();
  notes.grasp = fmt::format(
      "The object measures {:.1f} x {:.1f} x {:.1f} mm. If that is not so, change "
      "object.shape.cloud.unit: what 1 in the file measures.",
      size_mm.x(), size_mm.y(), size_mm.z());
  write_file(file, scene_text(scene, notes));
  if (!options.quiet) {
    std::cout << fmt::format("{}: an object of {:.1f} x {:.1f} x {:.1f} mm; now: thenar run {}\n", file.string(),
                             size_mm.x(), size_mm.y(), size_mm.z(), file.string());
  }
  return kDone;
}
