// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/scene_problems.h"

#include <cmath>
#include <variant>

#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "engine/problems/problem_dump.h"
#include "engine/scenes/scene_file.h"

namespace thenar {
namespace {

using Eigen::Index;

FactoredContacts copy_of(const GroupedDelassus& W) {
  FactoredContacts factors;
  factors.begin.assign(W.begin.begin(), W.begin.end());
  factors.J_own = W.J_own.topRows(3 * W.contacts());
  if (W.J_fifth.size() > 0) factors.J_fifth = W.J_fifth.head(3 * W.contacts());
  factors.J_common = W.J_common.topRows(3 * W.contacts());
  factors.own_mobility = W.own_mobility;
  factors.common_mobility = W.common_mobility;
  factors.compliance.assign(W.compliance.begin(), W.compliance.end());
  if (!W.compliance.empty()) factors.axes = W.axes.topRows(3 * W.contacts());
  factors.compliance_scale = W.compliance_scale;
  return factors;
}

}  // namespace

SceneProblems scene_problems(const std::string& scene, const std::vector<std::string>& changes,
                             const Moments& moments) {
  const Model model = build_model(load_scene(std::string(THENAR_CONFIGS "/") + scene + ".yaml", changes));
  SceneProblems problems;
  const double every_s = (moments.to_s - moments.from_s) / moments.count;
  GraspRun run(model, LockstepSettings{});
  for (int taken = 0; taken < moments.count;) {
    const double now_s = run.time_s();
    (void)run.tick();
    if (now_s < moments.from_s + taken * every_s || !run.controlled) continue;
    ++taken;
    const ContactScratch& work = run.work;
    problems.contacts.push_back({contact_problem_file(model, run.frame, work),
                                 copy_of(delassus_operator(model, run.frame, work.kinematics, work.mobility))});
    if (!model.scene.control) continue;
    problems.grasps.push_back(grasp_problem_file(model.scene, run.report));
    if (model.scene.control->muscles) {
      const MusclesFile solved = muscle_problem_file(run.controller, run.report);
      if (const auto* const least = std::get_if<MuscleFile>(&solved)) problems.muscles.push_back(*least);
    }
  }
  return problems;
}

}  // namespace thenar
