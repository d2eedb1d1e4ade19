// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "bench/cases/scene_run.h"
#include "engine/grasp/model.h"
#include "engine/grasp/scene.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

std::filesystem::path config_file(const std::string& name);

Scene scene_of(const std::string& name, const std::vector<std::string>& overrides = {});

/// A flat face needs no more samples than this; it saves the tests' time.
inline const std::string kCoarseBox = "object.points=6000";

/// The box grasp as two threads run it: contact at 1 kHz, control at 200 Hz.
Scene split_scene();

bool is_finite(const State& state);

/// The thumb, which nothing moves, against a face of a box that turns as if it were clamped and that a constant
/// `force_C` on it (normal into the thumb negative, two tangents) moves: one pulp under a given load. `depth_m` is that
/// of the pulp's rest shape at the start, `translation_damping` the box's. The face lies on the side `normal_F` of the
/// pulp, distal frame; zero: where the pulp faces.
Scene pressed_thumb(double depth_m, const Eigen::Vector3d& force_C, double translation_damping,
                    const Eigen::Vector3d& normal_F = Eigen::Vector3d::Zero());

double uniform(std::mt19937_64& random, double low, double high);

Eigen::Vector3d random_direction(std::mt19937_64& random);

Eigen::Matrix3d random_rotation(std::mt19937_64& random);

/// A turn about a point that stays.
Eigen::Isometry3d random_rotation_about(const Eigen::Vector3d& point, std::mt19937_64& random);

}  // namespace thenar
