// SPDX-License-Identifier: Apache-2.0
#include "engine/environment/room_for.h"

#include <algorithm>
#include <vector>

#include "engine/environment/environment_contacts.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr int kMostMoves = 50;
constexpr double kMoves_m_per_N = 1e-2, kTurns_rad_per_Nm = 1e2;  // Far more than contacts deform.

Overlap::Place place_of(const EnvironmentContact& contact) {
  return {static_cast<std::size_t>(contact.body), contact.at.p_m};
}

std::size_t deepest(const EnvironmentContacts& contacts) {
  const auto gap_m = [](const EnvironmentContact& contact) { return contact.at.gap_m; };
  return static_cast<std::size_t>(std::ranges::min_element(contacts.found, {}, gap_m) - contacts.found.begin());
}

}  // namespace

std::optional<Overlap> find_overlap(const Environment& environment, const TouchingSolid& object,
                                    const Isometry3d& X_WO) {
  const double most_m = std::max(kMostOverlap_m, kMostOverlap_N * environment.compliance_m_per_N);
  EnvironmentContacts contacts(environment, object);
  const auto look = [&](const Isometry3d& X) {
    find_environment_contacts(environment, X, 0.0, 0.0, 0.0, {}, contacts);
    for (GroundContact& contact : contacts.contacts) contact.mu = 0.0;
  };
  const auto is_free = [&] { return contacts.found.empty() || contacts.found[deepest(contacts)].at.gap_m >= -most_m; };
  look(X_WO);
  if (is_free()) return std::nullopt;
  const EnvironmentContact& first = contacts.found[deepest(contacts)];
  const Overlap lies{place_of(first), -first.at.gap_m, std::nullopt};

  GroundWorkspace work(static_cast<Eigen::Index>(contacts.most()));
  GroundProblem::Motion mobility;
  mobility << Vector3d::Constant(kMoves_m_per_N), Vector3d::Constant(kTurns_rad_per_Nm);
  Isometry3d X = X_WO;
  for (int k = 0; k < kMostMoves; ++k) {
    const GroundProblem problem{contacts.contacts, environment.compliance_m_per_N, mobility};
    work.x.setZero();
    static_cast<void>(solve_ground(problem, GroundProblem::Motion::Zero(), work));
    X = moved(X, work.x);
    look(X);
    if (is_free()) return lies;
  }
  // The deepest, and the one that presses most against it.
  const std::size_t one = deepest(contacts);
  const auto normal = [&](std::size_t i) -> Vector3d { return contacts.contacts[i].J.row(0).head<3>(); };
  std::size_t other = one;
  double against_most_m = 0.0;
  for (std::size_t i = 0; i < contacts.found.size(); ++i) {
    const double against_m = contacts.found[i].at.gap_m * normal(i).dot(normal(one));
    if (against_m > against_most_m) {
      other = i;
      against_most_m = against_m;
    }
  }
  if (other == one) return lies;
  const EnvironmentContact &a = contacts.found[one], &b = contacts.found[other];
  return Overlap{place_of(a), -a.at.gap_m - b.at.gap_m, place_of(b)};
}

}  // namespace thenar
