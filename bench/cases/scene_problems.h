// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bench/cases/factored_contacts.h"
#include "engine/formats/problem_file.h"

namespace thenar {

/// A contact problem of a run, its operator in factors, too.
struct SceneContacts {
  ContactFile file;
  FactoredContacts factors;
};

/// What the three solvers are given in a run of a scene.
struct SceneProblems {
  std::vector<SceneContacts> contacts;
  std::vector<GraspFile> grasps;  ///< None of a scene without control.
  std::vector<MuscleFile> muscles;
};

/// When to look, in the run's time.
struct Moments {
  double from_s, to_s;
  int count;
};

/// Runs configs/<scene>.yaml with changes, on the virtual clock, and takes its problems at moments evenly spread.
[[nodiscard]] SceneProblems scene_problems(const std::string& scene, const std::vector<std::string>& changes,
                                           const Moments& moments);

}  // namespace thenar
