// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>
#include <vector>

#include "bench/cases/random.h"
#include "solvers/grasp_forces.h"
#include "solvers/muscles/muscle_forces.h"

namespace thenar {

// Random grasp and muscle problems by name: the same in tests, benchmarks and charts.

/// A grasp problem in the making.
struct Grasp : GraspData {
  [[nodiscard]] Eigen::Index n() const { return std::ssize(contacts); }

  void add_contact(const Eigen::Vector3d& point_m, const Eigen::Matrix3d& frame) {
    contacts.push_back({point_m, frame});
  }

  /// The wrench of a force at a point.
  [[nodiscard]] Vector6d wrench_of(const Eigen::Vector3d& point_m, const Eigen::Vector3d& force) const {
    Vector6d w;
    w.head<3>() = force;
    w.tail<3>() = (point_m - centre_m).cross(force);
    return w;
  }
  /// Adds to the wrench what a force at contact i, in that contact's axes, gives.
  void add_force(Eigen::Index i, const Eigen::Vector3d& force_C) {
    wrench += wrench_of(contacts[i].point_m, contacts[i].axes * force_C);
  }
};

namespace grasp_families {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

inline constexpr double kTurn = 2.0 * std::numbers::pi;

/// The weight of 50 g to 1 kg in any direction, a push of up to 1 N and a torque of up to 30 mN m.
inline void draw_wrench(Random& random, Grasp& grasp) {
  grasp.wrench.head<3>() = random.uniform(0.5, 10.0) * random.direction() + random.uniform() * random.direction();
  grasp.wrench.tail<3>() = random.uniform(0.0, 0.03) * random.direction();
}

/// Takes the torque about the line through the first two contacts out of the wrench: contacts on it cannot give it.
inline void drop_torque_about_line(Grasp& grasp) {
  const Vector3d on_line = grasp.contacts[0].point_m - grasp.centre_m;
  const Vector3d along = (grasp.contacts[1].point_m - grasp.contacts[0].point_m).normalized();
  const Vector3d torque = grasp.wrench.tail<3>() - on_line.cross(grasp.wrench.head<3>());
  grasp.wrench.tail<3>() -= torque.dot(along) * along;
}

/// A force inside the round cone, at most `depth` of the way from its axis to its surface.
inline Vector3d force_inside(Random& random, double friction, double depth) {
  const Vector3d t = random.square_to(Vector3d::UnitX());
  return random.uniform(0.5, 4.0) * (Vector3d::UnitX() + random.uniform(0.0, depth) * friction * t);
}

/// Contacts on the faces of a box of 4 to 10 cm, first one against two.
inline Grasp box(Random& random, Index n) {
  Grasp grasp;
  grasp.friction = random.uniform(0.3, 1.0);
  grasp.internal_force_N = random.uniform(0.0, 4.0);
  grasp.centre_m = 0.05 * random.direction();
  const Matrix3d R = random.frame_about(random.direction());
  const Vector3d half(random.uniform(0.02, 0.05), random.uniform(0.02, 0.05), random.uniform(0.02, 0.05));
  for (Index i = 0; i < n; ++i) {
    const int axis = i < 3 ? 0 : random.whole(0, 2);
    const double side = i == 0 ? -1.0 : (i < 3 || random.chance(0.5) ? 1.0 : -1.0);
    Vector3d point(random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8));
    point[axis] = side;
    grasp.add_contact(R * half.cwiseProduct(point), random.frame_about(-side * R.col(axis)));
  }
  draw_wrench(random, grasp);
  if (n == 2) drop_torque_about_line(grasp);
  return grasp;
}

/// Contacts around a ball of 4 to 10 cm, near one great circle.
inline Grasp sphere(Random& random, Index n) {
  Grasp grasp;
  grasp.friction = random.uniform(0.3, 1.0);
  grasp.internal_force_N = random.uniform(0.0, 4.0);
  const double radius_m = random.uniform(0.02, 0.05);
  const Matrix3d R = random.frame_about(random.direction());
  for (Index i = 0; i < n; ++i) {
    const double along = kTurn * static_cast<double>(i) / static_cast<double>(n) + random.uniform(-0.4, 0.4);
    const Vector3d outward = R * Vector3d(random.uniform(-0.4, 0.4), std::cos(along), std::sin(along)).normalized();
    grasp.add_contact(radius_m * outward, random.frame_about(-outward));
  }
  draw_wrench(random, grasp);
  if (n == 2) drop_torque_about_line(grasp);
  return grasp;
}

inline Grasp box_or_sphere(Random& random, Index n) { return random.chance(0.5) ? box(random, n) : sphere(random, n); }

/// A wrench that forces well inside the cones give.
inline Grasp held(Random& random, Index n) {
  Grasp grasp = box_or_sphere(random, n);
  grasp.wrench.setZero();
  for (Index i = 0; i < n; ++i) grasp.add_force(i, force_inside(random, grasp.friction, 0.9));
  return grasp;
}

/// Contacts anywhere, normals up to some 30 degrees off the radius, little friction: most wrenches are out of reach.
inline Grasp scattered(Random& random, Index n) {
  Grasp grasp;
  grasp.centre_m = 0.05 * random.direction();
  grasp.friction = random.uniform(0.1, 0.6);
  grasp.internal_force_N = random.chance(0.5) ? random.uniform(0.0, 3.0) : 0.0;
  for (Index i = 0; i < n; ++i) {
    const Vector3d outward = random.direction();
    grasp.add_contact(0.03 * outward, random.frame_about(-outward + random.uniform(0.0, 0.6) * random.direction()));
  }
  draw_wrench(random, grasp);
  if (n == 2) drop_torque_about_line(grasp);
  return grasp;
}

/// Contacts on one line: the first two press on each other along it. Half of the wrenches come from forces inside the
/// cones, the rest are random, one in ten of them with a torque about the line.
inline Grasp collinear(Random& random, Index n) {
  Grasp grasp;
  grasp.friction = random.uniform(0.5, 1.0);
  grasp.internal_force_N = random.uniform(0.0, 4.0);
  const Vector3d origin = 0.01 * random.direction();
  const Vector3d along = random.direction();
  for (Index i = 0; i < n; ++i) {
    const double at_m = i == 0 ? -0.03 : (i == 1 ? 0.03 : random.uniform(-0.03, 0.03));
    const Vector3d normal = i == 0 ? along : (i == 1 ? Vector3d(-along) : random.direction());
    grasp.add_contact(origin + at_m * along, random.frame_about(normal));
  }
  if (random.chance(0.5)) {
    for (Index i = 0; i < n; ++i) grasp.add_force(i, force_inside(random, grasp.friction, 0.9));
  } else {
    draw_wrench(random, grasp);
    if (!random.chance(0.1)) drop_torque_about_line(grasp);
  }
  return grasp;
}

/// Three contacts or more, all but the first two 1e-9 to 1e-4 m off the line through those.
inline Grasp near_collinear(Random& random, Index n) {
  Grasp grasp = box(random, n);
  const Vector3d first = grasp.contacts[0].point_m;
  const Vector3d across = grasp.contacts[1].point_m - first;
  for (Index i = 2; i < n; ++i) {
    grasp.contacts[i].point_m =
        first + random.uniform(0.1, 0.9) * across + random.power_of_ten(-9.0, -4.0) * random.direction();
  }
  drop_torque_about_line(grasp);
  return grasp;
}

/// No friction: wrenches that normal forces give, and one in four that they do not.
inline Grasp frictionless(Random& random, Index n) {
  Grasp grasp = box_or_sphere(random, n);
  grasp.friction = 0.0;
  if (random.chance(0.25)) return grasp;
  grasp.wrench.setZero();
  for (Index i = 0; i < n; ++i) {
    if (random.chance(0.8)) grasp.add_force(i, Vector3d(random.uniform(0.0, 3.0), 0.0, 0.0));
  }
  return grasp;
}

/// Friction of 1e-6 to 1e-3: wrenches that forces inside these needles give, and one in four that they do not.
inline Grasp little_friction(Random& random, Index n) {
  Grasp grasp = box_or_sphere(random, n);
  grasp.friction = random.power_of_ten(-6.0, -3.0);
  if (random.chance(0.25)) return grasp;
  grasp.wrench.setZero();
  for (Index i = 0; i < n; ++i) grasp.add_force(i, force_inside(random, grasp.friction, 1.0));
  return grasp;
}

/// Friction of 10 to 1000: cones that are nearly half-spaces.
inline Grasp great_friction(Random& random, Index n) {
  Grasp grasp = scattered(random, n);
  grasp.friction = random.power_of_ten(1.0, 3.0);
  return grasp;
}

/// The last contact stands at the first one, half of the time with another tangent, too.
inline Grasp duplicate(Random& random, Index n) {
  Grasp grasp = box_or_sphere(random, n - 1);
  GraspContact copy = grasp.contacts.front();
  if (random.chance(0.5)) copy.axes = random.frame_about(copy.axes.col(0));
  grasp.contacts.push_back(copy);
  return grasp;
}

/// Forces and lengths a million times less to a million times more than usual.
inline Grasp scaled(Random& random, Index n) {
  Grasp grasp = box_or_sphere(random, n);
  const double force = random.power_of_ten(-6.0, 6.0);
  const double length = random.power_of_ten(-6.0, 6.0);
  grasp.internal_force_N *= force;
  grasp.centre_m *= length;
  for (GraspContact& contact : grasp.contacts) contact.point_m *= length;
  grasp.wrench *= force;
  grasp.wrench.tail<3>() *= length;
  return grasp;
}

/// Two contacts press at edges of their pyramids, the others not at all: many constraints are tight at once.
inline Grasp pyramid_edge(Random& random, Index n) {
  Grasp grasp = box(random, n);
  grasp.internal_force_N = 0.0;
  grasp.wrench.setZero();
  const double mu = grasp.friction;
  for (Index i = 0; i < 2; ++i) grasp.add_force(i, random.uniform(0.5, 3.0) * Vector3d(1.0, mu, mu));
  return grasp;
}

/// Every contact is at the apex of its cone or on its surface, none inside.
inline Grasp apex(Random& random, Index n) {
  Grasp grasp = box_or_sphere(random, n);
  grasp.internal_force_N = 0.0;
  grasp.wrench.setZero();
  for (Index i = 0; i < n; ++i) {
    if (!random.chance(0.5)) continue;
    const Vector3d t = random.square_to(Vector3d::UnitX());
    grasp.add_force(i, random.uniform(0.5, 3.0) * (Vector3d::UnitX() + grasp.friction * t));
  }
  return grasp;
}

/// Nothing to do: no wrench, or no squeeze, or neither.
inline Grasp idle(Random& random, Index n) {
  Grasp grasp = box_or_sphere(random, n);
  const int which = random.whole(0, 2);
  if (which != 1) grasp.wrench.setZero();
  if (which != 0) grasp.internal_force_N = 0.0;
  return grasp;
}

/// Faces, edges and corners of a cube, wrenches in whole numbers: contacts and rows coincide, ratios tie.
inline Grasp grid(Random& random, Index n) {
  Grasp grasp;
  constexpr double half_m = 0.02;
  const auto whole = [&] { return static_cast<double>(random.whole(-1, 1)); };
  for (Index i = 0; i < n; ++i) {
    const int face = random.whole(0, 2);
    const double side = random.chance(0.5) ? 1.0 : -1.0;
    Vector3d point(whole(), whole(), whole());
    point[face] = side;
    Matrix3d frame;
    frame << -side * Vector3d::Unit(face), Vector3d::Unit((face + 1) % 3), -side * Vector3d::Unit((face + 2) % 3);
    grasp.add_contact(half_m * point, frame);
  }
  for (int k = 0; k < 6; ++k) grasp.wrench[k] = whole() * (k < 3 ? 1.0 : half_m);
  grasp.friction = std::array{1.0, 0.5, 0.1}[random.whole(0, 2)];
  grasp.internal_force_N = random.whole(0, 1);
  return grasp;
}

/// A wrench at the border of those that the round cones can give: inside or outside of it by 1e-12 to 1e-2 of itself.
/// A twist l is drawn first, then contacts on which l does no work: normals such that l moves the point along the
/// surface of the polar cone (the contact may press, with all its friction) or away from the contact (it does not).
inline Grasp border(Random& random, Index n) {
  Grasp grasp;
  const double mu = grasp.friction = random.uniform(0.1, 1.0);
  grasp.internal_force_N = random.chance(0.5) ? random.uniform(0.0, 3.0) : 0.0;
  const Vector3d shift = random.direction();
  const Vector3d turn = random.power_of_ten(0.0, 2.0) * random.direction();
  Vector6d inside = Vector6d::Zero();
  for (Index i = 0; i < n; ++i) {
    const Vector3d point = 0.03 * random.direction();
    const Vector3d motion = (shift + turn.cross(point)).normalized();
    const Vector3d across = random.square_to(motion);
    const bool presses = i == 0 || random.chance(0.5);
    // The angle between `motion` and the normal: x_n = -mu |x_t| where it presses, further back where it does not.
    const double back = presses ? mu : mu * random.uniform(1.1, 3.0);
    const Matrix3d frame = random.frame_about(across - back * motion);
    grasp.add_contact(point, frame);
    const Vector3d tangent = (motion - motion.dot(frame.col(0)) * frame.col(0)).normalized();
    const Vector3d pressing = random.uniform(0.5, 3.0) * (frame.col(0) + mu * tangent);
    if (presses) grasp.wrench += grasp.wrench_of(point, pressing);
    inside += grasp.wrench_of(point, frame.col(0));
  }
  const double share = random.power_of_ten(-12.0, -2.0);
  Vector6d outward;  // l, lengths in units of 3 cm.
  outward.head<3>() = shift;
  outward.tail<3>() = 0.03 * 0.03 * turn;
  grasp.wrench += random.chance(0.5) ? Vector6d(share * inside) : Vector6d(share * grasp.wrench.norm() * outward);
  return grasp;
}

}  // namespace grasp_families

/// Random grasp problems of one kind.
struct GraspFamily {
  std::string_view name;
  Eigen::Index fewest, most;  ///< Contacts.
  Grasp (*draw)(Random&, Eigen::Index contacts);

  /// The problem of a seed, with as many contacts as it draws or as are asked for.
  [[nodiscard]] Grasp problem(std::uint64_t seed) const {
    Random random(seed);
    return draw(random, random.whole(static_cast<int>(fewest), static_cast<int>(most)));
  }
  [[nodiscard]] Grasp problem(std::uint64_t seed, Eigen::Index contacts) const {
    Random random(seed);
    return draw(random, contacts);
  }
};

inline constexpr std::array kGraspFamilies{
    // What a hand meets.
    GraspFamily{"box", 2, 8, grasp_families::box},
    GraspFamily{"sphere", 2, 8, grasp_families::sphere},
    GraspFamily{"held", 2, 8, grasp_families::held},
    GraspFamily{"scattered", 2, 8, grasp_families::scattered},
    // What breaks solvers.
    GraspFamily{"collinear", 2, 5, grasp_families::collinear},
    GraspFamily{"near_collinear", 3, 5, grasp_families::near_collinear},
    GraspFamily{"frictionless", 2, 8, grasp_families::frictionless},
    GraspFamily{"little_friction", 2, 8, grasp_families::little_friction},
    GraspFamily{"great_friction", 2, 8, grasp_families::great_friction},
    GraspFamily{"duplicate", 3, 8, grasp_families::duplicate},
    GraspFamily{"scaled", 2, 8, grasp_families::scaled},
    GraspFamily{"pyramid_edge", 2, 8, grasp_families::pyramid_edge},
    GraspFamily{"apex", 2, 8, grasp_families::apex},
    GraspFamily{"idle", 1, 8, grasp_families::idle},
    GraspFamily{"grid", 1, 8, grasp_families::grid},
    GraspFamily{"border", 1, 8, grasp_families::border},
};

/// Muscle-force problems of 12 joints x 23 muscles. A finger's joints are abduction, then three flexions.
namespace muscle_families {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The signs of the hand's moment arms: thumb 4 x 8; index and major 8 x 15, coupled by one common extensor.
inline MatrixXd moment_arms(Random& random) {
  MatrixXd H = MatrixXd::Zero(12, 23);
  const auto stray = [&](int finger, int muscle, int joint) {
    H(4 * finger + joint, muscle) += random.uniform(-2e-3, 2e-3);
  };
  const auto abductor = [&](int finger, int muscle, double sign) {
    H(4 * finger, muscle) += sign * random.uniform(4e-3, 14e-3);
    stray(finger, muscle, 1);
  };
  // Tendons that run on to the tip pass each further joint closer to its axis.
  const auto flexor = [&](int finger, int muscle, double sign, int last_joint) {
    for (int joint = 1; joint <= last_joint; ++joint) {
      H(4 * finger + joint, muscle) += sign * random.uniform(3e-3, 12e-3) * (1.0 - 0.2 * (joint - 1));
    }
    stray(finger, muscle, 0);
  };
  const auto lumbrical = [&](int finger, int muscle) {
    H(4 * finger + 1, muscle) += random.uniform(4e-3, 14e-3);
    H(4 * finger + 2, muscle) -= random.uniform(2e-3, 7e-3);
    H(4 * finger + 3, muscle) -= random.uniform(1e-3, 4e-3);
  };
  for (const int opponent : {0, 6}) abductor(0, opponent, -1.0);
  for (const int abductor_of_thumb : {1, 7}) abductor(0, abductor_of_thumb, 1.0);
  for (const int both : {6, 7}) H(1, both) += random.uniform(4e-3, 14e-3);
  flexor(0, 2, 1.0, 2);
  flexor(0, 3, -1.0, 2);
  flexor(0, 4, 1.0, 3);
  flexor(0, 5, -1.0, 3);
  for (const auto [finger, first] : {std::array{1, 8}, std::array{2, 16}}) {
    lumbrical(finger, first);
    abductor(finger, first + 1, 1.0);
    abductor(finger, first + 2, -1.0);
    flexor(finger, first + 3, 1.0, 2);
  }
  flexor(1, 12, -1.0, 2);
  flexor(1, 13, 1.0, 3);
  flexor(1, 14, -1.0, 3);
  for (const int finger : {1, 2}) flexor(finger, 15, -1.0, 3);
  flexor(2, 20, -1.0, 2);
  flexor(2, 21, 1.0, 3);
  flexor(2, 22, -1.0, 3);
  return H;
}

/// Torques of up to 0.25 N m, a third of that at the last joint: some are out of the muscles' reach.
inline MuscleData any(Random& random) {
  MuscleData problem{moment_arms(random), VectorXd(12)};
  for (Index i = 0; i < 12; ++i) problem.tau[i] = random.uniform(-0.25, 0.25) * (i % 4 == 3 ? 0.3 : 1.0);
  return problem;
}

/// Torques that pulling muscles give.
inline MuscleData held(Random& random) {
  MuscleData problem{moment_arms(random), VectorXd::Zero(12)};
  for (Index j = 0; j < 23; ++j) problem.tau += random.uniform(0.0, 30.0) * problem.H.col(j);
  return problem;
}

/// Torques that a few muscles give, at the border of what all can give.
inline MuscleData few(Random& random) {
  MuscleData problem{moment_arms(random), VectorXd::Zero(12)};
  for (Index j = 0; j < 23; ++j) {
    if (random.chance(0.3)) problem.tau += random.uniform(0.0, 30.0) * problem.H.col(j);
  }
  return problem;
}

/// A joint that no muscle passes, or one whose arms are those of the joint before; half of the torques agree.
inline MuscleData dependent(Random& random) {
  MuscleData problem = held(random);
  const Index joint = random.whole(1, 11);
  problem.H.row(joint) = random.chance(0.5) ? 0.0 * problem.H.row(joint) : 0.7 * problem.H.row(joint - 1);
  if (random.chance(0.5)) problem.tau[joint] = problem.H.row(joint).isZero(0.0) ? 0.0 : 0.7 * problem.tau[joint - 1];
  return problem;
}

/// Torques and arms a million times less to a million times more than usual.
inline MuscleData scaled(Random& random) {
  MuscleData problem = random.chance(0.5) ? held(random) : any(random);
  problem.H *= random.power_of_ten(-6.0, 6.0);
  problem.tau *= random.power_of_ten(-6.0, 6.0);
  return problem;
}

}  // namespace muscle_families

/// Random muscle problems of one kind.
struct MuscleFamily {
  std::string_view name;
  MuscleData (*draw)(Random&);

  [[nodiscard]] MuscleData problem(std::uint64_t seed) const {
    Random random(seed);
    return draw(random);
  }
};

inline constexpr std::array kMuscleFamilies{
    MuscleFamily{"muscles_any", muscle_families::any},
    MuscleFamily{"muscles_held", muscle_families::held},
    MuscleFamily{"muscles_few", muscle_families::few},
    MuscleFamily{"muscles_dependent", muscle_families::dependent},
    MuscleFamily{"muscles_scaled", muscle_families::scaled},
};

}  // namespace thenar
