// A surface that slides under a pulp bears Coulomb's friction in every point, against the surface's own normal there,
// which is known by a formula that the engine does not use.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "tests/truth/probe.h"

namespace thenar::full_slide_test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using namespace truth;

constexpr double kDegree = std::numbers::pi / 180.0;

/// A place beside a surface: the outward normal over it, and how far above it is. Object frame.
struct Over {
  Vector3d outward;
  double above_m;
};
using Surface = std::function<Over(const Vector3d&)>;

/// Of all loaded points at the end of a slide.
struct Worst {
  double least_ratio = 1e9, largest_ratio = 0.0;  ///< Of friction over normal force.
  double off_m = 0.0;                             ///< From the surface.
  int points = 0;

  void add(const Split& at, double above_m) {
    least_ratio = std::min(least_ratio, at.friction_N / at.normal_N);
    largest_ratio = std::max(largest_ratio, at.friction_N / at.normal_N);
    off_m = std::max(off_m, std::abs(above_m));
    ++points;
  }
};

/// Slides the object from its start along `way`, poses by the share of the whole, and looks at the last ticks.
Worst slide(const Probe& probe, int ticks, const std::function<Isometry3d(double)>& way, const Surface& surface) {
  constexpr int kLast = 20;
  Loop loop(scene_of(probe));
  Worst worst;
  for (int i = 1; i <= ticks; ++i) {
    TickInput input;
    input.X_WT = way(static_cast<double>(i) / ticks);
    loop.tick(input);
    if (i <= ticks - kLast) continue;
    for (const LoadedPoint& point : loaded_points(loop.model, loop)) {
      const Over over = surface(point.x_O);
      worst.add(split(point.f_O, over.outward), over.above_m);
    }
  }
  return worst;
}

struct RodSlide {
  double radius_m, friction, angle;  ///< The angle of the way on the surface from the axis.
  Eigen::Index leaves = 320;
  double frame_s = 1e-3, way_m = 6e-3;
};

/// A cylinder along z, 1 mm deep in the pulp, which is moved and turned so that its surface slides at 10 um a tick.
Worst slide_of_rod(const RodSlide& of) {
  constexpr double kDepth_m = 1e-3, kTick_m = 10e-6;
  Probe probe;
  probe.shape = CylinderShape{of.radius_m, 0.08};
  probe.friction = of.friction;
  probe.leaves = of.leaves;
  probe.frame_s = of.frame_s;
  probe.X_WO.translation() = Vector3d(kProbeRadius_m + of.radius_m - kDepth_m, 0.0, 0.0);
  const auto way = [&](double share) {
    Isometry3d X = probe.X_WO;
    X.translation().z() += share * of.way_m * std::cos(of.angle);
    X.rotate(AngleAxisd(share * of.way_m * std::sin(of.angle) / of.radius_m, Vector3d::UnitZ()));
    return X;
  };
  return slide(probe, static_cast<int>(std::lround(of.way_m / kTick_m)), way, [&](const Vector3d& x) -> Over {
    const Vector3d radial(x[0], x[1], 0.0);
    return {radial.normalized(), radial.norm() - of.radius_m};
  });
}

void expect_coulomb(const Worst& worst, double friction, double share = 0.01, double off_m = 5e-6) {
  EXPECT_GT(worst.points, 20 * 3);
  EXPECT_GE(worst.least_ratio, (1.0 - share) * friction);
  EXPECT_LE(worst.largest_ratio, (1.0 + share) * friction);
  EXPECT_LE(worst.off_m, off_m);
}

// A pulp goes along around a rod by an angle t until P = f_n (cos t - mu sin t) bears no more: with mu = 1.2 it does
// not slide as a whole where t comes to 40 degrees, which takes less of thin rods.
constexpr double kRubbed_m = 3.3e-3;

class Rods : public testing::TestWithParam<double> {};

TEST_P(Rods, BearCoulombsFrictionInEveryPoint) {
  for (const double friction : {0.1, 0.3, 0.8, 1.2}) {
    for (const double degrees : {0.0, 45.0, 90.0}) {
      SCOPED_TRACE(std::to_string(friction) + " at " + std::to_string(degrees) + " deg");
      // A pulp that rubs hard goes along for as far as it shears.
      const double way_m = friction > 1.0 ? 10e-3 : 2e-3 + friction * 5e-3;
      const Worst worst = slide_of_rod({GetParam(), friction, degrees * kDegree, 320, 1e-3, way_m});
      // What rubs so hard winds the pulp around a thin rod, and some points stick for ever: see above.
      const double wound = friction * std::sin(degrees * kDegree) * std::sqrt(kRubbed_m / GetParam());
      expect_coulomb(worst, friction, wound > 1.0 ? 1.0 : 0.01);
      EXPECT_LE(worst.largest_ratio, 1.01 * friction);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Radii, Rods, testing::Values(2e-3, 3e-3, 4e-3, 6e-3, 12e-3, 30e-3));

TEST(FullSlide, OfRodsOnOlderFrames) {
  for (const double radius_m : {3e-3, 12e-3}) {
    for (const double frame_s : {5e-3, 20e-3}) {
      SCOPED_TRACE(std::to_string(1e3 * radius_m) + " mm, " + std::to_string(1e3 * frame_s) + " ms");
      expect_coulomb(slide_of_rod({radius_m, 0.5, 45.0 * kDegree, 320, frame_s}), 0.5);
    }
  }
}

TEST(FullSlide, OfRodsOnManyControlPoints) {
  for (const double radius_m : {2e-3, 6e-3}) {
    SCOPED_TRACE(std::to_string(1e3 * radius_m) + " mm");
    expect_coulomb(slide_of_rod({radius_m, 0.5, 90.0 * kDegree, 1280}), 0.5);
  }
}

/// Of a surface F(x) = 0 with this gradient, to the first order of a point's height.
Surface implicit(std::function<double(const Vector3d&)> value, std::function<Vector3d(const Vector3d&)> gradient) {
  return [=](const Vector3d& x) -> Over {
    const Vector3d slope = gradient(x);
    return {slope.normalized(), value(x) / slope.norm()};
  };
}

Surface ellipsoid(const Vector3d& half_m) {
  const Vector3d squared = half_m.cwiseAbs2();
  return implicit([=](const Vector3d& x) { return x.cwiseAbs2().cwiseQuotient(squared).sum() - 1.0; },
                  [=](const Vector3d& x) -> Vector3d { return 2.0 * x.cwiseQuotient(squared); });
}

/// An object that is 1 mm deep in the pulp and slides along y, about its own z and y.
Worst slide_beside(const Shape& shape, double half_x_m, const Surface& surface, double friction) {
  Probe probe;
  probe.shape = shape;
  probe.friction = friction;
  probe.X_WO.translation() = Vector3d(kProbeRadius_m + half_x_m - 1e-3, 0.0, 0.0);
  const auto way = [&](double share) {
    Isometry3d X = probe.X_WO;
    X.translation().y() += 3e-3 * share;
    X.rotate(AngleAxisd(-3e-3 * share / half_x_m, Vector3d::UnitZ()));
    return X;
  };
  return slide(probe, 600, way, surface);
}

TEST(FullSlide, OfEllipsoids) {
  for (const Vector3d& half_m : {Vector3d(8e-3, 12e-3, 20e-3), Vector3d(10e-3, 12e-3, 14e-3)}) {
    SCOPED_TRACE(half_m[0]);
    expect_coulomb(slide_beside(EllipsoidShape{2.0 * half_m}, half_m[0], ellipsoid(half_m), 0.4), 0.4, 0.03);
  }
}

TEST(FullSlide, OfASuperquadric) {
  const Vector3d half_m(12e-3, 10e-3, 15e-3);
  const Exponents e{0.8, 0.6};
  const auto power = [](double x, double p) { return std::pow(std::abs(x), p); };
  const Surface surface = implicit(
      [=](const Vector3d& x) {
        const Vector3d q = x.cwiseQuotient(half_m);
        const double ring = power(q[0], 2.0 / e.east_west) + power(q[1], 2.0 / e.east_west);
        return power(ring, e.east_west / e.north_south) + power(q[2], 2.0 / e.north_south) - 1.0;
      },
      [=](const Vector3d& x) -> Vector3d {
        const Vector3d q = x.cwiseQuotient(half_m);
        const double p = 2.0 / e.east_west, ring = power(q[0], p) + power(q[1], p);
        const double of_ring = e.east_west / e.north_south * power(ring, e.east_west / e.north_south - 1.0);
        const auto slope = [](double value, double exponent) {
          return std::copysign(exponent * std::pow(std::abs(value), exponent - 1.0), value);
        };
        return Vector3d(of_ring * slope(q[0], p), of_ring * slope(q[1], p), slope(q[2], 2.0 / e.north_south))
            .cwiseQuotient(half_m);
      });
  expect_coulomb(slide_beside(SuperquadricShape{2.0 * half_m, e}, half_m[0], surface, 0.4), 0.4, 0.03);
}

TEST(FullSlide, OfAMugsWall) {
  constexpr double kRadius_m = 27.5e-3;
  Mug mug;
  mug.radius_m = kRadius_m;
  mug.height_m = 80e-3;
  mug.wall_m = 3e-3;
  const Surface wall = [](const Vector3d& x) -> Over {
    const Vector3d radial(x[0], x[1], 0.0);
    return {radial.normalized(), radial.norm() - kRadius_m};
  };
  expect_coulomb(slide_beside(mug, kRadius_m, wall, 0.4), 0.4, 0.03);
}

}  // namespace
}  // namespace thenar::full_slide_test
