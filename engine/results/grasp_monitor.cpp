// SPDX-License-Identifier: Apache-2.0
#include "engine/results/grasp_monitor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "engine/control/pose_loop.h"
#include "engine/finder/grasp_deficit.h"
#include "engine/results/loop_words.h"

namespace thenar {

namespace {

constexpr double kStillSoft_s = 0.3;       // A stiffness that was lacking so lately still is.
constexpr double kRests_s = 0.3;           // A finger that has not slid for so long sticks again.
constexpr double kStopsWithin_rad = 1e-6;  // Of the ends of their ranges joints come to rest.
constexpr double kAnyFriction = 0.01;      // A grasp that so little friction would close is closed by any.
constexpr std::size_t kMostNamed = 3;      // Limits passed; a reason counts the others.

/// The fingers that are not there, and how far away they are; empty: all touch the object, or nearly do.
std::string apart_in_words(const Scene& scene, const ControlReport& control) {
  std::string all;
  for (int k = 0; k < scene.hand.fingers(); ++k) {
    if (!(control.gap_m[k] > scene.contact.band_m)) continue;
    all += fmt::format("{}the {} does not touch the object ({:.3g} mm away)", all.empty() ? "" : ", ",
                       scene.hand.fingertips[k].finger, 1e3 * control.gap_m[k]);
  }
  return all;
}

bool is_late(const Scene& scene) {
  return scene.control && (scene.control_delay_s > 0.0 || scene.control->feedback_delay_s > 0.0);
}

/// What came about where the grasp forces were to be found.
std::string what_failed(const UnsolvedGrasp& unsolved) {
  const bool infeasible = unsolved.control.grasp == GraspStatus::kInfeasible;
  return fmt::format("{} at {:.3f} s", infeasible ? "no grasp forces exist" : "no grasp forces were found",
                     unsolved.time_s);
}

/// Names the fingers that do not touch; else the cones that are too narrow and the tangential force that they lack, and
/// what friction would do.
std::string explain(const Scene& scene, const UnsolvedGrasp& unsolved) {
  std::string message = what_failed(unsolved) + ": ";
  const std::string apart = apart_in_words(scene, unsolved.control);
  if (!apart.empty()) return message + apart + "; object.position and hand.posture place them";
  const GraspProblem problem = grasp_problem(scene, unsolved.control);
  const GraspDeficit deficit = explain_infeasible_grasp(problem);
  for (int k = 0; k < scene.hand.fingers(); ++k) {
    message +=
        fmt::format("{}the {}'s friction cone (mu_c = {:.3g}) lacks {:.3f} N of tangential force", k > 0 ? ", " : "",
                    scene.hand.fingertips[k].finger, problem.friction_of(k), deficit.missing_N.col(k).tail<2>().norm());
  }
  if (deficit.least_friction <= kAnyFriction) return message + "; any mu_c > 0 with enough squeeze would do";
  if (std::isfinite(deficit.least_friction)) {
    return message + fmt::format("; control.grasp.friction of at least {:.3f} would do", deficit.least_friction);
  }
  return message + "; no friction would do: the fingers do not oppose each other";
}

/// The worst muscles, then the worst joints.
std::string limits_in_words(std::vector<Excess> beyond) {
  const auto severity = [](const Excess& e) {
    return e.muscle ? 1e3 + e.value / e.limit : std::abs(e.value - e.limit);  // No joint is off by 1000 rad.
  };
  std::ranges::stable_sort(beyond, std::greater<>(), severity);
  std::string all;
  for (std::size_t i = 0; i < std::min(kMostNamed, beyond.size()); ++i) {
    all += (i > 0 ? ", " : "") + in_words(beyond[i]);
  }
  return beyond.size() > kMostNamed ? all + fmt::format(", and {} more", beyond.size() - kMostNamed) : all;
}

}  // namespace

std::vector<std::string> muscle_names(const Hand& hand, std::uint64_t which) {
  std::vector<std::string> names;
  for (std::size_t m = 0; m < hand.muscles.size(); ++m) {
    if ((which >> m & 1) != 0) names.push_back(hand.muscles[m].name);
  }
  return names;
}

std::string lack_in_words(const Hand& hand, const StiffnessReport& found) {
  std::string words;
  if (const auto& axis = found.axis_O) {
    words = fmt::format("{} ({:.2f}, {:.2f}, {:.2f}) of the object lacks {:.3g} {}",
                        found.rotates ? "rotation about" : "translation along", axis->x(), axis->y(), axis->z(),
                        found.lacking, found.rotates ? "N m/rad" : "N/m");
  } else {
    words = "a finger's posture gives way";
  }
  const std::vector<std::string> muscles = muscle_names(hand, found.at_limit);
  return muscles.empty() ? words : fmt::format("{}; at their limit: {}", words, fmt::join(muscles, ", "));
}

void GraspMonitor::Worst::add(double time_s, double excess, double now) {
  if (!(excess > 0.0)) return;
  if (!first_s) first_s = time_s;
  if (excess <= beyond) return;
  beyond = excess;
  at_s = time_s;
  value = now;
}

GraspMonitor::GraspMonitor(const Model& model)
    : model_(model),
      slip_m_(model.fingers()),
      slips_since_s_(model.fingers()),
      slid_s_(model.fingers()),
      walks_(model.fingers()),
      joints_(model.scene.hand.joints.size()),
      muscles_(model.scene.hand.muscles.size()),
      pulls_(model.scene.muscles_act() ? model.scene.hand.muscles.size() : 0),
      task_(model),
      chatter_(model) {}

void GraspMonitor::add(double time_s, const ControlReport& control, const Eigen::VectorXd& muscle_forces_N) {
  if (is_closed_) return;
  if (const StiffnessReport& found = control.stiffness; found.is_chosen) {
    chosen_s_ = time_s;
    if (found.is_infeasible && !(too_soft_ && too_soft_->time_s >= kMeasuredFrom_s)) {
      const std::string lack = lack_in_words(model_.scene.hand, found);
      too_soft_ = Event{time_s, fmt::format("no muscle forces make the object so stiff at {:.3f} s: {}", time_s, lack)};
    }
    if (found.is_unanswered && !found.is_infeasible && !(found.share > 0.0) && !unsolved_) {
      unsolved_ = Event{
          time_s, fmt::format("the problem of muscle forces for a stiffness found no answer at {:.3f} s", time_s)};
    }
  }
  task_.add(control.task);
  if (!unsolved_grasp_ && is_late(model_.scene) && time_s < kMeasuredFrom_s && control.grasp == GraspStatus::kOptimal) {
    solved_ = UnsolvedGrasp{time_s, control};
  }
  if (control.grasp != GraspStatus::kOptimal && !unsolved_grasp_) {
    unsolved_grasp_ = UnsolvedGrasp{time_s, control};
    if (!unsolved_) unsolved_ = Event{time_s, explain(model_.scene, *unsolved_grasp_)};
  }
  if (const MuscleLack& lack = control.muscle_lack; lack.muscle >= 0) {
    muscles_[lack.muscle].add(time_s, lack.needed_N - model_.scene.hand.muscles[lack.muscle].max_force_N,
                              lack.needed_N);
  } else if (control.muscle != MuscleStatus::kOptimal && !unsolved_) {
    const bool none = control.muscle == MuscleStatus::kInfeasible;
    unsolved_ = Event{time_s, fmt::format("{} at {:.3f} s",
                                          none ? "no muscle forces give the torques wanted"
                                               : "the muscle-force problem found no answer",
                                          time_s)};
  }
  if (control.reflex.event != ReflexEvent::kNone && !(answer_ && answers_a_slip())) {
    answer_ = Answer{time_s, control.reflex, slip_m_};
  }
  if (unsolved_) note_trouble();
  if (!model_.scene.has_muscles()) return;
  for (std::size_t m = 0; m < muscles_.size(); ++m) {
    const double force_N = muscle_forces_N[static_cast<Eigen::Index>(m)];
    muscles_[m].add(time_s, force_N - model_.scene.hand.muscles[m].max_force_N, force_N);
  }
}

void GraspMonitor::add(const TickRecord& tick, const MuscleVector& pull_N) {
  if (is_closed_) return;
  task_.add(tick);
  watch_solver(tick);
  // Fingers that come and go slip, chatter and hold nothing, as they should.
  if (tick.holds) {
    chatter_.add(tick);
    watch_slip(tick);
    watch_walk(tick);
    watch_grip(tick);
    watch_target(tick);
    watch_swings(tick);
  } else {
    chatter_.pause();
    slip_before_m_ = tick.slip_m;
    walk_before_ = Walk{tick.walk_m, tick.turn_rad};
    rests_since_s_.reset();
    unloaded_s_ = 0.0;
  }
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Joint& joint = model_.scene.hand.joints[i];
    const double q = tick.q_rad[static_cast<Eigen::Index>(i)];
    joints_[i].add(tick.time_s, std::max(q - joint.upper_rad, joint.lower_rad - q) - kStopsWithin_rad, q);
  }
  for (std::size_t m = 0; m < pulls_.size() && pull_N.size() > 0; ++m) {
    const double now_N = pull_N[static_cast<Eigen::Index>(m)];
    pulls_[m].add(tick.time_s, now_N - (1.0 + kPullsOver) * model_.scene.hand.muscles[m].max_force_N, now_N);
  }
  last_s_ = tick.time_s;
  if (unsolved_ || not_finite_ || loss_ || swinging_ || idle_finger_ ||
      std::ranges::any_of(slips_since_s_, [](const auto& since_s) { return since_s.has_value(); }) ||
      std::ranges::any_of(walks_, [](const Walked& walked) { return walked.since_s.has_value(); })) {
    note_trouble();
  }
  is_closed_ = has_ended() && model_.scene.control;
}

void GraspMonitor::watch_solver(const TickRecord& tick) {
  const SolveReport& solve = tick.contact.solve;
  if (!not_finite_ && solve.status == SolveStatus::kNotFinite) {
    not_finite_ = Event{tick.time_s, fmt::format("the contact problem was not finite at {:.3f} s", tick.time_s)};
  }
  // A position that is not a number passes no comparison: it must not pass for one that is near.
  if (!not_finite_ && !(tick.position_m.allFinite() && std::isfinite(tick.rotation_error_rad))) {
    not_finite_ = Event{tick.time_s, fmt::format("the object's pose was not finite at {:.3f} s", tick.time_s)};
  }
  if (tick.contact.contacts == 0 && tick.contact.environment.contacts == 0) return;
  ++ticks_with_contacts_;
  if (!(solve.residual <= kNotConverged)) ++not_converged_;
}

void GraspMonitor::watch_slip(const TickRecord& tick) {
  if (!slip_before_m_) slip_before_m_ = tick.slip_m;
  if (!tick.is_measured()) return;
  // A patch that rolls or turns on the object slides at its rim, and stays where it is.
  for (int k = 0; k < model_.fingers(); ++k) {
    const PatchReport& patch = tick.contact.patch[k];
    if (patch.sliding_share >= kSlidesWhole) {
      slip_m_[k] += patch.slip_m;
      slid_s_[k] = tick.time_s;
    }
    if (!slips_since_s_[k] && slip_m_[k] > kSlipping_m) slips_since_s_[k] = tick.time_s;
  }
}

/// A patch that turns and slides in turns, part by part, gets on though it never slides as a whole. A scene that names
/// how far is lost lets it.
void GraspMonitor::watch_walk(const TickRecord& tick) {
  if (!walk_before_) walk_before_ = Walk{tick.walk_m, tick.turn_rad};
  if (model_.scene.task.lost_m) return;
  for (int k = 0; k < model_.fingers(); ++k) {
    Walked& walked = walks_[k];
    const double way_m = (tick.walk_m[k] - walk_before_->walk_m[k]).norm();
    if (!(way_m > std::max(kWalks * model_.scene.hand.fingertips[k].radius_m, walked.way_m))) continue;
    if (!walked.since_s) walked.since_s = tick.time_s;
    walked.way_m = way_m;
    walked.turn_rad = std::abs(tick.turn_rad[k] - walk_before_->turn_rad[k]);
  }
}

void GraspMonitor::watch_grip(const TickRecord& tick) {
  holders_ = static_cast<int>(
      std::count_if(tick.force.begin(), tick.force.end(), [](const auto& f) { return f.normal_N > 0.0; }));
  const bool built_up = tick.is_from(kLoadedFrom_s), is_open = built_up && holders_ < 2;
  const bool is_carried = tick.contact.environment.normal_N > 0.0;
  // What lies on a table is not lost, though no finger holds it.
  unloaded_s_ = is_open && !is_carried ? unloaded_s_ + model_.scene.step_s : 0.0;
  if (!is_open || unloaded_s_ > kUnloaded_s) rests_since_s_.reset();
  if (is_open && is_carried && !rests_since_s_) rests_since_s_ = tick.time_s;
  // Nobody asks fingers to carry load that no controller moves.
  for (int k = 0; k < model_.fingers() && built_up && model_.scene.control && !idle_finger_; ++k) {
    if (tick.force[k].normal_N > 0.0) continue;
    idle_finger_ = Event{tick.time_s, fmt::format("the {} carried no load at {:.3f} s",
                                                  model_.scene.hand.fingertips[k].finger, tick.time_s)};
  }
  // What a spring carries, the hand cannot lose.
  if (loss_ || model_.scene.task.spring) return;
  const auto why = [&] {
    const std::string resists = task_.resistance();
    return resists.empty() ? "" : ", while " + resists;
  };
  if (unloaded_s_ > kUnloaded_s) {
    loss_ = Event{tick.time_s, fmt::format("at {:.3f} s fewer than two fingers had carried load for {:.0f} ms{}",
                                           tick.time_s, 1e3 * kUnloaded_s, why())};
    return;
  }
  for (int k = 0; k < model_.fingers(); ++k) {
    const Fingertip& tip = model_.scene.hand.fingertips[k];
    const auto& lost_m = model_.scene.task.lost_m;
    if (tick.slip_m[k] - (*slip_before_m_)[k] <= lost_m.value_or(tip.radius_m)) continue;
    loss_ = Event{tick.time_s,
                  fmt::format("at {:.3f} s the {} had slid by more than {}, {:g} mm{}", tick.time_s, tip.finger,
                              lost_m ? "task.lost" : "its pulp's radius", 1e3 * lost_m.value_or(tip.radius_m), why())};
    return;
  }
}

void GraspMonitor::watch_target(const TickRecord& tick) {
  if (!model_.scene.control) return;
  const double off_m = (tick.position_m - tick.target_m).norm();
  off_m_.add(tick.time_s, off_m - kOffTarget_m, off_m);
  off_rad_.add(tick.time_s, tick.rotation_error_rad - kOffTarget_rad, tick.rotation_error_rad);
}

void GraspMonitor::watch_swings(const TickRecord& tick) {
  if (!model_.scene.control || swinging_ || loss_) return;
  const auto swing = swings_.add(tick.position_m - tick.target_m, tick.rotation_error_rad);
  if (!swing) return;
  // Something else may swing it: what pushes it, a hand that pulls it in the window.
  if (loop_in_words().empty()) return;
  const std::string size = swing->turns ? fmt::format("{:.2g} degrees", kDegrees * swing->size)
                                        : fmt::format("{:.2g} mm", 1e3 * swing->size);
  swinging_ = Event{tick.time_s, fmt::format("the object swung about its target, wider each time, by {} at {:.3f} s",
                                             size, tick.time_s)};
}

/// Of a grip that builds up: whether its loop has run away from what the fingers bear.
std::string GraspMonitor::grip_in_words() const {
  const bool asked = solved_ && solved_->control.has_forces && unsolved_grasp_->time_s < kMeasuredFrom_s;
  return asked ? runaway_in_words(model_, solved_->control, solved_->time_s) : "";
}

/// Of the phase that goes on.
const std::string& GraspMonitor::loop_in_words() const {
  const int phase = task_.phase();
  if (!loop_ || loop_phase_ != phase) {
    loop_ = model_.scene.control ? trouble_in_words(model_, loop_margin(model_, PoseLoop(model_), phase)) : "";
    loop_phase_ = phase;
  }
  return *loop_;
}

/// Forces of a finger that slides off are unsteady, too: what counts is how they were before.
void GraspMonitor::note_trouble() {
  if (trouble_s_) return;
  trouble_s_ = last_s_;
  chatter_before_ = chatter_.now();
}

std::optional<std::string> GraspMonitor::contact_failure() const {
  if (not_finite_) return not_finite_->what;
  const double share = static_cast<double>(not_converged_) / static_cast<double>(ticks_with_contacts_);
  if (!(share > kMostUnsolved)) return std::nullopt;
  return fmt::format("the contact solver did not converge: a residual above {:g} in {:.0f} % of the ticks",
                     kNotConverged, 100.0 * share);
}

std::string GraspMonitor::chatter_in_words() const {
  const double share = trouble_s_ ? chatter_before_ : chatter_.now();
  if (!(share > (trouble_s_ ? 2.0 : 1.0) * kChatters)) return "";
  return fmt::format("forces chatter by {:.0f} %", 100.0 * std::min(share, 1.0));
}

std::string GraspMonitor::slips_in_words() const {
  std::string all;
  for (int k = 0; k < model_.fingers(); ++k) {
    // A scene that names how far is lost lets a finger slip less, once it sticks again.
    const bool rests = slid_s_[k] < last_s_ - kRests_s;
    if (!slips_since_s_[k] || (model_.scene.task.lost_m && rests && !loss_)) continue;
    all += fmt::format("{}the {} slipped {:.2f} mm from {:.3f} s on", all.empty() ? "" : ", ",
                       model_.scene.hand.fingertips[k].finger, 1e3 * slip_m_[k], *slips_since_s_[k]);
    if (model_.scene.control && model_.scene.control->reflex) all += answer_in_words(k);
  }
  for (int k = 0; k < model_.fingers(); ++k) {
    const Walked& walked = walks_[k];
    if (!walked.since_s || slips_since_s_[k]) continue;
    all += fmt::format("{}the {}'s patch walked {:.2f} mm net and turned by {:.0f} degrees, in turns, from {:.3f} s on",
                       all.empty() ? "" : ", ", model_.scene.hand.fingertips[k].finger, 1e3 * walked.way_m,
                       kDegrees * walked.turn_rad, *walked.since_s);
  }
  if (idle_finger_) all += (all.empty() ? "" : ", ") + idle_finger_->what;
  return all;
}

std::string GraspMonitor::rest_in_words() const {
  if (!rests_since_s_ || last_s_ - *rests_since_s_ < kUnloaded_s) return "";
  return fmt::format("from {:.3f} s on the object rests on its environment, and {} holds it", *rests_since_s_,
                     holders_ == 0 ? "no finger" : "one finger alone");
}

bool GraspMonitor::answers_a_slip() const {
  const double delay_s = model_.scene.fingertips->touch->delay_s;
  return std::ranges::any_of(slips_since_s_,
                             [&](const auto& since_s) { return since_s && answer_->time_s >= *since_s - delay_s; });
}

/// What of the slip was before the grip rose, and why it rose so late.
std::string GraspMonitor::answer_in_words(int k) const {
  const double delay_s = model_.scene.fingertips->touch->delay_s;
  if (!answer_ || answer_->time_s < *slips_since_s_[k] - delay_s) {
    return fmt::format(", before the grip could rise: {:g} ms of latency", 1e3 * delay_s);
  }
  const std::string against = answer_->reflex.event == ReflexEvent::kLoad
                                  ? fmt::format("{:.3g} N/s", answer_->reflex.rate_N_per_s)
                                  : fmt::format("a friction of {:.2g}", answer_->reflex.friction[k]);
  return fmt::format(", {:.2f} mm of it before the grip rose: {:g} ms of latency against {}", 1e3 * answer_->slip_m[k],
                     1e3 * delay_s, against);
}

std::string GraspMonitor::way_off_in_words() const {
  std::string all;
  if (off_m_.first_s) {
    all = fmt::format("the object was {:.1f} mm off its target at {:.3f} s (more than {:g} mm from {:.3f} s on)",
                      1e3 * off_m_.value, off_m_.at_s, 1e3 * kOffTarget_m, *off_m_.first_s);
  }
  if (off_rad_.first_s) {
    all += fmt::format(
        "{}the object was turned {:.0f} degrees off its target at {:.3f} s (more than {:g} from {:.3f} s on)",
        all.empty() ? "" : ", ", kDegrees * off_rad_.value, off_rad_.at_s, kDegrees * kOffTarget_rad,
        *off_rad_.first_s);
  }
  return all;
}

std::vector<Excess> GraspMonitor::beyond() const {
  std::vector<Excess> all;
  for (std::size_t m = 0; m < muscles_.size(); ++m) {
    const Muscle& muscle = model_.scene.hand.muscles[m];
    for (const Worst* worst : {&muscles_[m], m < pulls_.size() ? &pulls_[m] : nullptr}) {
      if (worst == nullptr || !worst->first_s) continue;
      all.push_back(
          {muscle.name, true, worst != &muscles_[m], muscle.max_force_N, worst->value, worst->at_s, *worst->first_s});
    }
  }
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Joint& joint = model_.scene.hand.joints[i];
    const Worst& worst = joints_[i];
    if (!worst.first_s) continue;
    const double limit = worst.value > joint.upper_rad ? joint.upper_rad : joint.lower_rad;
    all.push_back({joint.name, false, false, limit, worst.value, worst.at_s, *worst.first_s});
  }
  return all;
}

Verdict GraspMonitor::verdict() const {
  Verdict verdict;
  verdict.beyond = beyond();
  verdict.force_chatter = chatter_.now();
  if (loss_) verdict.lost_s = loss_->time_s;

  // The gravest first. Forces that cannot be found because a finger slid or forces chattered are not the solver's
  // fault.
  std::vector<std::pair<Outcome, std::string>> found;
  const auto add = [&](Outcome outcome, std::string what) {
    if (!what.empty()) found.emplace_back(outcome, std::move(what));
  };
  const std::string chatter = chatter_in_words();
  const bool cause = unsolved_ && chatter.empty() && *trouble_s_ >= unsolved_->time_s - 1e-9;
  add(Outcome::kSolverFailed, contact_failure().value_or(""));
  // A loop beyond its limit swings, chatters and asks for forces that no cones hold; what is lost by that is lost by
  // it.
  const bool lacks_forces = unsolved_grasp_ && unsolved_grasp_->time_s > 0.0 &&
                            apart_in_words(model_.scene, unsolved_grasp_->control).empty();
  if (swinging_ || !chatter.empty() || lacks_forces) add(Outcome::kUnstable, loop_in_words());
  const bool loops = !found.empty() && found.back().first == Outcome::kUnstable;
  if (lacks_forces && found.empty()) add(Outcome::kUnstable, grip_in_words());
  if (cause) add(Outcome::kSolverFailed, loops && lacks_forces ? what_failed(*unsolved_grasp_) : unsolved_->what);
  if (swinging_) add(Outcome::kUnstable, swinging_->what);
  if (loss_) add(Outcome::kLost, loss_->what);
  add(Outcome::kUnstable, chatter);
  add(Outcome::kTaskFailed, task_.failure(is_over_ && !loss_));
  add(Outcome::kResting, rest_in_words());
  add(Outcome::kSlipping, slips_in_words());
  add(Outcome::kOffTarget, way_off_in_words());
  add(Outcome::kOverLimits, limits_in_words(verdict.beyond));
  // What was lacking while the grip built up counts if no stiffness was chosen for long after it.
  if (too_soft_ && (too_soft_->time_s >= kMeasuredFrom_s || chosen_s_ - too_soft_->time_s < kStillSoft_s)) {
    add(Outcome::kOverLimits, too_soft_->what);
  }
  if (unsolved_ && !cause) {
    add(Outcome::kSolverFailed, loops && lacks_forces ? what_failed(*unsolved_grasp_) : unsolved_->what);
  }
  add(Outcome::kUnknown, missed_);
  if (found.empty() && task_.is_done()) verdict.outcome = Outcome::kTaskDone;
  if (found.empty()) return verdict;
  verdict.outcome = found.front().first;
  for (const auto& [outcome, what] : found) verdict.reason += (verdict.reason.empty() ? "" : "; ") + what;
  return verdict;
}

}  // namespace thenar
