#include "app/grasp.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/exit_code.h"
#include "app/progress.h"
#include "app/results.h"
#include "engine/scenes/shared_data.h"
#include "engine/finder/finder.h"
#include "engine/formats/files.h"
#include "engine/formats/point_cloud_file.h"
#include "engine/formats/text.h"
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

fs::path seen_from(const fs::path& folder, const fs::path& file) {
  if (file.empty()) return file;
  std::error_code none;
  const fs::path relative = fs::proximate(fs::absolute(file), fs::absolute(folder.empty() ? "." : folder), none);
  return relative.empty() ? fs::absolute(file) : relative;
}

/// The hand's file: that of --hand, or the one that a new scene has.
fs::path hand_file(const Options& options) {
  return find_hand(options.hand_file.empty() ? "hand" : options.hand_file.string());
}

/// The schema that comes with the program; empty where it is missing, or where editors could not read its name.
fs::path schema_file() {
  const fs::path file = shared_data() / "docs" / "reference" / "scene.schema.json";
  std::error_code none;
  return fs::exists(file, none) && file.string().find(' ') == std::string::npos ? file : fs::path();
}

bool is_scene(const Options& options) {
  const std::string ending = fs::path(options.subject).extension().string();
  return ending == ".yaml" || ending == ".yml" || (ending.empty() && !fs::exists(options.subject));
}

/// Throws FileError where there is no such file, and names the surface in its folder whose name is nearest.
void expect_object(const fs::path& object) {
  std::error_code none;
  if (fs::exists(object, none)) return;
  const fs::path folder = object.parent_path();
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.empty() ? "." : folder, none)) {
    if (is_surface_file(entry.path())) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  const std::vector<std::string_view> candidates(names.begin(), names.end());
  const std::string_view nearest = nearest_word(object.filename().string(), candidates);
  throw FileError(object, "no such file" + did_you_mean(nearest.empty() ? "" : (folder / nearest).string()));
}

/// A scene for an object's file, whose centre of mass is still to be found.
Scene scene_of_object(const Options& options, const fs::path& object) {
  expect_object(object);
  const double unit_m =
      options.unit.empty()
          ? 1.0
          : read_quantity((std::isdigit(options.unit.front()) ? "" : "1 ") + options.unit, Dimension::kLength).value;
  Scene scene =
      scene_to_begin_with(load_hand(hand_file(options)), {object, unit_m},
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
  const bool has_scene = is_scene(options);
  if (!has_scene && !options.overrides.empty()) throw ConfigError({{"--set", "", "changes a scene, not an object"}});
  if (has_scene && !options.unit.empty())
    throw ConfigError({{"--unit", "", "is of an object's file: a scene has its own"}});
  if (!has_scene) return {scene_of_object(options, options.subject), hand_file(options), options.subject};
  std::vector<std::string> changes = options.overrides;
  if (!options.mass.empty()) changes.push_back("object.mass=" + options.mass);
  if (!options.hand_file.empty()) changes.push_back("hand.model=" + fs::absolute(hand_file(options)).string());
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
  return {scene, files[1], files.size() > 2 ? files[2] : fs::path()};
}

constexpr const char* kColumns = R"(
width    from the finger that faces the others to the middle of theirs
press    normal load of the least loaded finger
margin   least share of a friction cone that is left: of all fingers, with the weight in any direction, a push of
         0.5 N and a turn of 10 mN m
friction needed while the weight is as it is
limit    to the nearest end of a joint's range
effort   of a muscle, the largest share of what it can give; without muscles, the largest torque of a joint
patch    least share of a pressed pulp's patch that lies on the surface: less than 1 at edges and holes
epsilon, volume, isotropy   the quality measures of these names, for normal forces of 1 N in all
)";

std::string grasps_table(const FinderReport& report, const Hand& hand) {
  std::string table =
      fmt::format("{:>4}  {:<24}{:>8}{:>8}{:>8}{:>10}{:>8}{:>11}{:>8}{:>9}{:>9}{:>10}\n", "rank", "fingers", "width",
                  "press", "margin", "friction", "limit", "effort", "patch", "epsilon", "volume", "isotropy");
  table += fmt::format("{:>4}  {:<24}{:>8}{:>8}{:>8}{:>10}{:>8}\n", "", "", "mm", "N", "", "needed", "deg");
  for (std::size_t i = 0; i < report.grasps.size(); ++i) {
    const FoundGrasp& grasp = report.grasps[i];
    std::string fingers;
    for (std::size_t k = 0; k < grasp.fingers.size(); ++k) {
      fingers += (k > 0 ? ", " : "") + hand.fingertips[grasp.fingers[k]].finger;
    }
    const std::string effort = grasp.muscle_share > 0.0 ? fmt::format("{:.0f} %", 100.0 * grasp.muscle_share)
                                                        : fmt::format("{:.3f} N m", grasp.torque_Nm);
    table +=
        fmt::format("{:>4}  {:<24}{:>8.1f}{:>8.2f}{:>8.2f}{:>10.2f}{:>8.0f}{:>11}{:>8.2f}{:>9.3f}{:>9.1e}{:>10.2f}\n",
                    i + 1, fingers, 1e3 * grasp.width_m, least_press_N(grasp), grasp.margin, grasp.needed_friction,
                    grasp.limit_rad * 180.0 / std::numbers::pi, effort, least_patch(grasp), grasp.quality.epsilon,
                    grasp.quality.volume, grasp.quality.isotropy);
  }
  return table + kColumns;
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
  take_grasp(grasp, scene);
  scene.name += fmt::format(", grasp {}", rank);
  const Model model = surface_model(scene, surface);
  SceneTextNotes notes;
  notes.schema = schema_file();
  notes.hand = hand_in_scene(subject.hand, seen_from(file.parent_path(), subject.hand));
  notes.object = seen_from(file.parent_path(), subject.object);
  notes.about = fmt::format("A grasp that thenar found, number {} of its search.", rank);
  notes.grasp = "How it holds: " + in_words(grasp, subject.scene.hand);
  notes.names_fingers = model.scene.hand.fingers() < subject.scene.hand.fingers();
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
  const NewFolders unless_used(options.out);
  std::optional<FileLock> lock;
  if (!options.out.empty()) lock.emplace(claim_folder(options.out, "--out"));
  std::vector<std::string> notes;
  const ImplicitSurface surface = make_object_surface(subject.scene, notes);
  if (!is_scene(options)) subject.scene.object.centre_of_mass_m = enclosed_centroid_m(surface.cloud());
  print_object_notes(notes, options.quiet);
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
    std::cout << fmt::format("\n{} in {}: thenar run {}\n", counted(std::ssize(report.grasps), "scene"),
                             options.out.string(), (options.out / "grasp-1.yaml").string());
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
  print_object_notes(found, options.quiet);
  scene.object.centre_of_mass_m = enclosed_centroid_m(surface.cloud());
  SceneTextNotes notes;
  notes.schema = schema_file();
  notes.hand = hand_in_scene(hand_file(options), seen_from(file.parent_path(), hand_file(options)));
  notes.object = seen_from(file.parent_path(), options.object);
  notes.about =
      scene.name +
      ", held by a hand: written by thenar new. thenar check says what is modelled, thenar run runs it, thenar "
      "keys lists all that a scene may say.";
  const Eigen::Vector3d size_mm = 1e3 * surface.bounds().sizes();
  notes.grasp = fmt::format(
      "The object measures {:.1f} x {:.1f} x {:.1f} mm. If that is not so, change object.shape.cloud.unit: what 1 in "
      "the file measures. In the file's axes, which are the object's, it reaches over x, y, z = {}.",
      size_mm.x(), size_mm.y(), size_mm.z(), in_words(surface.bounds()));
  write_file(file, scene_text(scene, notes));
  if (!options.quiet) {
    std::cout << fmt::format("{}: an object of {:.1f} x {:.1f} x {:.1f} mm; now: thenar run {}\n", file.string(),
                             size_mm.x(), size_mm.y(), size_mm.z(), file.string());
  }
  return kDone;
}
