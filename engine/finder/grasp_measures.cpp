// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/grasp_measures.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace thenar {

namespace {

template <auto Member>
double of_grasp(const FoundGrasp& grasp) {
  return grasp.*Member;
}

double least_press_N(const FoundGrasp& grasp) {
  double least_N = std::numeric_limits<double>::infinity();
  for (const FingerPlace& place : grasp.places) least_N = std::min(least_N, press_N(grasp, place));
  return least_N;
}

double least_patch(const FoundGrasp& grasp) {
  double least = 1.0;
  for (const FingerPlace& place : grasp.places) least = std::min(least, place.patch);
  return least;
}

bool has_muscles(const FoundGrasp& grasp) { return grasp.muscle_share > 0.0; }

constexpr double kDegrees = 180.0 / std::numbers::pi;

constexpr std::array<GraspMeasure, 10> kMeasures = {
    {{"width_m", "m", "width", "mm", 1e3, 1,
      "The distance from the finger that faces the others to the middle of their places.",
      of_grasp<&FoundGrasp::width_m>},
     {"press_N", "N", "press", "N", 1.0, 2,
      "The normal load of the least loaded finger, while the hand holds the weight.", least_press_N},
     {"margin", "", "margin", "", 1.0, 2,
      "The least share of a friction cone that is left, of all fingers, with the weight in any direction, a push of "
      "0.5 N along it and a turn of 10 mN m: 0 slips, 1 has no tangential force at all.",
      of_grasp<&FoundGrasp::margin>},
     {"needed_friction", "", "needed friction", "", 1.0, 2,
      "The friction that suffices for the scene's weight with the torsion of the patches, at rest in the trial.",
      of_grasp<&FoundGrasp::needed_friction>},
     {"limit_rad", "rad", "limit", "deg", kDegrees, 0, "The least distance of a joint from an end of its range.",
      of_grasp<&FoundGrasp::limit_rad>},
     {"muscle_share", "", "effort", "%", 100.0, 0,
      "The largest force of a muscle as a share of its limit, under the weight as it is and with a push of 0.5 N in "
      "any direction; without muscles 0, and null in messages.",
      of_grasp<&FoundGrasp::muscle_share>, has_muscles},
     {"torque_Nm", "N m", "effort", "N m", 1.0, 3,
      "The largest torque of a joint under the weight as it is; the effort of hands without muscles.",
      of_grasp<&FoundGrasp::torque_Nm>},
     {"patch", "", "patch", "", 1.0, 2,
      "The least share of a pressed pulp's patch that lies on the surface: less than 1 over an edge or a hole.",
      least_patch},
     {"travel_m", "m", "travel", "mm", 1e3, 0,
      "How far the fingers carry the object in the direction in which they carry it best, at most 25 mm.",
      of_grasp<&FoundGrasp::travel_m>},
     {"cost", "", "", "", 1.0, 2,
      "The number by which the search ranks grasps: it weighs margin, friction, limits, effort, patches and travel.",
      of_grasp<&FoundGrasp::cost>}}};

}  // namespace

std::span<const GraspMeasure> grasp_measures() { return kMeasures; }

const GraspMeasure& grasp_measure(std::string_view name) {
  const auto* const found = std::ranges::find(kMeasures, name, &GraspMeasure::name);
  if (found == kMeasures.end()) throw std::out_of_range("a grasp has no measure " + std::string(name));
  return *found;
}

double press_N(const FoundGrasp& grasp, const FingerPlace& place) {
  return -(grasp.X_WO.linear() * place.normal_O).dot(place.force_W);
}

}  // namespace thenar
