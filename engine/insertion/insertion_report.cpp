// SPDX-License-Identifier: Apache-2.0
#include "engine/insertion/insertion_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/results/recording.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

/// A phase in numbers: those of its tick with the largest F_z.
struct PhaseRow {
  const PegTick *first, *last, *most;
  std::optional<JammingPoint> at;
  bool wedged = false;
};

PhaseRow row_of(const InsertionStudy& study, const PegPhase& phase) {
  PhaseRow row{&study.ticks[phase.begin], &study.ticks[phase.end - 1], &study.ticks[phase.begin], {}};
  for (std::size_t i = phase.begin; i < phase.end; ++i) {
    const PegTick& tick = study.ticks[i];
    if (tick.push_N > row.most->push_N) row.most = &tick;
    row.wedged |= tick.wedged;
  }
  row.at = jamming_point(study.peg, *row.most);
  return row;
}

/// Returns l of the theory's two points with this tilt, if any.
double two_point_m(const PegScene& peg, double tilt_rad) {
  constexpr double kUpright = 1e-9;
  if (!(std::abs(tilt_rad) > kUpright)) return std::numeric_limits<double>::infinity();
  return peg.shape.two_point_m(std::abs(tilt_rad));
}

double below_m(const PegScene& peg, const PegTick& tick) { return tick.depth_m - peg.shape.chamfer_m; }

std::string bounds_text(const PegScene& peg) {
  const PegShape& shape = peg.shape;
  const double tilt = std::abs(peg.tilt_rad), limit = shape.wedging_tilt_rad(), two_m = two_point_m(peg, tilt);
  std::string text =
      fmt::format("\nby Whitney's theory\n  {:<30}{:>10.4g}      (D - d) / D\n", "clearance c", shape.clearance());
  text += fmt::format("  {:<30}{:>10.4g} mm   the chamfer takes {:.4g} mm\n", "aside at the start",
                      1e3 * std::abs(peg.aside_m), 1e3 * (shape.chamfer_m + shape.hole_radius_m - shape.radius_m));
  text += fmt::format("  {:<30}{:>10.4g} deg  {}\n", "tilt at the start", kDegrees * tilt,
                      tilt < limit ? "below c / mu: friction cannot wedge it"
                                   : "above c / mu: friction can wedge it, if it keeps that tilt");
  text += fmt::format("  {:<30}{:>10.4g} deg\n", "c / mu", kDegrees * limit);
  if (std::isfinite(two_m)) {
    text += fmt::format("  {:<30}{:>10.4g} mm   below the chamfer, if it keeps its tilt: theta l = c D\n",
                        "it would touch two points at", 1e3 * two_m);
  }
  return text;
}

std::string phases_text(const InsertionStudy& study) {
  std::string text =
      fmt::format("\n  {:>7} {:>7}  {:<11}{:>15}{:>7}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>7}{:>8}\n", "from", "to", "touch",
                  "depth", "tilt", "F_z", "F_x", "M", "normal", "F_x/F_z", "M/rF_z", "lambda", "margin");
  text += fmt::format("  {:>7} {:>7}  {:<11}{:>15}{:>7}{:>8}{:>8}{:>8}{:>8}\n", "s", "s", "", "mm", "deg", "N", "N",
                      "N mm", "N");
  for (const PegPhase& phase : study.phases) {
    const PhaseRow row = row_of(study, phase);
    text += fmt::format("  {:>7.3f} {:>7.3f}  {:<11}{:>6.2f} .. {:>5.2f}", row.first->time_s, row.last->time_s,
                        to_string(phase.touch), 1e3 * row.first->depth_m, 1e3 * row.last->depth_m);
    if (phase.touch != PegTouch::kFree) {
      text += fmt::format("{:>7.2f}{:>8.3f}{:>8.3f}{:>8.2f}{:>8.2f}", kDegrees * row.most->tilt_rad, row.most->push_N,
                          row.most->aside_N, 1e3 * row.most->moment_Nm, row.most->normal_N);
      if (row.at) {
        text += fmt::format("{:>8.2f}{:>8.2f}{:>7.2f}{:>8.3f}", row.at->across, row.at->moment, row.at->lambda,
                            row.at->margin);
      }
    }
    text += row.wedged ? "  wedged\n" : "\n";
  }
  return text +
         "  numbers of the tick with the largest F_z; depth below the plate; margin: 0 on the diagram's lines, where "
         "the peg\n  slides, below 0 outside, where it jams; a tilt is small against mu there\n";
}

std::string theory_text(const InsertionStudy& study) {
  if (study.theory.empty()) return "";
  std::string text = "\nF_z against the theory of a peg on the controller's springs, at the same depth\n";
  for (const PegTouch touch : {PegTouch::kChamfer, PegTouch::kOnePoint, PegTouch::kTwoPoints}) {
    const double off = study.off_theory(touch);
    if (!std::isnan(off)) text += fmt::format("  {:<30}{:>10.3g} %    of its largest\n", to_string(touch), 100.0 * off);
  }
  return text;
}

ordered_json to_json(const PegScene& peg, const JammingPoint& at) {
  return {{"lambda", at.lambda},
          {"Fx_over_Fz", at.across},
          {"M_over_rFz", at.moment},
          {"margin", at.margin},
          {"friction", peg.shape.friction}};
}

ordered_json to_json(const InsertionStudy& study, const PegPhase& phase) {
  const PhaseRow row = row_of(study, phase);
  ordered_json json{{"touch", to_string(phase.touch)},
                    {"from_s", row.first->time_s},
                    {"to_s", row.last->time_s},
                    {"from_depth_mm", 1e3 * row.first->depth_m},
                    {"to_depth_mm", 1e3 * row.last->depth_m},
                    {"wedged", row.wedged},
                    {"most",
                     {{"time_s", row.most->time_s},
                      {"depth_mm", 1e3 * row.most->depth_m},
                      {"tilt_deg", kDegrees * row.most->tilt_rad},
                      {"F_z_N", row.most->push_N},
                      {"F_x_N", row.most->aside_N},
                      {"F_y_N", row.most->across_N},
                      {"M_Nmm", 1e3 * row.most->moment_Nm},
                      {"normal_N", row.most->normal_N}}},
                    {"diagram", row.at ? to_json(study.peg, *row.at) : ordered_json(nullptr)}};
  return json;
}

ordered_json place_json(const InsertionStudy& study, const std::optional<std::size_t>& at) {
  if (!at) return nullptr;
  const PegTick& tick = study.ticks[*at];
  return {{"time_s", tick.time_s},
          {"depth_mm", 1e3 * tick.depth_m},
          {"below_chamfer_mm", 1e3 * below_m(study.peg, tick)},
          {"tilt_deg", kDegrees * tick.tilt_rad},
          {"two_points_by_tilt_mm", 1e3 * two_point_m(study.peg, tick.tilt_rad)}};
}

}  // namespace

std::string end_in_words(const InsertionStudy& study) {
  const auto depth = [&](std::size_t at) { return 1e3 * study.ticks[at].depth_m; };
  const double last_mm = study.ticks.empty() ? 0.0 : 1e3 * study.ticks.back().depth_m;
  switch (study.end) {
    case PegEnd::kIn:
      return fmt::format("in, {:.1f} mm deep{}{}", last_mm,
                         std::isnan(study.asked_m) ? "" : fmt::format(" of {:.1f} mm", 1e3 * study.asked_m),
                         study.wedged
                             ? fmt::format(", after two contacts wedged it at {:.1f} mm and the hand turned it free",
                                           depth(*study.wedged))
                             : "");
    case PegEnd::kWedged:
      return fmt::format("wedged at {:.1f} mm: two contacts within the friction cones", depth(*study.wedged));
    case PegEnd::kJammed:
      return fmt::format("jammed at {:.1f} mm: the hand's push and turn do not move it on", depth(*study.stopped));
    case PegEnd::kLost:
      return fmt::format("lost at {:.1f} mm: the hand no longer held it", last_mm);
    case PegEnd::kOutside:
      break;
  }
  return "outside: it did not come below the chamfer";
}

std::string insertion_text(const Scene& scene, const InsertionStudy& study) {
  const PegScene& peg = study.peg;
  std::string text = fmt::format("{}: a peg of {:.6g} mm into '{}' of {:.6g} mm, friction {:g}\n", scene.name,
                                 2e3 * peg.shape.radius_m, scene.environment->bodies[peg.body].name,
                                 2e3 * peg.shape.hole_radius_m, peg.shape.friction);
  text += "  " + end_in_words(study) + "\n  the grasp: " + in_words(study.verdict) + "\n" + bounds_text(peg);
  if (study.two_points) {
    const PegTick& tick = study.ticks[*study.two_points];
    const double l_m = below_m(peg, tick), two_m = two_point_m(peg, tick.tilt_rad);
    text += fmt::format(
        "  {:<30}{:>10.4g} mm   with {:.4g} deg: {:.4g} mm by theta l = c D; friction can wedge it in the first {:.4g} "
        "mm\n",
        "it did at", 1e3 * l_m, kDegrees * tick.tilt_rad, 1e3 * two_m, 2e3 * peg.shape.friction * peg.shape.radius_m);
  }
  text += "\nhow they touched\n";
  for (const PegTouch touch : kPegTouches) {
    const auto is = [&](const PegPhase& phase) { return phase.touch == touch; };
    if (std::ranges::any_of(study.phases, is)) text += fmt::format("  {:<12}{}\n", to_string(touch), in_words(touch));
  }
  return text + phases_text(study) + theory_text(study);
}

ordered_json insertion_json(const Scene& scene, const InsertionStudy& study) {
  const PegScene& peg = study.peg;
  const PegShape& shape = peg.shape;
  ordered_json phases = ordered_json::array();
  for (const PegPhase& phase : study.phases) phases.push_back(to_json(study, phase));
  ordered_json off;
  for (const PegTouch touch : {PegTouch::kChamfer, PegTouch::kOnePoint, PegTouch::kTwoPoints})
    off[to_string(touch)] = study.off_theory(touch);
  return {{"scene", scene.name},
          {"end", to_string(study.end)},
          {"end_in_words", end_in_words(study)},
          {"outcome", to_string(study.verdict.outcome)},
          {"reason", study.verdict.reason},
          {"peg",
           {{"diameter_mm", 2e3 * shape.radius_m},
            {"hole_mm", 2e3 * shape.hole_radius_m},
            {"chamfer_mm", 1e3 * shape.chamfer_m},
            {"friction", shape.friction},
            {"tilt_deg", kDegrees * peg.tilt_rad},
            {"aside_mm", 1e3 * peg.aside_m}}},
          {"theory",
           {{"clearance", shape.clearance()},
            {"wedging_tilt_deg", kDegrees * shape.wedging_tilt_rad()},
            {"can_wedge", std::abs(peg.tilt_rad) >= shape.wedging_tilt_rad()},
            {"two_points_mm", 1e3 * two_point_m(peg, peg.tilt_rad)},
            {"wedging_within_mm", 2e3 * shape.friction * shape.radius_m},
            {"F_z_off_share", off}}},
          {"two_points", place_json(study, study.two_points)},
          {"wedged", place_json(study, study.wedged)},
          {"stopped", place_json(study, study.stopped)},
          {"phases", phases}};
}

std::string insertion_csv(const InsertionStudy& study) {
  std::string text =
      "time_s,touch,depth_mm,tilt_deg,F_z_N,F_x_N,F_y_N,M_Nmm,normal_N,wedged,lambda,Fx_over_Fz,M_over_rFz,margin,"
      "theory_depth_mm,theory_F_z_N,theory_tilt_deg,theory_points\n";
  for (const PegTick& tick : study.ticks) {
    text += fmt::format("{:.6g},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{}", tick.time_s,
                        static_cast<int>(tick.touch), 1e3 * tick.depth_m, kDegrees * tick.tilt_rad, tick.push_N,
                        tick.aside_N, tick.across_N, 1e3 * tick.moment_Nm, tick.normal_N, tick.wedged ? 1 : 0);
    if (const auto at = jamming_point(study.peg, tick)) {
      text += fmt::format(",{:.6g},{:.6g},{:.6g},{:.6g},,,,\n", at->lambda, at->across, at->moment, at->margin);
    } else {
      text += ",,,,,,,,\n";
    }
  }
  for (const PegForce& force : study.theory) {
    text += fmt::format(",,,,,,,,,,,,,,{:.6g},{:.6g},{:.6g},{}\n", 1e3 * force.depth_m, force.push_N,
                        kDegrees * force.tilt_rad, force.points);
  }
  return text;
}

}  // namespace thenar
