#include "engine/environment/room_for.h"

#include <algorithm>
#include <vector>

#include "engine/environment/environment_contacts.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr int kMostMoves = 50;
constexpr double kMoves_m_per_N = 1e-2, kTurns_rad_per_Nm = 1e2;  // Far more than bodies give way.

/// The body of contact i.
std::size_t body_of(const EnvironmentContacts& contacts, std::size_t i) {
  return static_cast<std::size_t>(std::upper_bound(contacts.end.begin(), contacts.end.end(), i) - contacts.end.begin());
}

Overlap::Place place_of(const EnvironmentContacts& contacts, std::size_t i) {
  return {body_of(contacts, i), contacts.found[i].p_m};
}

std::size_t deepest(const EnvironmentContacts& contacts) {
  const auto least = std::ranges::min_element(contacts.found, {}, &SolidContact::gap_m);
  return static_cast<std::size_t>(least - contacts.found.begin());
}

}  // namespace

std::optional<Overlap> find_overlap(const Environment& environment, const Solid& object, const Isometry3d& X_WO) {
  const double most_m = std::max(kMostOverlap_m, kMostOverlap_N * environment.compliance_m_per_N);
  EnvironmentContacts contacts(environment, object);
  const auto look = [&](const Isometry3d& X) {
    find_environment_contacts(environment, X, 0.0, 0.0, 0.0, {}, contacts);
    for (GroundContact& contact : contacts.contacts) contact.mu = 0.0;
  };
  look(X_WO);
  if (contacts.found.empty() || contacts.found[deepest(contacts)].gap_m >= -most_m) return std::nullopt;
  const std::size_t first = deepest(contacts);
  const Overlap lies{place_of(contacts, first), -contacts.found[first].gap_m, std::nullopt};

  GroundWorkspace work(static_cast<Eigen::Index>(contacts.most()));
  GroundProblem::Motion mobility;
  mobility << Vector3d::Constant(kMoves_m_per_N), Vector3d::Constant(kTurns_rad_per_Nm);
  Isometry3d X = X_WO;
  for (int k = 0; k < kMostMoves; ++k) {
    const GroundProblem problem{contacts.contacts, environment.compliance_m_per_N, mobility};
    work.x.setZero();
    static_cast<void>(solve_ground(problem, GroundProblem::Motion::Zero(), work));
    X.translation() += work.x.head<3>();
    const Vector3d turn = work.x.tail<3>();
    if (turn.norm() > 0.0) X.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * X.linear();
    look(X);
    if (contacts.found.empty() || contacts.found[deepest(contacts)].gap_m >= -most_m) return lies;
  }
  // The deepest, and the one that presses most against it.
  const std::size_t one = deepest(contacts);
  std::size_t other = one;
  double against_most_m = 0.0;
  for (std::size_t i = 0; i < contacts.found.size(); ++i) {
    const double against_m = contacts.found[i].gap_m * contacts.E_W[i].col(0).dot(contacts.E_W[one].col(0));
    if (against_m > against_most_m) {
      other = i;
      against_most_m = against_m;
    }
  }
  if (other == one) return lies;
  return Overlap{place_of(contacts, one), -contacts.found[one].gap_m - contacts.found[other].gap_m,
                 place_of(contacts, other)};
}

}  // namespace thenar
