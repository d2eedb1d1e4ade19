// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/muscle_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engine/formats/text.h"
#include "engine/hand/muscles.h"
#include "engine/imports/crossing_fit.h"
#include "engine/imports/tendon_route.h"
#include "engine/scenes/config.h"
#include "solvers/muscles/muscle_forces.h"

namespace thenar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

[[noreturn]] void refuse_tendon(const TreeTendon& tendon, const std::string& what) {
  throw ConfigError({{printable(tendon.place), printable(fmt::format("spatial '{}'", tendon.name)), printable(what)}});
}

SegmentPoint point_of(const TreePose& pose, const TreeSegments& segments, const Hand& hand, int body,
                      const Vector3d& p_B) {
  const int segment = segments.of_body[body];
  return {segment, hand.segments[segment].X_WS_0.inverse() * (pose.X_HB[body] * p_B)};
}

/// Returns the parts of a tendon that some joint changes.
std::vector<RouteSpan> spans_of(const BodyTree& tree, const TreePose& pose, const TreeSegments& segments,
                                const Hand& hand, const TreeTendon& tendon) {
  const auto site = [&](int index) {
    const TreeSite& at = tree.sites[index];
    return point_of(pose, segments, hand, at.body, at.X_BS.translation());
  };
  std::vector<RouteSpan> spans;
  for (std::size_t i = 1; i < tendon.steps.size(); ++i) {
    const TreeTendonStep& step = tendon.steps[i];
    if (step.begins) continue;
    RouteSpan span{site(tendon.steps[i - 1].site), site(step.site), std::nullopt, step.share};
    bool crosses = span.from.segment != span.to.segment;
    if (step.wrap >= 0) {
      const TreeWrap& around = tree.wraps[step.wrap];
      const int segment = segments.of_body[around.body];
      RouteWrap wrap{segment,
                     hand.segments[segment].X_WS_0.inverse() * pose.X_HB[around.body] * around.X_BG,
                     {around.radius_m, around.is_cylinder},
                     std::nullopt};
      if (step.side_site >= 0) wrap.side = site(step.side_site);
      crosses = crosses || segment != span.from.segment;
      span.wrap = wrap;
    }
    if (crosses) spans.push_back(span);
  }
  return spans;
}

/// Returns "MCP2 flexion 0.12 (at most 0.31)" for each joint that the tendon moves: the error of the muscle's moment
/// arms against the tendon's, rms over postures in the joints' ranges.
std::string errors_of(const Hand& hand, const std::vector<RouteSpan>& spans, const std::vector<HandPose>& poses,
                      const Muscle& muscle, double& worst_m) {
  Hand alone = hand;
  alone.muscles = {muscle};
  const auto joints = static_cast<Index>(hand.joints.size());
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(joints), most = squares, size = squares;
  MatrixXd H(joints, 1);
  for (const HandPose& pose : poses) {
    JointVector arms = hand.at_zero();
    for (const RouteSpan& span : spans) arms += span_arms(hand, pose, span);
    moment_arms(alone, pose, H);
    const Eigen::VectorXd error = (H.col(0) - arms).cwiseAbs();
    squares += error.cwiseAbs2();
    most = most.cwiseMax(error);
    size = size.cwiseMax(arms.cwiseAbs());
  }
  std::string text;
  worst_m = 0.0;
  for (Index j = 0; j < joints; ++j) {
    if (size[j] == 0.0 && most[j] == 0.0) continue;
    const double rms_m = std::sqrt(squares[j] / static_cast<double>(poses.size()));
    worst_m = std::max(worst_m, rms_m);
    text += fmt::format("{}{} {:.2f} (at most {:.2f})", text.empty() ? "" : ", ", hand.joints[j].name, 1e3 * rms_m,
                        1e3 * most[j]);
  }
  return text;
}

void add_muscle(const TreeTendon& tendon, const std::vector<RouteSpan>& spans, const std::vector<HandPose>& poses,
                ImportedHand& made) {
  constexpr double kMostForce_N = 1e4, kAllowed_m = 0.5e-3;
  Muscle muscle{tendon.muscle.empty() ? tendon.name : tendon.muscle, *tendon.max_force_N, {}};
  if (muscle.name.empty()) muscle.name = fmt::format("muscle{}", made.hand.muscles.size() + 1);
  if (muscle.max_force_N > kMostForce_N) refuse_tendon(tendon, fmt::format("pulls with {:g} N", muscle.max_force_N));
  bool wraps = false;
  for (const RouteSpan& span : spans) {
    const std::vector<MuscleCrossing> crossings =
        span.wrap ? fit_crossings(made.hand, span) : crossings_of(made.hand, span);
    muscle.crossings.insert(muscle.crossings.end(), crossings.begin(), crossings.end());
    wraps = wraps || span.wrap;
  }
  made.muscle_notes.emplace_back();
  if (wraps) {
    double worst_m = 0.0;
    const std::string errors = errors_of(made.hand, spans, poses, muscle, worst_m);
    made.muscle_notes.back() =
        fmt::format("wraps a surface, here by fitted points; moment arms off by, in mm rms: {}", errors);
    if (worst_m > kAllowed_m) {
      made.notes.push_back(fmt::format("the moment arms of '{}' are approximate: off by up to {:.1f} mm rms",
                                       muscle.name, 1e3 * worst_m));
    }
  }
  made.hand.muscles.push_back(std::move(muscle));
}

}  // namespace

void import_muscles(const BodyTree& tree, const TreePose& pose, const TreeSegments& segments, ImportedHand& made) {
  constexpr int kPostures = 500, kMostWraps = 200;  // A human hand's tendons wrap some 50 times.
  std::ptrdiff_t wraps = 0;
  const std::vector<HandPose> poses = random_poses(made.hand, kPostures, 1);
  std::vector<std::string_view> passive, elsewhere;
  for (const TreeTendon& tendon : tree.tendons) {
    const std::vector<RouteSpan> spans = spans_of(tree, pose, segments, made.hand, tendon);
    wraps += std::ranges::count_if(spans, [](const RouteSpan& span) { return span.wrap.has_value(); });
    if (wraps > kMostWraps) refuse_tendon(tendon, fmt::format("tendons wrap surfaces more than {} times", kMostWraps));
    if (spans.empty()) {
      elsewhere.push_back(tendon.muscle.empty() ? tendon.name : tendon.muscle);
    } else if (!tendon.max_force_N) {
      passive.push_back(tendon.name);
    } else if (std::ssize(made.hand.muscles) == kMaxMuscles) {
      refuse_tendon(tendon, fmt::format("is one muscle too many: a hand has at most {}", kMaxMuscles));
    } else {
      add_muscle(tendon, spans, poses, made);
    }
  }
  if (!passive.empty()) made.notes.push_back("tendons without a muscle are left out: " + join(passive, ", "));
  if (!elsewhere.empty()) made.notes.push_back("tendons that move no finger are left out: " + join(elsewhere, ", "));
}

}  // namespace thenar
