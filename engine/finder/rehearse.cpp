// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/rehearse.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "engine/control/control_tick.h"
#include "engine/finder/carry.h"
#include "engine/finder/effort.h"
#include "engine/grasp/contact_tick.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

constexpr double kStep_s = 2e-3, kFineStep_s = 4e-3;  // Contacts of fine parts take several times as long to find.
constexpr double kRest_s = 0.06, kCarry_s = 0.8, kOnePush_s = 0.06;
constexpr double kMostTask_s = 4.0;
constexpr int kPushes = 6;
constexpr double kTolerance = 1e-5;
constexpr int kSweeps = 50;
constexpr double kMostShare = 3.0;  // Largest share of a muscle's limit.

bool has_task(const TaskSettings& task) { return task.translate || task.rotate || task.push; }

/// Returns the push at a time, of a sequence along the object's axes.
std::optional<Push> push_at(const Scene& scene, double time_s) {
  const int number = static_cast<int>(std::floor((time_s - 2.0 * kRest_s - kCarry_s) / kOnePush_s));
  if (number < 0 || number >= kPushes) return std::nullopt;
  Push push{.from_s = 0.0, .over_s = 1e9, .at_m = scene.object.centre_of_mass_m};
  push.force_N[number / 2] = number % 2 == 0 ? kPush_N : -kPush_N;
  return push;
}

double muscle_share(const Hand& hand, const Controller& controller) {
  double share = 0.0;
  for (Eigen::Index m = 0; m < controller.f_muscle.size(); ++m) {
    share = std::max(share, controller.f_muscle[m] / std::max(1e-9, hand.muscles[m].max_force_N));
  }
  return share;
}

/// The muscles that were too weak, with the most that each would have had to pull when they began to be: what they do
/// not hold moves away, and then other muscles are asked for forces without bounds. A lack that ends is forgotten.
class WeaknessWatch {
 public:
  void see(const ControlReport& control, double time_s) {
    constexpr double kSoon_s = 0.02, kEnd_s = 0.05;
    const MuscleLack& lack = control.muscle_lack;
    if (lack.muscle < 0 && control.muscle != MuscleStatus::kInfeasible) return;
    if (time_s - last_s_ > kEnd_s) {
      needed_N_.clear();
      none_ = false;
      first_s_ = time_s;
    }
    last_s_ = time_s;
    if (time_s - first_s_ > kSoon_s) return;
    if (lack.muscle >= 0) {
      double& needed_N = needed_N_[lack.muscle];
      needed_N = std::max(needed_N, lack.needed_N);
    } else {
      none_ = true;
    }
  }

  /// Describes the muscles that lack most, worst first.
  [[nodiscard]] std::string in_words(const Hand& hand) const {
    constexpr std::size_t kMost = 3;
    std::vector<std::pair<double, int>> worst;
    const auto limit_N = [&](int muscle) { return hand.muscles[static_cast<std::size_t>(muscle)].max_force_N; };
    for (const auto& [muscle, needed_N] : needed_N_) worst.emplace_back(limit_N(muscle) - needed_N, muscle);
    std::sort(worst.begin(), worst.end());
    if (worst.size() > kMost) worst.resize(kMost);
    std::ostringstream text;
    text.precision(3);
    for (const auto& [left_N, muscle] : worst) {
      text << (text.view().empty() ? "" : ", ") << hand.muscles[static_cast<std::size_t>(muscle)].name
           << " would have to pull with at least " << limit_N(muscle) - left_N << " N, " << -left_N
           << " N beyond its limit";
    }
    if (none_ && worst.empty()) text << "no muscle forces give the torques";
    return text.str();
  }

 private:
  std::map<int, double> needed_N_;
  bool none_ = false;
  double first_s_ = -1.0, last_s_ = -1.0;
};

/// The slip of patches that slid as a whole.
class SlideWatch {
 public:
  explicit SlideWatch(const Model& model) : model_(model), slid_m_(model.fingers()) {}

  /// Describes the excessive slip, if any.
  std::string see(const TickReport& tick) {
    constexpr double kMost_m = 0.1e-3;
    for (int k = 0; k < model_.fingers(); ++k) {
      if (tick.patch[k].sliding_share > 0.99) slid_m_[k] += tick.patch[k].slip_m;
      if (slid_m_[k] > kMost_m) return "the " + model_.scene.hand.fingertips[k].finger + " slides";
    }
    return {};
  }

 private:
  const Model& model_;
  PerFinger<double> slid_m_;
};

/// Returns the friction that would just hold the patches with their forces.
double needed_friction(const Model& model, const TickReport& tick) {
  double needed = 0.0;
  for (int k = 0; k < model.fingers(); ++k) {
    needed = std::max(needed, model.scene.contact.friction * (1.0 - tick.patch[k].margin));
  }
  return needed;
}

Rehearsal run(const Model& model, Scene& scene, int ticks, bool own_task) {
  const int rested = std::min(ticks, static_cast<int>(std::lround(kRest_s / scene.step_s))) - 1;
  State state(model);
  Controller controller(model);
  Frame frame(model);
  ContactMemory memory(model);
  ContactScratch work(model);
  SlideWatch slides(model);
  WeaknessWatch weak;
  Rehearsal rehearsal;
  if (scene.control) rehearsal.reserve = std::max(0.0, 1.0 - scene.control->grasp_friction / scene.contact.friction);
  for (int t = 0; t < ticks; ++t) {
    if (!own_task) scene.task.push = push_at(scene, t * scene.step_s);
    const ControlReport control = control_tick(model, state, controller, frame);
    if (scene.has_muscles()) weak.see(control, t * scene.step_s);
    const TickReport tick = contact_tick(model, frame, memory, work, state);
    if (t == rested) rehearsal.needed_friction = needed_friction(model, tick);
    rehearsal.trouble = slides.see(tick);
    if (scene.control && control.grasp != GraspStatus::kOptimal) rehearsal.trouble = "no grasp forces exist";
    rehearsal.muscle_share = std::max(rehearsal.muscle_share, muscle_share(scene.hand, controller));
    if (rehearsal.muscle_share > kMostShare) rehearsal.trouble = "muscles are asked for far more than they can give";
    for (int k = 0; k < model.fingers(); ++k) {
      rehearsal.least_margin = std::min(rehearsal.least_margin, tick.patch[k].margin);
      if (!(state.load[k].normal_N > 0.0)) rehearsal.trouble = "the " + scene.hand.fingertips[k].finger + " lets go";
    }
    if (!rehearsal.trouble.empty()) {
      rehearsal.lasted = static_cast<double>(t) / ticks;
      rehearsal.weakness = weak.in_words(scene.hand);
      return rehearsal;
    }
  }
  rehearsal.lasted = 1.0;
  return rehearsal;
}

}  // namespace

Rehearsal rehearse(Model& model, const FoundGrasp& grasp) {
  Scene& scene = model.scene;
  const Scene kept = scene;
  scene.step_s = scene.control_period_s =
      std::max(model.fine_m.cols() > 0 ? kFineStep_s : kStep_s, scene.control_period_s);
  scene.control_delay_s = 0.0;
  scene.contact.tolerance = std::max(scene.contact.tolerance, kTolerance);
  scene.contact.max_sweeps = std::min(scene.contact.max_sweeps, kSweeps);
  scene.task.phases.clear();  // The grasp is tested, not the approach.
  const bool own_task = has_task(scene.task);
  double duration_s = std::min(scene.duration_s, kMostTask_s);
  if (!own_task && !scene.control) {
    duration_s = 2.0 * kRest_s;  // Constant torques hold it: they carry it nowhere.
  } else if (!own_task) {
    duration_s = 2.0 * kRest_s + kCarry_s + kPushes * kOnePush_s;
    scene.task.translate = Move{scene.object.X_WO.linear().transpose() * grasp.travel_W, kCarry_m, kRest_s, kCarry_s};
  }
  const Rehearsal rehearsal = run(model, scene, static_cast<int>(std::ceil(duration_s / scene.step_s)), own_task);
  scene = kept;
  return rehearsal;
}

}  // namespace thenar
