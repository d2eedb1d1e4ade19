// SPDX-License-Identifier: Apache-2.0
#include "bench/truth/peers/peer.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <utility>

namespace thenar::truth {
namespace {

using nlohmann::json;

/// A wrench that follows a polygon in time.
struct Load {
  Vector force_N, moment_Nm;
  std::vector<double> times_s, factors;

  [[nodiscard]] double factor(double time_s) const {
    const auto next = std::ranges::upper_bound(times_s, time_s);
    if (next == times_s.begin()) return factors.front();
    if (next == times_s.end()) return factors.back();
    const std::size_t k = next - times_s.begin();
    const double share = (time_s - times_s[k - 1]) / (times_s[k] - times_s[k - 1]);
    return factors[k - 1] + share * (factors[k] - factors[k - 1]);
  }
};

Shape shape_of(const json& shape) {
  const auto& [kind, size] = *shape.items().begin();
  if (kind == "sphere") return {Shape::Kind::kSphere, {size, size, size}, {}};
  if (kind == "box") return {Shape::Kind::kBox, {size[0], size[1], size[2]}, {}};
  if (kind == "capsule") return {Shape::Kind::kCapsule, {size[0], size[1], size[0]}, {}};
  return {Shape::Kind::kFile, {}, size};
}

WorldData world_of(const json& world) {
  WorldData data{shape_of(world["shape"]),
                 world["mass"],
                 world["friction"],
                 world["step"],
                 world["at"],
                 world["attitude"],
                 {},
                 {},
                 world["finger_mass"],
                 world["finger_damping"],
                 world["damping"],
                 world["setting"]};
  for (const json& f : world["fingers"]) data.fingers.push_back({f["at"], f["along"], f["radius"], f["force"]});
  for (const json& w : world["walls"]) data.walls.push_back({w["at"], w["half"]});
  return data;
}

std::vector<Load> loads_of(const json& world) {
  std::vector<Load> loads;
  for (const json& l : world["loads"]) loads.push_back({l["force"], l["moment"], l["times"], l["factors"]});
  return loads;
}

double distance(const Vector& a, const Vector& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

/// What became of a world: rows of doubles, and how the engine was built.
struct Answer {
  std::vector<double> rows;
  json build;
};

/// Runs a world. Its rows: place, attitude, kinetic and stored energy, contacts, the time that the step took
/// [us], and how far each finger has gone.
Answer answer_to(const json& asked) {
  using Clock = std::chrono::steady_clock;
  const WorldData data = world_of(asked);
  const std::vector<Load> loads = loads_of(asked);
  const auto steps = std::lround(asked["duration"].get<double>() / data.step_s);
  const double lost_m = asked["lost"];
  const std::unique_ptr<World> world = make_world(data);
  std::vector<double> rows;
  for (long i = 0; i < steps; ++i) {
    Vector force{}, moment{};
    for (const Load& load : loads) {
      const double factor = load.factor(static_cast<double>(i) * data.step_s);
      for (int k = 0; k < 3; ++k) {
        force[k] += factor * load.force_N[k];
        moment[k] += factor * load.moment_Nm[k];
      }
    }
    const auto from = Clock::now();
    world->step(force, moment);
    const double us = std::chrono::duration<double, std::micro>(Clock::now() - from).count();
    const Reading r = world->read();
    rows.insert(rows.end(), {r.at_m[0], r.at_m[1], r.at_m[2], r.attitude[0], r.attitude[1], r.attitude[2],
                             r.attitude[3], r.kinetic_J, r.stored_J, static_cast<double>(r.contacts), us});
    for (std::size_t k = 0; k < data.fingers.size(); ++k) rows.push_back(world->travel_m(k));
    // What has fallen away, or is no number, needs no further steps.
    if (!(distance(r.at_m, data.at_m) < lost_m)) break;
  }
  return {std::move(rows), world->build()};
}

}  // namespace

Vector WorldData::inertia() const {
  const double m = mass_kg, a = shape.half_m[0], b = shape.half_m[1], c = shape.half_m[2];
  switch (shape.kind) {
    case Shape::Kind::kSphere:
      return {0.4 * m * a * a, 0.4 * m * a * a, 0.4 * m * a * a};
    case Shape::Kind::kCapsule: {
      // A cylinder of the radius a and the length 2 b, and a ball in two halves at its ends.
      const double ball = m * (4.0 / 3.0 * a) / (4.0 / 3.0 * a + 2.0 * b), rod = m - ball;
      const double along = 0.5 * rod * a * a + 0.4 * ball * a * a;
      const double across = rod * (0.25 * a * a + b * b / 3.0) + ball * (0.4 * a * a + b * b + 0.75 * a * b);
      return {across, along, across};
    }
    default:
      return {m / 3.0 * (b * b + c * c), m / 3.0 * (a * a + c * c), m / 3.0 * (a * a + b * b)};
  }
}

/// Answers each line of standard input, a world as JSON, by a line {"engine", "rows", "columns", "build"} and the rows
/// as doubles, or by a line {"error"}.
int answer() {
  // Engines print to standard output what is no answer: that goes to standard error.
  std::FILE* const out = fdopen(dup(STDOUT_FILENO), "w");
  dup2(STDERR_FILENO, STDOUT_FILENO);
  const auto write_line = [&](const json& line) { std::fputs((line.dump() + '\n').c_str(), out); };
  for (std::string line; std::getline(std::cin, line);) {
    try {
      const json asked = json::parse(line);
      const auto [rows, build] = answer_to(asked);
      const std::size_t columns = 11 + asked["fingers"].size();
      write_line({{"engine", engine()}, {"rows", rows.size() / columns}, {"columns", columns}, {"build", build}});
      std::fwrite(rows.data(), sizeof(double), rows.size(), out);
    } catch (const std::exception& error) {
      write_line({{"error", error.what()}});
    }
    std::fflush(out);
  }
  return 0;
}

}  // namespace thenar::truth

int main() { return thenar::truth::answer(); }
