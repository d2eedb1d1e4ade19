// SPDX-License-Identifier: Apache-2.0
#include "app/studies/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <sstream>
#include <vector>

#include "app/progress.h"
#include "app/studies/hand_list.h"
#include "collision/solids/sampled_solid.h"
#include "engine/control/control.h"
#include "engine/formats/point_cloud_file.h"
#include "engine/formats/text.h"
#include "engine/grasp/model.h"
#include "engine/grasp/slides.h"
#include "engine/models/build_model.h"
#include "engine/pulps/pulp_levels.h"
#include "engine/results/loop_words.h"
#include "engine/results/warnings.h"
#include "engine/scenes/scene_file.h"
#include "engine/stiffness/stiffness_report.h"
#include "engine/studies/model_parts.h"
#include "engine/studies/reflex_reach.h"
#include "engine/studies/savings.h"

namespace thenar::app {

namespace {

struct DescribeShape {
  std::ostream& out;

  void named(const char* name, const Eigen::Vector3d& size_m) const {
    out << name << " of " << 1e3 * size_m.x() << " x " << 1e3 * size_m.y() << " x " << 1e3 * size_m.z() << " mm";
  }
  void operator()(const BoxShape& box) const { named("box", box.size_m); }
  void operator()(const EllipsoidShape& ellipsoid) const { named("ellipsoid", ellipsoid.size_m); }
  void operator()(const SuperquadricShape& shape) const {
    named("superquadric", shape.size_m);
    out << " and exponents " << shape.exponents.north_south << " and " << shape.exponents.east_west;
  }
  void operator()(const SphereShape& sphere) const { out << "sphere of radius " << 1e3 * sphere.radius_m << " mm"; }
  void operator()(const CylinderShape& cylinder) const {
    out << "cylinder of radius " << 1e3 * cylinder.radius_m << " mm, " << 1e3 * cylinder.length_m << " mm long";
  }
  void operator()(const Mug& mug) const {
    out << "mug of radius " << 1e3 * mug.radius_m << " mm, " << 1e3 * mug.height_m << " mm high, its wall "
        << 1e3 * mug.wall_m << " mm" << (mug.handle ? ", with a handle" : "");
  }
  void operator()(const CloudShape& scan) const {
    out << (is_mesh_file(scan.file) ? "mesh in " : "surface scanned in ") << printable(scan.file.string());
    if (scan.unit_m != 1.0) out << ", where 1 is " << 1e3 * scan.unit_m << " mm";
  }
};

/// A point of the object.
std::string place(const Eigen::Vector3d& p_m) {
  return fmt::format("[{:.4g}, {:.4g}, {:.4g}] mm", 1e3 * p_m.x(), 1e3 * p_m.y(), 1e3 * p_m.z());
}

void describe_object(const ObjectSettings& object, std::ostream& out) {
  out << "  object          " << (object.compliance ? "soft " : "rigid ");
  std::visit(DescribeShape{out}, object.shape);
  if (object.points > 0) out << ", " << object.points << " points";
  out << ", " << 1e3 * object.mass_kg << " g, centred at " << place(object.centre_of_mass_m);
  if (object.compliance) {
    out << ", E* " << 1e-6 * object.compliance->reduced_modulus_Pa << " MPa, relaxation "
        << 1e3 * object.compliance->relaxation_s << " ms";
  }
  out << "\n";
}

struct DescribeSolid {
  std::string operator()(const HalfSpace&) const { return "plane"; }
  std::string operator()(const BoxShape& box) const {
    return fmt::format("box of {:.6g} x {:.6g} x {:.6g} mm", 1e3 * box.size_m.x(), 1e3 * box.size_m.y(),
                       1e3 * box.size_m.z());
  }
  std::string operator()(const SphereShape& sphere) const {
    return fmt::format("sphere of radius {:.6g} mm", 1e3 * sphere.radius_m);
  }
  std::string operator()(const CylinderShape& cylinder) const {
    return fmt::format("cylinder of radius {:.6g} mm, {:.6g} mm long", 1e3 * cylinder.radius_m,
                       1e3 * cylinder.length_m);
  }
  std::string operator()(const HoleShape& hole) const {
    return fmt::format("plane with a hole of {:.6g} mm, {:.6g} mm deep{}", 2e3 * hole.radius_m, 1e3 * hole.depth_m,
                       hole.chamfer_m > 0.0 ? fmt::format(", chamfer {:.6g} mm", 1e3 * hole.chamfer_m) : "");
  }
};

void describe_environment(const Model& model, std::ostream& out) {
  const Environment& environment = *model.scene.environment;
  for (const EnvironmentBody& body : environment.bodies) {
    out << "  environment     " << body.name << ": a " << std::visit(DescribeSolid{}, body.shape) << " at "
        << place(body.X_WE.translation()) << ", friction " << body.friction;
    if (!body.moves.empty()) out << ", which moves";
    out << "\n";
  }
  out << "                  gives way to the object by " << 1e6 * environment.compliance_m_per_N
      << " um/N at each contact; fingers do not touch it\n";
  if (!model.sampled) return;
  const auto um = [](double error_m) {
    return error_m < 5e-9 ? "below 0.01" : fmt::format("some {:.3g}", 1e6 * error_m);
  };
  out << "                  is touched by the object's samples, " << um(model.sampled->round_error_m())
      << " um off where they are round";
  if (!model.sampled->sharp().empty()) out << ", " << um(model.sampled->edge_error_m()) << " um at edges";
  out << ", more at tips\n";
}

void describe_warnings(const Model& model, std::ostream& out) {
  const std::vector<std::string> all = warnings(model);
  if (!all.empty()) out << "\nwarnings\n";
  for (const std::string& warning : all) out << "  " << warning << "\n";
}

/// What was mended in the object's surface; nothing, in one that somebody brought, is worth a word, too.
void describe_mending(const Model& model, std::ostream& out) {
  if (model.object_notes.empty() && !std::holds_alternative<CloudShape>(model.scene.object.shape)) return;
  out << "\nmended in the object's surface\n";
  for (const std::string& note : model.object_notes) out << "  " << note << "\n";
  if (model.object_notes.empty()) out << "  nothing\n";
}

std::string saving_in_words(const Saving& saving) {
  return fmt::format("{:.0f} ({:.0f} .. {:.0f})", saving.us, saving.low_us, saving.high_us);
}

void describe_effects(const Scene& scene, const std::vector<PartEffect>& effects, const Savings& savings,
                      std::ostream& out) {
  out << fmt::format("  {:<54}{:>20}  {}\n", "", "saves us", "without it, rms");
  for (std::size_t i = 0; i < effects.size(); ++i) {
    const PartEffect& effect = effects[i];
    out << fmt::format("  {:<54}{:>20}  {:<64}  {}\n", title(effect), saving_in_words(savings.without[i]),
                       effect.alike ? in_words(effect.error) : in_words(effect),
                       effect.within ? "could be left out" : "needed");
  }
  out << fmt::format(
      "  of {:.0f} us a tick; medians of {} runs in turns, and where the true ones lie with 95 %\n"
      "  moments: torsion of the patches, of the most that friction lets them carry\n"
      "  tolerance: {}\n",
      savings.full_us, savings.turns, in_words(scene.tolerance));
}

/// What `model: auto` leaves out; the last of the savings is that of all together.
void describe_needed(const Scene& scene, const NeededParts& needed, const Savings& savings, std::ostream& out) {
  std::vector<PartEffect> out_of_it = needed.tried;
  std::erase_if(out_of_it, [](const PartEffect& effect) { return !effect.within; });
  out << "  model: auto " << (scene.only_needed ? "leaves out" : "would leave out")
      << (out_of_it.empty() ? " nothing\n" : ", all together\n");
  for (const PartEffect& effect : out_of_it) out << "    " << title(effect) << "\n";
  if (out_of_it.empty()) return;
  out << fmt::format("  which saves {} us; {}\n", saving_in_words(savings.without.back()), in_words(out_of_it.back()));
}

/// What each part costs and gives, and what could be left out: the scene is run without it.
void describe_parts(const Model& model, std::ostream& out) {
  const Scene& scene = model.scene;
  ProgressLine line(false);
  const auto on_run = [&](const std::string& words) { line.show("running the scene: " + words); };
  on_run("all of it");
  const PathRun full = run_path(model);
  out << "\nwhat becomes of the grasp\n  " << in_words(full.verdict) << "\n\nwhat its parts cost and give\n";
  if (fails(scene, full.verdict.outcome)) {
    line.clear();
    out << "  not tried, for the scene fails\n";
    return;
  }
  const std::vector<PartEffect> effects = ablate(model, full, on_run);
  const NeededParts needed = needed_parts(model, full, on_run);
  std::vector<Model> without;
  for (const PartEffect& effect : effects) without.push_back(build_model(leave_out(scene, effect.part), model));
  without.push_back(build_model(needed.scene, model));
  const Savings savings = effects.empty() ? Savings() : measure_savings(model, without, on_run);
  line.clear();
  if (effects.empty()) {
    out << "  there is none that could be left out\n";
    return;
  }
  describe_effects(scene, effects, savings, out);
  describe_needed(scene, needed, savings, out);
}

void describe_contact(const Scene& scene, std::ostream& out) {
  if (const auto& tips = scene.fingertips) {
    out << "  fingertips      deformable: " << tips->points << " points, " << tips->leaves
        << " control points each, E* " << 1e-6 * tips->material.reduced_modulus_Pa << " MPa, relaxation "
        << 1e3 * tips->material.relaxation_s << " ms"
        << (tips->material.kernel == PulpKernel::kGaussian ? ", gaussian kernel" : "");
    if (tips->material.stiffening_per_N > 0.0) out << ", stiffening " << tips->material.stiffening_per_N << " /N";
    out << "\n";
    if (const auto& touch = tips->touch) {
      out << "  touch           is felt";
      if (scene.control) out << " " << 1e3 * touch->delay_s << " ms late";
      if (touch->noise > 0.0) out << ", with " << 100.0 * touch->noise << " % of noise";
      out << "\n";
    }
    out << "  contacts        at most " << scene.contact.max_per_finger << " a finger";
  } else {
    out << "  fingertips      rigid, one contact point each\n  contacts        at most 1 a finger";
  }
  out << ", closer than " << 1e3 * scene.contact.band_m
      << " mm, or that may come so close while a frame is in use; friction " << scene.contact.friction << "\n";
}

/// What each level of detail of the fingertips would cost and err, which one is used, and why.
void describe_levels(const Scene& scene, std::ostream& out) {
  if (!scene.fingertips || scene.contact.level == 0) return;
  std::vector<Pulp> pulps = make_pulps(scene);
  const double load_N = expected_load_N(scene, pulps.front());
  const std::vector<LevelEstimate> levels = estimate_levels(scene, pulps);
  const double allowed = scene.contact.force_error;
  const LevelEstimate& chosen = choose_level(levels, allowed);
  const int used = scene.contact.level.value_or(chosen.level);
  const std::string why = scene.contact.level ? "contact.level"
                          : chosen.force_error <= allowed
                              ? fmt::format("the coarsest within {:g} % (contact.force_error)", 100.0 * allowed)
                              : fmt::format("none is within {:g} %: the least error", 100.0 * allowed);
  out << fmt::format("  level of detail a finger, pressed with up to {:.2g} N, against Hertz:\n", load_N)
      << fmt::format("{:18}{:>6}{:>17}{:>11}{:>14}\n", "", "level", "control points", "contacts", "force error");
  for (const LevelEstimate& level : levels) {
    out << fmt::format("{:18}{:>6}{:>17}{:>11.1f}{:>12.1f} %{}\n", "",
                       level.level == 0 ? "leaves" : std::to_string(level.level), level.controls, level.contacts,
                       100.0 * level.force_error, level.level == used ? "  used: " + why : "");
  }
  if (used > levels.back().level) out << fmt::format("{:18}{:>6}  used: {}\n", "", used, why);
}

/// The gain of the force control, finger by finger where they differ.
std::string gains_in_words(const Scene& scene) {
  std::vector<double> gains;
  for (int k = 0; k < scene.hand.fingers(); ++k) gains.push_back(force_gain(scene, k));
  if (std::ranges::adjacent_find(gains, std::not_equal_to<>()) == gains.end()) gains.resize(1);
  std::string all;
  for (const double gain : gains) all += fmt::format("{}{:g}", all.empty() ? "" : ", ", gain);
  return all;
}

/// One line a fingertip on a slide: where it begins, in which direction it slides, and what drives it.
void describe_slides(const Scene& scene, std::ostream& out) {
  for (int k = 0; k < scene.hand.fingers(); ++k) {
    const Slide& slide = scene.slides[k];
    const Fingertip& tip = scene.hand.fingertips[k];
    const Eigen::Isometry3d& X_WS = scene.hand.segments[tip.segment].X_WS_0;
    const Eigen::Vector3d along = X_WS.linear() * tip.normal;
    out << (k == 0 ? "  slides          " : "                  ")
        << fmt::format("{}: radius {:.6g} mm, from {} ", tip.finger, 1e3 * tip.radius_m, place(X_WS.translation()));
    if (scene.has_path(k)) {
      double over_s = 0.0;
      for (const PathLeg& leg : slide.path) over_s += leg.over_s;
      out << fmt::format("on a path to {} in {:.6g} s, whatever resists\n",
                         place(X_WS.translation() + path_m(slide, over_s)), over_s);
      continue;
    }
    const Joint& joint = scene.hand.joints[tip.first_joint];
    out << fmt::format("along [{:.4g}, {:.4g}, {:.4g}], ", along.x(), along.y(), along.z());
    if (slide.stiffness_N_per_m > 0.0) {
      out << fmt::format("by a spring of {:.6g} N/m at rest {:.6g} mm along it", slide.stiffness_N_per_m,
                         1e3 * slide.rest_m);
    } else {
      out << fmt::format("by {:.6g} N", slide.force_N);
      if (slide.rise_s > 0.0) out << fmt::format(", rising for {:.6g} ms", 1e3 * slide.rise_s);
    }
    out << fmt::format("; damping {:.6g} N s/m, range {:.6g} .. {:.6g} mm\n", scene.viscosity(k), 1e3 * joint.lower_rad,
                       1e3 * joint.upper_rad);
  }
}

void describe_control(const Scene& scene, std::ostream& out) {
  if (!scene.control) {
    out << "  drive           " << (scene.hand.slides ? "of each fingertip its own\n" : "given joint torques\n");
    return;
  }
  const bool feedforward = scene.control->law == ControlLaw::kFeedforward;
  const bool pyramids = scene.control->cone == FrictionCone::kPyramid;
  const double mu_c = scene.control->grasp_friction;
  out << "  control         with every frame: PID, grasp forces (" << (pyramids ? "pyramids" : "exact cones")
      << ", mu_c " << mu_c << "), " << (feedforward ? "feedforward law" : "law of the paper") << ", gain "
      << gains_in_words(scene) << " N m/rad" << (scene.control->gain ? "" : " (auto)") << "\n"
      << "  drive           "
      << (scene.control->muscles ? std::to_string(scene.hand.muscles.size()) + " muscles" : "joint torques");
  if (scene.control->drive) out << ", by " << printable(scene.control->drive->file.string()) << " instead of the law";
  out << "\n";
  if (scene.control->posture_Nm_per_rad) {
    out << "  posture         kept as at the start, where the fingertips leave it free, by "
        << *scene.control->posture_Nm_per_rad << " N m/rad\n";
  }
}

/// What the pose's loop stands, and what the reflex can hold: by first-order mechanics, nothing is run.
void describe_reach(const Model& model, std::ostream& out) {
  for (const LoopMargin& margin : loop_margins(model)) {
    const std::string phase =
        margin.phase < 0 ? ""
                         : fmt::format("in phase {}, {}: ", margin.phase + 1,
                                       to_string(model.scene.task.phases[static_cast<std::size_t>(margin.phase)].kind));
    out << (margin.phase < 0 ? "  pose loop       " : "                  ") << phase << in_words(model, margin) << "\n";
  }
  if (const auto reach = reflex_reach(model)) {
    out << fmt::format("  reflex reaches  a load step of {:.2f} N {}, answered after {:.0f} ms", reach->load_N,
                       reach->of_push ? "where the task pushes" : "downwards", 1e3 * reach->answer_s);
    if (reach->friction) out << fmt::format(", and a friction that falls to {:.2f}", *reach->friction);
    out << fmt::format(", before a finger has slid by {:.3g} mm, if nothing turns\n", 1e3 * reach->slip_m);
  } else if (model.scene.control->reflex) {
    out << "  reflex reaches  nothing that can be told: the load is along the fingers' normals, or slides at rest\n";
  }
}

void describe_feeling(const Model& model, std::ostream& out) {
  const ControlSettings& control = *model.scene.control;
  if (control.feedback_delay_s > 0.0) {
    out << "  known late      object, joints and loads, by " << 1e3 * control.feedback_delay_s << " ms\n";
  }
  if (control.anticipation) out << "  anticipates     what the target's and the arm's motion needs\n";
  if (control.felt_margin) {
    out << "  cones           of the friction that is felt, with a margin of " << *control.felt_margin << "\n";
  }
  if (const auto& reflex = control.reflex) {
    out << "  reflex          to loads that change by " << reflex->load_rate_N_per_s << " N/s, and to less than "
        << 100.0 * reflex->stick << " % of a patch sticking\n";
  }
  describe_reach(model, out);
}

/// What stiffness muscles could give the object: the scene is run until it has settled.
void describe_stiffness(const Model& model, std::ostream& out) {
  const MuscleSettings* muscles = model.scene.has_muscles() ? &*model.scene.control->muscles : nullptr;
  if (muscles == nullptr || !muscles->short_range) return;
  const auto range = settled_stiffness_range(model);
  if (!range) {
    out << "\nstiffness of the object\n  nothing is known of it: it is soft, or some finger never bears load\n";
    return;
  }
  out << fmt::format(
      "\nstiffness of the object that muscles can give it at {:.3g} s, with torques and contacts as then\n",
      range->at_s);
  for (const std::string& line : range_lines(model.scene.hand, *range)) out << "  " << line << "\n";
}

void describe_frames(const Scene& scene, std::ostream& out) {
  out << "  frames          every " << 1e3 * scene.control_period_s << " ms";
  if (scene.control_delay_s > 0.0) {
    out << "; two loops use them " << 1e3 * scene.control_delay_s << " ms after their snapshot (time.control_delay)";
  }
  out << "\n";
}

void describe_task(const TaskSettings& task, std::ostream& out) {
  if (const auto& move = task.translate) {
    out << "  task            moves the object by " << 1e3 * move->amount << " mm from " << move->from_s << " s over "
        << move->over_s << " s\n";
  }
  if (const auto& move = task.rotate) {
    out << "  task            turns the object by " << move->amount * 180.0 / EIGEN_PI << " degrees from "
        << move->from_s << " s over " << move->over_s << " s\n";
  }
  if (const auto& push = task.push) {
    const double force_N = push->force_N.norm(), moment_Nm = push->moment_Nm.norm();
    out << "  task            pushes the object with ";
    if (force_N > 0.0 || moment_Nm == 0.0) out << force_N << " N at " << place(push->at_m);
    if (force_N > 0.0 && moment_Nm > 0.0) out << " and ";
    if (moment_Nm > 0.0) out << moment_Nm << " N m";
    out << " from " << push->from_s << " s for " << push->over_s << " s";
    if (push->rise_s > 0.0) out << ", rising for " << 1e3 * push->rise_s << " ms";
    out << "\n";
  }
  if (const auto& arm = task.arm) {
    out << "  task            swings the arm by " << 1e3 * arm->amplitude_m << " mm at " << arm->frequency_Hz
        << " Hz from " << arm->from_s << " s for " << arm->over_s << " s\n";
  }
  for (const FrictionStep& step : task.friction) {
    out << "  task            makes the friction " << step.friction << " at " << step.from_s << " s\n";
  }
  if (task.lost_m) out << "  task            is lost where a finger slides by " << 1e3 * *task.lost_m << " mm\n";
  if (const auto& spring = task.spring) {
    out << "  task            pulls the object to its target by a spring of " << spring->translation_N_per_m
        << " N/m and " << spring->rotation_Nm_per_rad << " N m/rad\n";
  }
  std::string phases;
  for (const Phase& phase : task.phases) phases += (phases.empty() ? "" : ", ") + std::string(to_string(phase.kind));
  if (!phases.empty()) out << "  task            goes through its phases: " << phases << '\n';
  const bool idle = !task.translate && !task.rotate && !task.spring && !task.push && !task.arm && phases.empty();
  if (idle) out << "  task            holds the object\n";
}

}  // namespace

std::string description(const Scene& asked, bool with_parts) {
  // Made for shapes, too: whether their samples make a surface shows then.
  ReadyingLine readying(false);
  const Model model = build_model(asked, readying.begins());
  readying.hide();
  const Scene& scene = model.scene;  // with the grasp that was found, if one was asked for
  std::ostringstream out;
  out << scene.name << ": " << scene.duration_s << " s in steps of " << 1e3 * scene.step_s << " ms\n\nmodelled\n"
      << "  hand            ";
  if (scene.hand.slides) {
    out << "none: fingertips on slides, no inertia\n";
    describe_slides(scene, out);
  } else {
    out << joint_count(scene.hand) << ", viscosity " << scene.joint_viscosity << " N m s, no inertia\n";
  }
  describe_object(scene.object, out);
  if (scene.environment) describe_environment(model, out);
  describe_contact(scene, out);
  describe_levels(scene, out);
  describe_frames(scene, out);
  describe_control(scene, out);
  if (scene.control) describe_feeling(model, out);
  describe_task(scene.task, out);
  describe_stiffness(model, out);

  out << "\nleft out, at no cost\n";
  bool complete = true;
  const auto left_out = [&](bool is_out, const char* what) {
    if (is_out) out << "  " << what << "\n";
    complete = complete && !is_out;
  };
  left_out(!scene.fingertips, "deformation of the fingertips (fingertips)");
  left_out(scene.fingertips && !scene.object.compliance, "deformation of the object (object.compliance)");
  left_out(!scene.control && !scene.hand.slides, "control (control): pose, grasp forces, muscles");
  left_out(scene.control && !scene.control->muscles, "muscles (control.muscles)");
  left_out(scene.control && !scene.control->posture_Nm_per_rad, "a posture that is kept (control.posture)");
  left_out(scene.fingertips && !scene.fingertips->touch, "what fingertips feel (fingertips.touch)");
  left_out(scene.control && model.feels() && !scene.control->reflex, "a grip that answers (control.reflex)");
  left_out(scene.gravity.isZero(), "gravity (gravity)");
  if (complete) out << "  nothing\n";

  if (!model.grasp_notes.empty()) out << "\ngrasp found\n" << model.grasp_notes << "\n";
  describe_warnings(model, out);
  describe_mending(model, out);
  if (with_parts) describe_parts(model, out);

  out << "\ndefaults used\n";
  for (const std::string& line : scene.defaults_used) out << "  " << line << "\n";
  if (scene.defaults_used.empty()) out << "  none\n";
  if (!with_parts) out << "\nwith --parts it is run, and its parts are weighed\n";
  return out.str();
}

}  // namespace thenar::app
