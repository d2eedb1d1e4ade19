// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/curved_files.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

namespace thenar {
namespace {

using Eigen::Vector3d;

constexpr double kTurn = 2.0 * std::numbers::pi;

/// Parts of a circle whose chords are off it by so much in their middle.
int parts_of(double radius_m, double chord_m) {
  return std::max(6, static_cast<int>(std::ceil(std::numbers::pi / std::acos(1.0 - chord_m / radius_m))));
}

class ObjFile {
 public:
  explicit ObjFile(const std::filesystem::path& obj) : file_(obj) { file_.precision(17); }
  int corner(const Vector3d& p_m) {
    file_ << "v " << p_m[0] << ' ' << p_m[1] << ' ' << p_m[2] << '\n';
    return ++corners_;
  }
  void triangle(int a, int b, int c) { file_ << "f " << a << ' ' << b << ' ' << c << '\n'; }
  /// Counter-clockwise from outside.
  void quad(int a, int b, int c, int d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }

 private:
  std::ofstream file_;
  int corners_ = 0;
};

}  // namespace

void write_rod_mesh(const std::filesystem::path& obj, double radius_m, double length_m, double chord_m) {
  ObjFile file(obj);
  const int around = parts_of(radius_m, chord_m);
  for (const double z_m : {-0.5 * length_m, 0.5 * length_m}) {
    for (int i = 0; i < around; ++i) {
      const double angle = kTurn * i / around;
      file.corner({radius_m * std::cos(angle), radius_m * std::sin(angle), z_m});
    }
  }
  const int lower = file.corner({0.0, 0.0, -0.5 * length_m}), upper = file.corner({0.0, 0.0, 0.5 * length_m});
  for (int i = 0; i < around; ++i) {
    const int a = i + 1, b = (i + 1) % around + 1;
    file.quad(a, b, b + around, a + around);
    file.triangle(lower, b, a);
    file.triangle(upper, a + around, b + around);
  }
}

void write_ring_mesh(const std::filesystem::path& obj, double ring_m, double rod_m, double chord_m) {
  ObjFile file(obj);
  const int along = parts_of(ring_m + rod_m, chord_m), around = parts_of(rod_m, chord_m);
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < around; ++j) {
      const double u = kTurn * i / along, v = kTurn * j / around, out_m = ring_m + rod_m * std::cos(v);
      file.corner({out_m * std::cos(u), out_m * std::sin(u), rod_m * std::sin(v)});
    }
  }
  const auto at = [&](int i, int j) { return i % along * around + j % around + 1; };
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < around; ++j) file.quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  }
}

void write_rod_scan(const std::filesystem::path& xyz, double radius_m, double length_m, double spacing_m,
                    double noise_m, std::uint64_t seed) {
  std::ofstream file(xyz);
  file.precision(10);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto point = [&](const Vector3d& p_m, const Vector3d& n) {
    const Vector3d x_m = p_m + noise_m * normal(random) * n;
    file << x_m.transpose() << ' ' << n.transpose() << '\n';
  };
  // Spirals of the golden ratio keep them even.
  const double golden = std::numbers::phi - 1.0;
  const auto side = static_cast<int>(kTurn * radius_m * length_m / (spacing_m * spacing_m));
  for (int i = 0; i < side; ++i) {
    const double angle = kTurn * golden * i;
    const Vector3d n(std::cos(angle), std::sin(angle), 0.0);
    point(radius_m * n + length_m * ((i + 0.5) / side - 0.5) * Vector3d::UnitZ(), n);
  }
  const auto end = static_cast<int>(0.5 * kTurn * radius_m * radius_m / (spacing_m * spacing_m));
  for (const double up : {-1.0, 1.0}) {
    for (int i = 0; i < end; ++i) {
      const double out_m = radius_m * std::sqrt((i + 0.5) / end), angle = kTurn * golden * i;
      point({out_m * std::cos(angle), out_m * std::sin(angle), 0.5 * up * length_m}, up * Vector3d::UnitZ());
    }
  }
}

}  // namespace thenar
