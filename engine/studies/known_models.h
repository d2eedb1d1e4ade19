// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>

#include "engine/grasp/model.h"

namespace thenar {

/// Models made lately, by whose parts others are loaded sooner: to sample an object and to find its edges takes a
/// second, to copy them some milliseconds. It holds one model for each of the last few surfaces. All functions may be
/// called by several threads at once.
class KnownModels {
 public:
  /// Loads a scene's model: that of load_model(scene), to the last bit. Where a model on the same surface is known, it
  /// has copies of the surface and of the fingertips; where the object's file has other bytes by now, nothing of it.
  /// Throws as load_model() does.
  [[nodiscard]] std::shared_ptr<const Model> load(const Scene& scene);

  static constexpr std::size_t kMostModels = 4;
  /// Of all their surfaces together; with about half a kilobyte each. The newest model stays, however large it is.
  static constexpr Eigen::Index kMostSamples = 400'000;

 private:
  struct Known {
    Scene asked;            ///< As it was loaded: a model's own scene may have fewer parts and fingers.
    std::size_t file_hash;  ///< Of the bytes of its object's file.
    std::shared_ptr<const Model> model;
    [[nodiscard]] bool has_surface_of(const Scene& scene, std::size_t hash) const;
  };

  [[nodiscard]] std::shared_ptr<const Model> like(const Scene& scene, std::size_t file_hash);
  void keep(Known made);

  std::mutex mutex_;
  std::deque<Known> known_;  // The newest first.
};

}  // namespace thenar
