// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "collision/solids/solid_contacts.h"

namespace thenar::solids_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
// Coordinates of some centimetres have a rounding of 1e-17 m; the bar for a fit of 50 um is 1e-9 m.
constexpr double kRounding_m = 1e-15;

const HoleShape kHole{10e-3, 30e-3, 1e-3};

Foot foot_at(const Solid& solid, int facet, const Vector3d& x) {
  const auto at = foot(solid, facet, x);
  EXPECT_TRUE(at.has_value());
  return at.value_or(Foot{});
}

void expect_foot(const Foot& at, double gap_m, const Vector3d& normal) {
  EXPECT_NEAR(at.gap_m, gap_m, kRounding_m);
  EXPECT_LT((at.normal - normal).norm(), 1e-13);
}

TEST(Solid, GapsOfAHoleAreThoseOfItsPlateChamferBoreFloorAndEdges) {
  const double s = std::sqrt(0.5);
  enum { kPlate, kWall, kFloor };
  expect_foot(foot_at(kHole, kPlate, {15e-3, 0.0, 2e-3}), 2e-3, {0.0, 0.0, 1.0});
  // The middle of the chamfer is (10.5, -0.5) mm; from there 0.3 mm out.
  expect_foot(foot_at(kHole, kWall, {0.0, 10.5e-3 - 0.3e-3 * s, -0.5e-3 + 0.3e-3 * s}), 0.3e-3, {0.0, -s, s});
  expect_foot(foot_at(kHole, kWall, {-9.9e-3, 0.0, -20e-3}), 0.1e-3, {1.0, 0.0, 0.0});
  expect_foot(foot_at(kHole, kWall, {-10.02e-3, 0.0, -20e-3}), -0.02e-3, {1.0, 0.0, 0.0});
  expect_foot(foot_at(kHole, kFloor, {3e-3, 2e-3, -29e-3}), 1e-3, {0.0, 0.0, 1.0});
  // Edges: 0.2 mm up from (11, 0) mm between plate and chamfer, and 0.1 mm from (10, -1) mm between chamfer and bore.
  const Vector3d upper = Vector3d(-std::sin(0.3), 0.0, std::cos(0.3)), lower(-std::cos(0.2), 0.0, std::sin(0.2));
  expect_foot(foot_at(kHole, kWall, Vector3d(11e-3, 0.0, 0.0) + 0.2e-3 * upper), 0.2e-3, upper);
  expect_foot(foot_at(kHole, kWall, Vector3d(10e-3, 0.0, -1e-3) + 0.1e-3 * lower), 0.1e-3, lower);
  EXPECT_FALSE(foot(kHole, kPlate, {5e-3, 0.0, 1e-3}));
  EXPECT_FALSE(foot(kHole, kWall, {15e-3, 0.0, 1e-3}));
  // A peg that has gone 0.1 um into the bore's wall, half a millimetre below a sharp mouth, is not under the plate.
  const HoleShape sharp{10e-3, 30e-3, 0.0};
  expect_foot(foot_at(sharp, kWall, {10.0001e-3, 0.0, -0.5e-3}), -1e-7, {-1.0, 0.0, 0.0});
  EXPECT_FALSE(foot(sharp, kPlate, {10.0001e-3, 0.0, -0.5e-3}));
}

/// The surface of a solid that is nowhere nearer than its foot says: x - gap n is on it, n is along x - foot, and no
/// place in a random direction from the foot is nearer.
TEST(Solid, AFootIsTheNearestPointOfTheSurface) {
  const std::vector<Solid> solids{HalfSpace{}, BoxShape{{20e-3, 30e-3, 40e-3}}, SphereShape{12e-3},
                                  CylinderShape{10e-3, 30e-3}, kHole};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place_m(-40e-3, 40e-3);
  std::normal_distribution<double> step_m(0.0, 1e-3);
  for (std::size_t k = 0; k < solids.size(); ++k) {
    for (int trial = 0; trial < 3000; ++trial) {
      const Vector3d x(place_m(random), place_m(random), place_m(random));
      double least_m = 1.0;
      Vector3d at_least = x;
      for (int facet = 0; facet < facets(solids[k]); ++facet) {
        const auto at = foot(solids[k], facet, x);
        if (!at || std::abs(at->gap_m) >= std::abs(least_m)) continue;
        EXPECT_NEAR(at->normal.norm(), 1.0, 1e-14) << "solid " << k << ", seed 1";
        least_m = at->gap_m;
        at_least = x - at->gap_m * at->normal;
      }
      if (least_m == 1.0 || least_m < 0.0) continue;  // In the solid other sides may be as near.
      // Seen from its own foot the gap is nothing, and from anywhere it grows no faster than the way.
      const auto gap_at = [&](const Vector3d& y) {
        double gap_m = 1.0;
        for (int facet = 0; facet < facets(solids[k]); ++facet) {
          if (const auto at = foot(solids[k], facet, y)) gap_m = std::min(gap_m, std::abs(at->gap_m));
        }
        return gap_m;
      };
      ASSERT_LT(gap_at(at_least), kRounding_m) << "solid " << k << ", trial " << trial << ", seed 1";
      const Vector3d y = x + Vector3d(step_m(random), step_m(random), step_m(random));
      const double gap_m = gap_at(y);
      if (gap_m < 1.0) {
        EXPECT_GE(gap_m, least_m - (y - x).norm() - kRounding_m) << "solid " << k << ", trial " << trial << ", seed 1";
      }
    }
  }
}

std::vector<SolidContact> contacts_of(const Solid& a, const Solid& b, const Isometry3d& X_BA, double band_m) {
  const SolidPair pair(a, b);
  std::vector<SolidContact> contacts;
  contacts.reserve(most_contacts(a, b));
  find_contacts(pair, X_BA, band_m, contacts);
  return contacts;
}

Isometry3d at(const Vector3d& place, const Vector3d& turn = Vector3d::Zero()) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = place;
  if (!turn.isZero(0.0)) X.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  return X;
}

TEST(SolidContacts, ABoxLiesOnATableByFourCornersAndACylinderByItsCircle) {
  const auto box = contacts_of(BoxShape{{60e-3, 40e-3, 20e-3}}, HalfSpace{}, at({0.0, 0.0, 10e-3}), 0.1e-3);
  ASSERT_EQ(box.size(), 4U);
  for (const SolidContact& contact : box) {
    EXPECT_NEAR(contact.gap_m, 0.0, kRounding_m);
    EXPECT_LT((contact.n - Vector3d::UnitZ()).norm(), 1e-15);
    EXPECT_NEAR(std::abs(contact.p_m.x()), 30e-3, kRounding_m);
    EXPECT_NEAR(std::abs(contact.p_m.y()), 20e-3, kRounding_m);
  }
  const auto cylinder = contacts_of(CylinderShape{10e-3, 60e-3}, HalfSpace{}, at({0.0, 0.0, 30e-3}), 0.1e-3);
  EXPECT_EQ(cylinder.size(), 32U);
}

TEST(SolidContacts, OnABoxThatIsNarrowerEdgesCross) {
  // A plank across a beam: two edges of either cross, at the corners of where they overlap.
  const auto contacts =
      contacts_of(BoxShape{{100e-3, 20e-3, 10e-3}}, BoxShape{{20e-3, 100e-3, 10e-3}}, at({0.0, 0.0, 10e-3}), 0.1e-3);
  ASSERT_EQ(contacts.size(), 4U);
  for (const SolidContact& contact : contacts) {
    EXPECT_NEAR(contact.gap_m, 0.0, kRounding_m);
    EXPECT_LT((contact.n - Vector3d::UnitZ()).norm(), 1e-12);
    EXPECT_NEAR(std::abs(contact.p_m.x()), 10e-3, kRounding_m);
    EXPECT_NEAR(std::abs(contact.p_m.y()), 10e-3, kRounding_m);
  }
}

using Polygon = std::vector<Eigen::Vector2d>;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a[0] * b[1] - a[1] * b[0]; }

/// What is left of a polygon where the coordinate along `axis` is at most `most_m`, times sign [Sutherland, Hodgman].
Polygon cut(const Polygon& polygon, int axis, double sign, double most_m) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double over_a = sign * a[axis] - most_m, over_b = sign * b[axis] - most_m;
    if (over_a <= 0.0) kept.push_back(a);
    if ((over_a < 0.0) != (over_b < 0.0)) kept.push_back(a + over_a / (over_a - over_b) * (b - a));
  }
  return kept;
}

/// Seen from above: what the lower face of a box at X shares with the upper face of another.
Polygon overlap(const BoxShape& a, const Isometry3d& X, const BoxShape& b) {
  Polygon shared;
  for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) {
    shared.push_back((X * Vector3d(0.5 * a.size_m.cwiseProduct(Vector3d(x, y, -1.0)))).head<2>());
  }
  for (const int axis : {0, 1}) {
    for (const double sign : {-1.0, 1.0}) shared = cut(shared, axis, sign, 0.5 * b.size_m[axis]);
  }
  return shared;
}

// What lies on something rests if its middle is over the hull of the contacts: that must be all that the two faces
// share, however the upper one is turned, leans, or hangs over.
TEST(SolidContacts, AFaceThatLeansOnAnEdgeGivesTheNormal) {
  // A plank that leans over the right edge of a beam, and lies on it with the width of the plank.
  const BoxShape plank{{100e-3, 20e-3, 10e-3}}, beam{{20e-3, 100e-3, 10e-3}};
  for (const double lean : {1e-6, 1e-3, 5e-3, 0.013, 0.0142, 0.05, 0.3}) {
    SCOPED_TRACE(lean);
    const Vector3d edge(10e-3, 0.0, 5e-3), n(std::sin(lean), 0.0, std::cos(lean));
    const auto contacts = contacts_of(plank, beam, at(edge + 5e-3 * n, {0.0, lean, 0.0}), 0.01e-3);
    int on_edge = 0;
    for (const SolidContact& contact : contacts) {
      if (std::abs(contact.p_m.x() - edge.x()) > 1e-6) continue;
      ++on_edge;
      EXPECT_NEAR(contact.gap_m, 0.0, kRounding_m);
      EXPECT_LT((contact.n - n).norm(), 1e-12);
    }
    EXPECT_EQ(on_edge, 2);
  }
}

TEST(SolidContacts, ContactsOfBoxesAreTheCornersOfWhatTheirFacesShare) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0), size_m(10e-3, 100e-3);
  constexpr double kBand_m = 1e-3, kClose_m = 1e-6;
  int corners = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    SCOPED_TRACE(trial);
    const BoxShape a{{size_m(random), size_m(random), size_m(random)}},
        b{{size_m(random), size_m(random), size_m(random)}};
    // Tilts from 1e-9 to 1e-3; what leans by more than the band is apart.
    const double tilt = std::pow(10.0, -6.0 + 3.0 * unit(random)), about = kPi * unit(random);
    Isometry3d X = Isometry3d::Identity();
    X.linear() = (Eigen::AngleAxisd(tilt, Vector3d(std::cos(about), std::sin(about), 0.0)) *
                  Eigen::AngleAxisd(trial % 10 == 0 ? 0.0 : kPi * unit(random), Vector3d::UnitZ()))
                     .toRotationMatrix();
    X.translation() = Vector3d(0.5 * b.size_m[0] * unit(random), 0.5 * b.size_m[1] * unit(random),
                               0.5 * (a.size_m[2] + b.size_m[2]) - 50e-9);
    const Polygon shared = overlap(a, X, b);
    if (shared.size() < 3) continue;
    Polygon found;
    for (const SolidContact& contact : contacts_of(a, b, X, kBand_m)) {
      // Corners beside the other's edges are near them, too, but touch nothing.
      if (contact.n.z() > 0.99) found.emplace_back(contact.p_m.head<2>());
      ASSERT_GT(contact.gap_m, -2e-4) << contact.n.transpose();
    }
    for (const Eigen::Vector2d& corner : shared) {
      const auto off = [&](const Eigen::Vector2d& p) { return (p - corner).norm(); };
      ASSERT_TRUE(std::ranges::any_of(found, [&](const auto& p) { return off(p) < kClose_m; })) << corner.transpose();
      ++corners;
    }
    for (const Eigen::Vector2d& p : found) {
      for (std::size_t i = 0; i < shared.size(); ++i) {
        const Eigen::Vector2d along = shared[(i + 1) % shared.size()] - shared[i];
        if (along.norm() < kClose_m) continue;
        ASSERT_GT(cross(along.normalized(), p - shared[i]), -kClose_m) << p.transpose();
      }
    }
  }
  EXPECT_GT(corners, 3000);
}

// Of two solids that both find them, one counts: two contacts at a place would be twice as stiff.
TEST(SolidContacts, RoundsMeetOnce) {
  const SphereShape ball{10e-3};
  const CylinderShape rod{5e-3, 80e-3};
  const BoxShape box{{40e-3, 40e-3, 20e-3}};
  const Vector3d across(0.5 * kPi, 0.0, 0.0);
  const struct {
    Solid a, b;
    Isometry3d X_BA;
    double gap_m;
  } cases[] = {
      {ball, SphereShape{20e-3}, at({0.0, 18e-3, 24.1e-3}), std::hypot(18e-3, 24.1e-3) - 30e-3},
      {ball, rod, at({15.1e-3, 0.0, 10e-3}), 0.1e-3},
      {rod, ball, at({15.1e-3, 0.0, 10e-3}), 0.1e-3},
      {CylinderShape{5e-3, 80e-3}, rod, at({10.1e-3, 0.0, 0.0}, across), 0.1e-3},
      {ball, box, at({3e-3, -2e-3, 20.1e-3}), 0.1e-3},
      {box, ball, at({3e-3, -2e-3, 20.1e-3}), 0.1e-3},
      // Over an edge of the box, out at 45 degrees; and over its corner.
      {ball, box, at({20e-3 + 7.1e-3, 0.0, 10e-3 + 7.1e-3}), std::sqrt(2.0) * 7.1e-3 - 10e-3},
      {box, ball, at({20e-3 + 7.1e-3, 0.0, 10e-3 + 7.1e-3}), std::sqrt(2.0) * 7.1e-3 - 10e-3},
      {ball, box, at({20e-3 + 6e-3, 20e-3 + 6e-3, 10e-3 + 6e-3}), std::sqrt(3.0) * 6e-3 - 10e-3},
  };
  for (std::size_t i = 0; i < std::size(cases); ++i) {
    SCOPED_TRACE(i);
    const auto contacts = contacts_of(cases[i].a, cases[i].b, cases[i].X_BA, 0.5e-3);
    ASSERT_EQ(contacts.size(), 1U);
    EXPECT_NEAR(contacts.front().gap_m, cases[i].gap_m, kRounding_m);
  }
}

/// A peg in a hole, tilted by t about y and aside by e: its lower circle meets the bore on one side, and the bore's
/// upper edge its side on the other. In the plane of the tilt both gaps are those of a rectangle in a slot.
TEST(SolidContacts, ATiltedPegMeetsTheBoreByItsCircleAndTheMouthByItsSide) {
  const double r = 9.9e-3, length = 60e-3, depth = 20e-3;
  const CylinderShape peg{r, length};
  for (const double tilt : {0.002, 0.01}) {
    // About the middle of what is in the hole.
    const double up_m = 0.5 * length - 0.5 * depth;
    const Isometry3d X_BA = at({up_m * std::sin(tilt), 0.0, up_m * std::cos(tilt) - 0.5 * depth}, {0.0, tilt, 0.0});
    const auto contacts = contacts_of(peg, kHole, X_BA, 0.5e-3);
    const Vector3d low = X_BA * Vector3d(-r, 0.0, -0.5 * length);  // Tilted so, the lower end is at -x.
    double lower_m = 1.0, upper_m = 1.0;
    for (const SolidContact& contact : contacts) {
      if (contact.p_m.z() < -15e-3 && contact.n.x() > 0.9) lower_m = std::min(lower_m, contact.gap_m);
      if (contact.p_m.z() > -2e-3 && contact.n.x() < -0.9) upper_m = std::min(upper_m, contact.gap_m);
    }
    EXPECT_NEAR(lower_m, kHole.radius_m + low.x(), kRounding_m) << tilt;
    const Vector3d edge = X_BA.inverse() * Vector3d(kHole.radius_m, 0.0, -kHole.chamfer_m);
    EXPECT_NEAR(upper_m, edge.x() - r, kRounding_m) << tilt;
  }
}

/// Contacts go over from the mouth to the bore and along it as the pose does: their least gap has no jumps.
TEST(SolidContacts, TheLeastGapIsContinuousOnTheWayIntoAHole) {
  const CylinderShape peg{9.9e-3, 60e-3};
  double before_m = 0.0;
  constexpr double kStep_m = 1e-6;
  for (int k = 0; k < 6000; ++k) {
    const double way_m = kStep_m * k;
    const Isometry3d X_BA =
        at({0.4e-3 * std::max(0.0, 1.0 - way_m / 2e-3), 0.0, 30e-3 + 1e-3 - way_m}, {0.0, 0.003, 0.0});
    double least_m = 1e-3;
    for (const SolidContact& contact : contacts_of(peg, kHole, X_BA, 1e-3)) least_m = std::min(least_m, contact.gap_m);
    if (k > 0) {
      EXPECT_LE(std::abs(least_m - before_m), 1.5 * kStep_m) << "step " << k;
    }
    before_m = least_m;
  }
}

/// The gap's motion with the body is n . (v + w x r): what the contact tick takes it for.
TEST(SolidContacts, NormalsAreTheDerivativeOfGaps) {
  std::mt19937 random(2);
  std::normal_distribution<double> unit;
  const std::vector<std::pair<Solid, Solid>> pairs{{CylinderShape{9.9e-3, 60e-3}, kHole},
                                                   {BoxShape{{30e-3, 40e-3, 50e-3}}, HalfSpace{}},
                                                   {SphereShape{9e-3}, kHole},
                                                   {CylinderShape{10e-3, 40e-3}, CylinderShape{8e-3, 50e-3}},
                                                   {BoxShape{{30e-3, 40e-3, 50e-3}}, BoxShape{{20e-3, 30e-3, 70e-3}}}};
  int compared = 0;
  for (const auto& [a, b] : pairs) {
    for (int trial = 0; trial < 400; ++trial) {
      const bool hole = std::holds_alternative<HoleShape>(b);
      const Vector3d place = hole ? Vector3d(0.1e-3 * unit(random), 0.1e-3 * unit(random), 15e-3)
                                  : Vector3d(12e-3 * unit(random), 12e-3 * unit(random), 25e-3 + 5e-3 * unit(random));
      const Vector3d turn = (hole ? 0.01 : 0.8) * Vector3d(unit(random), unit(random), unit(random));
      const Isometry3d X = at(place, turn);
      constexpr double kWay_m = 1e-9;
      const Vector3d v = kWay_m * Vector3d(unit(random), unit(random), unit(random));
      const Vector3d w = 30.0 * kWay_m * Vector3d(unit(random), unit(random), unit(random));
      Isometry3d moved = X;
      moved.translation() += v;
      moved.linear() = Eigen::AngleAxisd(w.norm(), w.normalized()) * X.linear();
      const auto before = contacts_of(a, b, X, 2e-3), after = contacts_of(a, b, moved, 2e-3);
      if (before.size() != after.size()) continue;
      for (std::size_t i = 0; i < before.size(); ++i) {
        // Deep in one another solids have sides that are equally near.
        if (before[i].place != after[i].place || before[i].gap_m < -0.5e-3) continue;
        const double way_m = before[i].n.dot(v + w.cross(before[i].p_m - X.translation()));
        // Second order: kWay_m^2 over how far a peg is off its hole, some 10 um.
        EXPECT_NEAR(after[i].gap_m - before[i].gap_m, way_m, 2e-3 * kWay_m)
            << "place " << before[i].place << ", seed 2";
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 1000);
}

}  // namespace thenar::solids_test
