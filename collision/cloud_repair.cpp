#include "collision/cloud_repair.h"

#include <algorithm>
#include <vector>

#include "collision/point_grid.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// What the samples near a sample's tangent plane say of its normal: 1 right, -1 to be turned, 0 divided.
double vote(const PointCloud& cloud, const PointGrid& grid, Index candidate, double support_m) {
  // Voters live within 1.5 h, some 35 on a face and 9 in a corner, and within 0.1 h = 0.22 spacings of the plane: the
  // other side of a plate has no say. Nor has the other side of an edge, where the cosine is 0.
  const double radius_m = 1.5 * support_m, height_m = 0.1 * support_m;
  const Vector3d p = cloud.points_m.col(candidate), n = cloud.normals.col(candidate);
  double all = 1.0, ayes = 1.0;  // the candidate's own vote
  grid.for_each_neighbour(candidate, [&](Index j, double distance_m) {
    const double near = 1.0 - distance_m * distance_m / (radius_m * radius_m);
    const double height = (cloud.points_m.col(j) - p).dot(n) / height_m;
    const double level = std::max(0.0, 1.0 - height * height);
    const double cosine = cloud.normals.col(j).dot(n);
    ayes += near * level * cosine;
    all += near * level * std::abs(cosine);
  });
  // Divided: a majority of less than two to one.
  return ayes > all / 3.0 ? 1.0 : ayes < -all / 3.0 ? -1.0 : 0.0;
}

}  // namespace

CloudRepair repair(PointCloud& cloud, double support_m) {
  const PointGrid grid(cloud.points_m, 1.5 * support_m);
  // Everybody votes before anybody is turned: the result does not depend on the order.
  Eigen::VectorXd verdicts(cloud.points_m.cols());
  for (Index i = 0; i < verdicts.size(); ++i) verdicts[i] = vote(cloud, grid, i, support_m);

  CloudRepair report;
  std::vector<Index> kept;
  kept.reserve(verdicts.size());
  for (Index i = 0; i < verdicts.size(); ++i) {
    if (verdicts[i] < 0.0) {
      ++report.turned;
      cloud.normals.col(i) *= -1.0;
    }
    if (verdicts[i] == 0.0) {
      ++report.removed;
    } else {
      kept.push_back(i);
    }
  }
  report.doubtful_share = static_cast<double>(report.turned + report.removed) / static_cast<double>(verdicts.size());
  if (report.removed > 0) cloud = {cloud.points_m(Eigen::all, kept), cloud.normals(Eigen::all, kept)};
  return report;
}

}  // namespace thenar
