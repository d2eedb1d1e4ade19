// SPDX-License-Identifier: Apache-2.0
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <btBulletCollisionCommon.h>

#include <cmath>
#include <memory>
#include <nanoflann.hpp>

#include "bench/methods/finding_methods.h"
#include "bench/peers/fcl_peer.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

constexpr double kPulpRadius_m = 8e-3;

// --- nanoflann: neighbours, and on them our own plane of weighted means ---------------------------------------------

struct Neighbours {
  explicit Neighbours(const PointCloud& cloud)
      : points_m(cloud.points_m.cast<float>()), normals(cloud.normals.cast<float>()), tree(3, *this, {10}) {}

  [[nodiscard]] std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(points_m.cols()); }
  [[nodiscard]] float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points_m(static_cast<Index>(axis), static_cast<Index>(i));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }

  /// The nearest sample, the plane of the 16 samples about it by weights (1 - d^2/h^2)^4, and of those about the
  /// projection on it.
  [[nodiscard]] std::optional<SurfaceDistance> distance(const Vector3d& p_m, double reach_m) const {
    constexpr std::size_t kCount = 16;
    const Eigen::Vector3f p = p_m.cast<float>();
    std::uint32_t nearest = 0;
    float squared_m2 = 0.0F;
    if (tree.knnSearch(p.data(), 1, &nearest, &squared_m2) == 0) return std::nullopt;
    if (squared_m2 > reach_m * reach_m) return std::nullopt;
    std::array<std::uint32_t, kCount> ids{};
    std::array<float, kCount> squares_m2{};
    Eigen::Vector3f centre = points_m.col(nearest), n, a;
    for (int pass = 0; pass < 2; ++pass) {
      const std::size_t got = tree.knnSearch(centre.data(), kCount, ids.data(), squares_m2.data());
      const float h2 = 1.1F * squares_m2[got - 1];
      float sum = 0.0F;
      a.setZero();
      n.setZero();
      for (std::size_t k = 0; k < got; ++k) {
        float th = 1.0F - squares_m2[k] / h2;
        th *= th;
        th *= th;
        sum += th;
        a += th * (points_m.col(ids[k]) - centre);
        n += th * normals.col(ids[k]);
      }
      a = centre + a / sum;
      n.normalize();
      centre = p - n.dot(p - a) * n;
    }
    const Vector3d normal = n.cast<double>().normalized();
    const double distance_m = normal.dot(p_m - a.cast<double>());
    return SurfaceDistance{distance_m, p_m - distance_m * normal, normal};
  }

  Eigen::Matrix3Xf points_m, normals;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Neighbours>, Neighbours, 3> tree;
};

FindingMethod nanoflann_finding(const KnownObject& object, const Matrix3Xd& controls_m, const GripTask& task) {
  FindingMethod method;
  method.lacks = "a distance: its neighbours are made into a plane here; edges and thin plates";
  auto ready = made_ready(method, [&] { return std::make_shared<Neighbours>(object.cloud); });
  const Eigen::AlignedBox3d bounds(Vector3d(object.cloud.points_m.rowwise().minCoeff()),
                                   Vector3d(object.cloud.points_m.rowwise().maxCoeff()));
  const double reach_m = 0.5 * kPulpRadius_m + task.band_m;
  method.find = [=](const Grip& grip, std::vector<FoundContact>& found) {
    for (const Isometry3d& X : grip) {
      find_by_distance(
          controls_m, X, bounds, task, [&](const Vector3d& p) { return ready->distance(p, reach_m); }, found);
    }
  };
  method.distance = [ready, reach_m](const Vector3d& p_m) -> std::optional<double> {
    const auto to = ready->distance(p_m, reach_m);
    if (!to) return std::nullopt;
    return to->distance_m;
  };
  return method;
}

// --- FCL -------------------------------------------------------------------------------------------------------------

std::vector<double> numbers(const Matrix3Xd& m) { return {m.data(), m.data() + m.size()}; }
std::vector<int> numbers(const Eigen::Matrix3Xi& m) { return {m.data(), m.data() + m.size()}; }

std::shared_ptr<FclScene> fcl_scene(const TriangleMesh& mesh) {
  return std::make_shared<FclScene>(numbers(mesh.vertices_m), numbers(mesh.triangles));
}

FindingMethod fcl_distances(const KnownObject& object, const Matrix3Xd& controls_m, const GripTask& task) {
  FindingMethod method;
  method.lacks = "the sign (no depth), normals, which points are pressed in deeper than the band";
  method.is_signed = false;
  auto scene = made_ready(method, [&] { return fcl_scene(object.mesh); });
  const Eigen::AlignedBox3d bounds(Vector3d(object.mesh.vertices_m.rowwise().minCoeff()),
                                   Vector3d(object.mesh.vertices_m.rowwise().maxCoeff()));
  method.find = [=](const Grip& grip, std::vector<FoundContact>& found) {
    for (const Isometry3d& X : grip) {
      const auto distance = [&](const Vector3d& p) -> std::optional<SurfaceDistance> {
        return SurfaceDistance{scene->distance_m(p.data()), p, Vector3d::Zero()};
      };
      find_by_distance(controls_m, X, bounds, task, distance, found);
    }
  };
  method.distance = [scene](const Vector3d& p_m) -> std::optional<double> { return scene->distance_m(p_m.data()); };
  return method;
}

ContactFinder fcl_collisions(const std::shared_ptr<FclScene>& scene) {
  struct Buffers {
    std::vector<double> points_m, gaps_m;
  };
  return [scene, buffers = std::make_shared<Buffers>()](const Grip& grip, std::vector<FoundContact>& found) {
    buffers->points_m.clear();
    buffers->gaps_m.clear();
    for (const Isometry3d& X : grip) {
      const Eigen::Matrix3d R = X.linear();
      const Vector3d t = X.translation();
      scene->collide(R.data(), t.data(), buffers->points_m, buffers->gaps_m);
    }
    for (std::size_t i = 0; i < buffers->gaps_m.size(); ++i) {
      found.push_back({Eigen::Map<const Vector3d>(&buffers->points_m[3 * i]), buffers->gaps_m[i]});
    }
  };
}

FindingMethod fcl_sphere(const KnownObject& object, const Matrix3Xd&, const GripTask&) {
  FindingMethod method;
  method.lacks =
      "gaps before contact, the contacts of the pulp's points: one a triangle, with the depth along the sphere's "
      "radius";
  auto scene = made_ready(method, [&] { return fcl_scene(object.mesh); });
  scene->set_finger(kPulpRadius_m);
  method.find = fcl_collisions(scene);
  return method;
}

FindingMethod fcl_meshes(const KnownObject& object, const Matrix3Xd&, const GripTask&) {
  constexpr Index kFrequency = 15;  // 2252 corners: as fine as the pulp's 2400 samples.
  FindingMethod method;
  method.lacks = "gaps before contact, and the pressed patch: only where the two surfaces cut each other";
  auto scene = made_ready(method, [&] { return fcl_scene(object.mesh); });
  TriangleMesh pulp = geodesic_sphere(kFrequency);
  pulp.vertices_m *= kPulpRadius_m;
  scene->set_finger(numbers(pulp.vertices_m), numbers(pulp.triangles));
  method.find = fcl_collisions(scene);
  return method;
}

// --- Bullet, in millimetres: its tolerances are made for sizes about 1 ----------------------------------------------

btVector3 in_mm(const Vector3d& p_m) { return {1e3 * p_m.x(), 1e3 * p_m.y(), 1e3 * p_m.z()}; }
Vector3d in_m(const btVector3& p_mm) { return 1e-3 * Vector3d(p_mm.x(), p_mm.y(), p_mm.z()); }

btTransform in_mm(const Isometry3d& X) {
  const Eigen::Matrix3d& R = X.linear();
  return btTransform(btMatrix3x3(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
                     in_mm(X.translation()));
}

struct BulletScene {
  explicit BulletScene(const TriangleMesh& m) {
    for (Index i = 0; i < m.triangles.cols(); ++i) {
      const Eigen::Vector3i t = m.triangles.col(i);
      triangles.addTriangle(in_mm(m.vertices_m.col(t[0])), in_mm(m.vertices_m.col(t[1])),
                            in_mm(m.vertices_m.col(t[2])));
    }
    mesh = std::make_unique<btBvhTriangleMeshShape>(&triangles, true);
    mesh->setMargin(0.0);
    object.setCollisionShape(mesh.get());
    finger.setCollisionShape(&sphere);
    world.addCollisionObject(&object);
    world.addCollisionObject(&finger);
  }
  ~BulletScene() {
    world.removeCollisionObject(&finger);
    world.removeCollisionObject(&object);
  }
  BulletScene(const BulletScene&) = delete;
  BulletScene& operator=(const BulletScene&) = delete;

  btTriangleMesh triangles;
  std::unique_ptr<btBvhTriangleMeshShape> mesh;
  btSphereShape sphere{1e3 * kPulpRadius_m};
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btCollisionWorld world{&dispatcher, &broadphase, &configuration};
  btCollisionObject object, finger;
};

struct EveryPoint : btCollisionWorld::ContactResultCallback {
  EveryPoint(double band_m, std::vector<FoundContact>& to) : most_m(band_m), found(to) {
    m_closestDistanceThreshold = 1e3 * band_m;
  }
  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    const double gap_m = 1e-3 * point.getDistance();
    if (gap_m < most_m) found.push_back({in_m(point.getPositionWorldOnA()), gap_m});
    return 0.0;
  }
  double most_m;
  std::vector<FoundContact>& found;
};

FindingMethod bullet_sphere(const KnownObject& object, const Matrix3Xd&, const GripTask& task) {
  FindingMethod method;
  method.lacks = "the contacts of the pulp's points: one a triangle, with the depth along the sphere's radius";
  auto scene = made_ready(method, [&] { return std::make_shared<BulletScene>(object.mesh); });
  method.find = [scene, task](const Grip& grip, std::vector<FoundContact>& found) {
    EveryPoint every(task.band_m, found);
    for (const Isometry3d& X : grip) {
      scene->finger.setWorldTransform(in_mm(X));
      scene->world.contactPairTest(&scene->finger, &scene->object, every);
    }
  };
  return method;
}

FindingMethod bullet_hulls(const KnownObject& object, const Matrix3Xd& controls_m, const GripTask& task) {
  struct Shapes {
    Shapes(const Vector3d& size_m, const Matrix3Xd& controls) : box(in_mm(0.5 * size_m)) {
      for (Index i = 0; i < controls.cols(); ++i) pulp.addPoint(in_mm(controls.col(i)), false);
      pulp.recalcLocalAabb();
      pulp.setMargin(0.0);
      box.setMargin(0.0);
    }
    btConvexHullShape pulp;
    btBoxShape box;
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver depth;
  };
  FindingMethod method;
  method.lacks = "the patch: one point a finger; objects that are not convex";
  auto shapes = made_ready(method, [&] { return std::make_shared<Shapes>(*object.box_m, controls_m); });
  method.find = [shapes, task](const Grip& grip, std::vector<FoundContact>& found) {
    for (const Isometry3d& X : grip) {
      btGjkPairDetector detector(&shapes->pulp, &shapes->box, &shapes->simplex, &shapes->depth);
      btGjkPairDetector::ClosestPointInput input;
      input.m_transformA = in_mm(X);
      input.m_transformB.setIdentity();
      btPointCollector nearest;
      detector.getClosestPoints(input, nearest, nullptr);
      const double gap_m = 1e-3 * nearest.m_distance;
      if (!nearest.m_hasResult || gap_m >= task.band_m) continue;
      found.push_back({in_m(nearest.m_pointInWorld + nearest.m_distance * nearest.m_normalOnBInWorld), gap_m});
    }
  };
  return method;
}

}  // namespace

std::vector<FindingRecipe> finding_peers(bool box) {
  std::vector<FindingRecipe> peers{
      {"nanoflann, 16 neighbours", nanoflann_finding, true}, {"FCL distance, points and mesh", fcl_distances, true},
      {"FCL collide, sphere and mesh", fcl_sphere, false},   {"FCL collide, mesh and mesh", fcl_meshes, false},
      {"Bullet, sphere and mesh", bullet_sphere, false},
  };
  if (box) peers.push_back({"Bullet GJK + EPA, hull and box", bullet_hulls, false});
  return peers;
}

}  // namespace thenar
