// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/run_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace thenar {

namespace {

constexpr std::string_view kMagic = "thenar state";
constexpr std::uint32_t kFormat = 3;

/// The hash FNV-1a, by words of eight bytes where possible.
class Hash {
 public:
  void add(const void* data, std::size_t size) {
    const char* at = static_cast<const char*>(data);
    for (std::uint64_t word = 0; size > 0; word = 0) {
      const std::size_t some = std::min(size, sizeof word);
      std::memcpy(&word, at, some);
      value_ = (value_ ^ word ^ (some << 56U)) * 0x100000001b3U;
      value_ ^= value_ >> 32U;
      at += some;
      size -= some;
    }
  }
  template <typename T>
  requires std::is_arithmetic_v<T>
  void add(const T& number) { add(&number, sizeof number); }
  template <typename Derived>
  void add(const Eigen::PlainObjectBase<Derived>& matrix) {
    add(matrix.rows());
    add(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(typename Derived::Scalar));
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

}  // namespace

std::uint64_t state_fingerprint(const Model& model, bool is_lockstep) {
  const Scene& scene = model.scene;
  Hash hash;
  hash.add(is_lockstep);
  for (const double time_s : {scene.step_s, scene.control_period_s, scene.control_delay_s}) hash.add(time_s);
  for (const Joint& joint : scene.hand.joints) {
    hash.add(joint.origin_m);
    hash.add(joint.axis);
  }
  for (const std::size_t count :
       {scene.hand.fingertips.size(), scene.hand.joints.size(), scene.hand.followers.size(), scene.hand.muscles.size(),
        scene.task.phases.size(), scene.environment ? scene.environment->bodies.size() : 0}) {
    hash.add(count);
  }
  for (const bool part :
       {scene.control.has_value(), scene.has_muscles(), scene.muscles_act(), scene.chooses_stiffness(),
        scene.environment.has_value(), model.feels(), model.soft_object()}) {
    hash.add(part);
  }
  hash.add(model.max_contacts);
  for (const Pulp& pulp : model.pulps) hash.add(pulp.control_points_m);
  hash.add(model.object.cloud().points_m);
  return hash.value();
}

std::string sealed_state(std::uint64_t fingerprint, const std::string& members) {
  StateWriter head;
  Hash hash;
  hash.add(members.data(), members.size());
  std::uint64_t size = members.size(), sum = hash.value();
  std::uint32_t format = kFormat;
  head.raw(kMagic.data(), kMagic.size());
  head(format, fingerprint, size, sum);
  return head.bytes + members;
}

std::string_view opened_state(std::uint64_t fingerprint, std::string_view bytes) {
  if (!bytes.starts_with(kMagic)) throw std::invalid_argument("these bytes are no state of a simulation");
  bytes.remove_prefix(kMagic.size());
  std::uint32_t format = 0;
  std::uint64_t of = 0, size = 0, sum = 0;
  const auto take = [&](auto& number) {
    if (bytes.size() < sizeof number) throw std::invalid_argument("the state is not whole");
    std::memcpy(&number, bytes.data(), sizeof number);
    bytes.remove_prefix(sizeof number);
  };
  take(format);
  if (format != kFormat) {
    throw std::invalid_argument(fmt::format("the state has format {}, and this thenar reads {}", format, kFormat));
  }
  take(of);
  if (of != fingerprint) {
    throw std::invalid_argument(
        "the state is of another scene: hand, object, points, steps, parts and lockstep have to be the same");
  }
  take(size);
  take(sum);
  if (bytes.size() != size) throw std::invalid_argument("the state is not whole");
  Hash hash;
  hash.add(bytes.data(), bytes.size());
  if (hash.value() != sum) throw std::invalid_argument("the state is damaged");
  return bytes;
}

std::string state_of(const GraspRun& run) {
  Run copy = run;
  StateWriter writer;
  writer(copy);
  return sealed_state(state_fingerprint(run.model, run.is_lockstep()), writer.bytes);
}

void set_state(std::string_view bytes, GraspRun& run) {
  StateReader reader(opened_state(state_fingerprint(run.model, run.is_lockstep()), bytes), run.model);
  Run read(run.model);
  reader(read);
  StateReader::require(reader.left() == 0);
  read.controller.own = run.controller.own;
  run.go_on_as(read);
}

}  // namespace thenar
