// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/contact_gaps.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "engine/grasp/local_torus.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

ContactGaps contact_gaps(std::span<const FrameContact> contacts, const Isometry3d& X_FO, const State& state,
                         const lanes::Vector& u_O) {
  assert(!contacts.empty() && std::ssize(contacts) <= lanes::kLanes);
  const int last = static_cast<int>(std::ssize(contacts)) - 1;
  const std::array<const FrameContact*, lanes::kLanes> of = {&contacts[0], &contacts[std::min(1, last)],
                                                             &contacts[std::min(2, last)], &contacts[last]};
  const auto vectors = [&](Vector3d FrameContact::*part) {
    return lanes::gather([&](int lane) -> const Vector3d& { return of[lane]->*part; });
  };
  ContactGaps gaps;
  gaps.u_F = lanes::gather([&](int lane) { return displacement(state, *of[lane]); });
  const lanes::Vector p_F = vectors(&FrameContact::p_F), s_O = vectors(&FrameContact::s_O);
  LocalTorus<lanes::Numbers> torus;
  torus.n = vectors(&FrameContact::n_O);
  // From the finger point to the surface point.
  lanes::Vector to_surface_O;
  for (int r = 0; r < 3; ++r) to_surface_O[r] = p_F[r] - gaps.u_F[r] - X_FO.translation()[r];
  to_surface_O = lanes::product(X_FO.linear().transpose(), to_surface_O);
  for (int r = 0; r < 3; ++r) to_surface_O[r] = s_O[r] + u_O[r] - to_surface_O[r];
  // A ring is curved less than its tube: without that it is a plane.
  if (std::ranges::all_of(of, [](const FrameContact* contact) { return contact->curvature_per_m == 0.0; })) {
    gaps.gap_m = lanes::dot(torus.n, to_surface_O);
    gaps.n_F = lanes::product(X_FO.linear(), torus.n);
  } else {
    torus.t = vectors(&FrameContact::t_O);
    torus.tube_per_m = lanes::gather_numbers([&](int lane) { return of[lane]->curvature_per_m; });
    torus.ring_per_m = lanes::gather_numbers([&](int lane) { return of[lane]->ring_curvature_per_m; });
    const TorusGap<lanes::Numbers> over = gap_to(torus, to_surface_O);
    gaps.gap_m = over.gap_m;
    gaps.n_F = lanes::product(X_FO.linear(), over.n);
  }
  for (int lane = 0; lane <= last; ++lane) {
    if (!contacts[lane].fades()) continue;
    const ContactGap gap = contact_gap(contacts[lane], X_FO, lanes::get(gaps.u_F, lane), lanes::get(u_O, lane));
    gaps.gap_m[lane] = gap.gap_m;
    lanes::set(gaps.n_F, lane, gap.n_F);
  }
  return gaps;
}

}  // namespace thenar
