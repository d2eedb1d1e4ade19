// SPDX-License-Identifier: Apache-2.0
// What could be left out of the compliance among many contacts: near ones exact, far ones by clusters.

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "bench/report/figure.h"
#include "engine/grasp/pulp.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix2Xd;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using nlohmann::ordered_json;

/// Contacts of a flat patch, evenly spread and a millimetre apart.
Matrix2Xd patch_m(Index contacts) {
  Matrix2Xd p_m(2, contacts);
  const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (Index i = 0; i < contacts; ++i) {
    const double radius_m = 1e-3 * std::sqrt((static_cast<double>(i) + 0.5) / std::numbers::pi);
    p_m.col(i) = radius_m * Vector2d(std::cos(turn * static_cast<double>(i)), std::sin(turn * static_cast<double>(i)));
  }
  return p_m;
}

/// k_ij of the half space among them.
MatrixXd kernel(const Matrix2Xd& p_m) {
  constexpr double kArea_m2 = 1e-6;
  const PulpMaterial material{.reduced_modulus_Pa = 0.24e6};
  MatrixXd k(p_m.cols(), p_m.cols());
  for (Index j = 0; j < k.cols(); ++j) {
    for (Index i = 0; i < k.rows(); ++i) {
      k(i, j) = half_space_kernel(material, (p_m.col(i) - p_m.col(j)).squaredNorm(), kArea_m2, kArea_m2);
    }
  }
  return k;
}

/// Numbers that a hierarchical matrix holds [Hackbusch 1999]: clusters by halves of a box; pairs of them that are no
/// nearer than the smaller one is wide by singular vectors, which no other expansion in products does with fewer.
struct Compression {
  const Matrix2Xd& p_m;
  const MatrixXd& k;
  double least;  ///< Singular values below it are left out.
  Index leaf;
  double numbers = 0.0;

  using Cluster = std::vector<Index>;

  [[nodiscard]] Eigen::AlignedBox2d box(const Cluster& cluster) const {
    Eigen::AlignedBox2d all;
    for (const Index i : cluster) all.extend(Vector2d(p_m.col(i)));
    return all;
  }

  [[nodiscard]] std::pair<Cluster, Cluster> halves(Cluster cluster) const {
    Index axis = 0;
    box(cluster).sizes().maxCoeff(&axis);
    const auto middle = cluster.begin() + std::ssize(cluster) / 2;
    std::nth_element(cluster.begin(), middle, cluster.end(),
                     [&](Index a, Index b) { return p_m(axis, a) < p_m(axis, b); });
    return {Cluster(cluster.begin(), middle), Cluster(middle, cluster.end())};
  }

  void count(const Cluster& rows, const Cluster& columns) {
    const auto whole = static_cast<double>(rows.size() * columns.size());
    const Eigen::AlignedBox2d box_r = box(rows), box_c = box(columns);
    const double width_m = std::min(box_r.diagonal().norm(), box_c.diagonal().norm());
    if (box_r.exteriorDistance(box_c) >= width_m) {
      const MatrixXd block = k(rows, columns);
      const double rank =
          static_cast<double>((Eigen::JacobiSVD<MatrixXd>(block).singularValues().array() > least).count());
      numbers += std::min(whole, rank * static_cast<double>(rows.size() + columns.size()));
      return;
    }
    if (std::ssize(rows) <= leaf || std::ssize(columns) <= leaf) {
      numbers += whole;
      return;
    }
    const auto [r1, r2] = halves(rows);
    const auto [c1, c2] = halves(columns);
    for (const Cluster* r : {&r1, &r2}) {
      for (const Cluster* c : {&c1, &c2}) count(*r, *c);
    }
  }
};

/// The share of all numbers that are held at the best of four sizes of the smallest clusters.
double least_share(Index contacts, double error) {
  const Matrix2Xd p_m = patch_m(contacts);
  const MatrixXd k = kernel(p_m);
  const double largest = Eigen::SelfAdjointEigenSolver<MatrixXd>(k, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
  std::vector<Index> all(contacts);
  for (Index i = 0; i < contacts; ++i) all[i] = i;
  double share = 1.0;
  for (const Index leaf : {4, 8, 16, 32}) {
    Compression compression{p_m, k, error * largest, leaf};
    compression.count(all, all);
    share = std::min(share, compression.numbers / static_cast<double>(k.size()));
  }
  return share;
}

void compression(ordered_json& part, bool quick) {
  std::vector<Index> sizes{20, 50, 100, 200, 400};
  if (!quick) sizes.insert(sizes.end(), {800, 1600});
  ordered_json& figure = add_figure(
      part, "curves", "compression", "What compression could leave of a patch's compliance",
      "Near contacts exact, far ones by clusters: at a residual of 1e-6 nothing of it pays below some 400 contacts of "
      "one patch, where a fingertip has 20 and the largest of ours 100 to 200; so the compliance stays whole. At an "
      "error of 1 % something is left out from 50 on, but a coarser level of detail leaves more out for it: half of "
      "the control points leave a quarter of the numbers. Of the kernel of a half space among evenly spread contacts: "
      "how many numbers a hierarchical matrix must hold at the least, with the best rank of every pair of clusters and "
      "the best size of the smallest; the error is that of each pair, of the largest eigenvalue.",
      "computed, not timed");
  figure["x"] = {{"label", "contacts of one patch"}, {"log", true}};
  figure["y"] = {{"label", "numbers that are left, of all [%]"}, {"log", true}};
  ordered_json curves = ordered_json::array();
  for (const double error : {1e-2, 1e-4, 1e-6}) {
    std::vector<double> x, y;
    for (const Index size : sizes) {
      x.push_back(static_cast<double>(size));
      y.push_back(100.0 * least_share(size, error));
    }
    curves.push_back(curve(fmt::format("error {:.0e}", error), x, y));
  }
  figure["panels"] = {{{"name", "half space"}, {"curves", curves}}};
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(argc, argv, "compression", "Compression",
                  "A contact solve grows with the square of a patch's contacts, for each of them moves all others. "
                  "Hierarchical matrices hold less: how much less, for so many contacts, and at what error?",
                  {compression});
}
