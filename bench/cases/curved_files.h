// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

/// Files, in metres, of surfaces that are known by a formula: as triangles with corners on the surface, and as a
/// scanner would have them.
namespace thenar {

/// A cylinder about z, whose facets are off it by `chord_m` at most.
void write_rod_mesh(const std::filesystem::path& obj, double radius_m, double length_m, double chord_m);

/// A torus about z: a rod of this radius, bent to a ring. Facets are off it by about `chord_m` each way.
void write_ring_mesh(const std::filesystem::path& obj, double ring_m, double rod_m, double chord_m);

/// Points of a cylinder about z with their normals, a spacing apart, each off along its normal by an error with this
/// standard deviation.
void write_rod_scan(const std::filesystem::path& xyz, double radius_m, double length_m, double spacing_m,
                    double noise_m, std::uint64_t seed);

}  // namespace thenar
