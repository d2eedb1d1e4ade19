#include "engine/finder/wrench_space.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "collision/blue_noise.h"
#include "solvers/grasp_forces.h"

namespace thenar {

using Eigen::Index;

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Points = Eigen::Matrix<double, 6, Eigen::Dynamic>;
constexpr int kEdges = 8;

/// A simplex of the hull's surface: points with n.x <= offset inside.
struct Facet {
  std::array<int, 6> corners;  ///< Ascending.
  Vector6d n;
  double offset;
};

std::optional<Facet> facet_of(const Points& points, std::array<int, 6> corners, const Vector6d& inside) {
  std::sort(corners.begin(), corners.end());
  Eigen::Matrix<double, 5, 6> edges;
  for (int i = 0; i < 5; ++i) edges.row(i) = (points.col(corners[i + 1]) - points.col(corners[0])).transpose();
  // The normal is what no edge has: the last column of a full orthogonal basis of their rows.
  const Eigen::ColPivHouseholderQR<Eigen::Matrix<double, 6, 5>> qr(edges.transpose());
  const Matrix6d Q = qr.householderQ();
  Facet facet{corners, Q.col(5), 0.0};
  facet.offset = facet.n.dot(points.col(corners[0]));
  const double height = facet.n.dot(inside) - facet.offset;
  if (std::abs(height) < 1e-13) return std::nullopt;
  if (height > 0.0) {
    facet.n = -facet.n;
    facet.offset = -facet.offset;
  }
  return facet;
}

/// Six edges from a first point that span the space, or nothing.
std::optional<std::array<int, 7>> first_simplex(const Points& points) {
  std::array<int, 7> simplex{};
  Eigen::Matrix<double, 6, Eigen::Dynamic> rest = points.colwise() - points.col(0);
  for (int i = 1; i < 7; ++i) {
    Index far = 0;
    const double length = std::sqrt(rest.colwise().squaredNorm().maxCoeff(&far));
    if (length < 1e-6) return std::nullopt;
    simplex[i] = static_cast<int>(far);
    const Vector6d d = rest.col(far) / length;
    rest -= (d * (d.transpose() * rest)).eval();
  }
  return simplex;
}

/// Replaces the facets that see the point by those of the cone from their horizon.
void add_point(const Points& points, int point, const Vector6d& inside, std::vector<Facet>& facets) {
  std::vector<std::array<int, 5>> ridges;
  std::vector<Facet> kept;
  for (const Facet& facet : facets) {
    if (facet.n.dot(points.col(point)) - facet.offset <= 1e-12) {
      kept.push_back(facet);
      continue;
    }
    for (int out = 0; out < 6; ++out) {
      std::array<int, 5> ridge{};
      for (int i = 0, j = 0; i < 6; ++i) {
        if (i != out) ridge[j++] = facet.corners[i];
      }
      ridges.push_back(ridge);
    }
  }
  std::sort(ridges.begin(), ridges.end());
  for (std::size_t i = 0; i < ridges.size();) {
    std::size_t same = i;
    while (same < ridges.size() && ridges[same] == ridges[i]) ++same;
    // A ridge between two facets that both go is no horizon.
    if (same - i == 1) {
      const auto& r = ridges[i];
      if (const auto facet = facet_of(points, {r[0], r[1], r[2], r[3], r[4], point}, inside)) kept.push_back(*facet);
    }
    i = same;
  }
  facets = std::move(kept);
}

}  // namespace

Hull6 hull6(const Points& all) {
  // Points in one plane would make facets of more than six corners: they are moved off it by less than counts.
  constexpr double kJoggle = 1e-7;
  Points points = all;
  Uniform uniform(1);
  const double size = points.cwiseAbs().maxCoeff();
  for (Index i = 0; i < points.size(); ++i) points(i) += kJoggle * size * (uniform() - 0.5);
  const auto simplex = first_simplex(points);
  if (!simplex) return {};
  Vector6d inside = Vector6d::Zero();
  for (const int i : *simplex) inside += points.col(i) / 7.0;
  std::vector<Facet> facets;
  for (int out = 0; out < 7; ++out) {
    std::array<int, 6> corners{};
    for (int i = 0, j = 0; i < 7; ++i) {
      if (i != out) corners[j++] = (*simplex)[i];
    }
    if (const auto facet = facet_of(points, corners, inside)) facets.push_back(*facet);
  }
  for (int i = 0; i < static_cast<int>(points.cols()); ++i) {
    if (std::find(simplex->begin(), simplex->end(), i) == simplex->end()) add_point(points, i, inside, facets);
  }
  Hull6 hull{.inradius = size * 10.0};
  for (const Facet& facet : facets) {
    hull.inradius = std::min(hull.inradius, facet.offset);
    Matrix6d corners;
    for (int i = 0; i < 6; ++i) corners.col(i) = points.col(facet.corners[i]) - inside;
    hull.volume += std::abs(corners.determinant()) / 720.0;  // 6!
  }
  hull.inradius = std::max(0.0, hull.inradius);
  if (hull.inradius < 10.0 * kJoggle * size) hull.inradius = 0.0;
  return hull;
}

GraspQuality grasp_quality(std::span<const GraspContact> contacts, const Eigen::Vector3d& centre_m, double friction,
                           double lever_m) {
  const Index n = std::ssize(contacts);
  Eigen::MatrixXd G(6, 3 * n);
  grasp_map(contacts, centre_m, G);
  G.bottomRows<3>() /= lever_m;
  Points points(6, kEdges * n);
  for (Index k = 0; k < n; ++k) {
    for (int e = 0; e < kEdges; ++e) {
      const double angle = 2.0 * std::numbers::pi * e / kEdges;
      const Eigen::Vector3d f_C(1.0, friction * std::cos(angle), friction * std::sin(angle));
      points.col(kEdges * k + e) = G.middleCols<3>(3 * k) * (contacts[k].axes * f_C);
    }
  }
  GraspQuality quality;
  const Hull6 hull = hull6(points);
  quality.epsilon = hull.inradius;
  quality.volume = hull.volume;
  const Eigen::VectorXd sigma = Eigen::JacobiSVD<Eigen::MatrixXd>(G).singularValues();
  if (sigma.size() == 6 && sigma[0] > 0.0) quality.isotropy = sigma[5] / sigma[0];
  return quality;
}

}  // namespace thenar
