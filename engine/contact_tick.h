#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "engine/frame.h"
#include "engine/model.h"
#include "engine/state.h"
#include "solvers/gauss_seidel.h"

namespace thenar {

/// What the caller of a contact tick brings: the place of a haptic device.
struct TickInput {
  Vector6d wrench = Vector6d::Zero();     ///< On the object beside the frame's, about its centre, world axes [N, N m].
  std::optional<Eigen::Isometry3d> X_WT;  ///< Where the object should be from now on; nothing: where the task has it.
};

/// What the contact tick does about frames that are noisy, late or lost. The default trusts every frame for ever, as a
/// loop may that makes one for each of its control periods itself.
struct FramePolicy {
  double offset_decay_s = 0.0;  ///< tau_e of the gap offset at a hand-over; 0: no offset.
  double hold_after_s = std::numeric_limits<double>::infinity();  ///< Age of a frame from which its drive is held.
};

/// For frames from another thread: tau_e is a control period, and a frame more than three of them older than
/// expected is too old. Without control the torques are given and do not age.
[[nodiscard]] FramePolicy split_policy(const Scene& scene);

/// What one contact tick returns by value.
struct TickReport {
  SolveReport solve;
  std::int64_t sequence = -1;             ///< Of the frame used.
  std::int64_t frame_age = 0;             ///< Steps from the frame's snapshot to this tick's start.
  bool handed_over = false;               ///< The frame is new.
  bool held = false;                      ///< The frame is too old or too far off: its drive is held.
  bool input_refused = false;             ///< The input was not finite, and was left out.
  double injected_J = 0.0, dissipated_J = 0.0;  ///< Passivity ledger: contact work on the bodies, by its sign.
  Eigen::Index contacts = 0;
  Eigen::Index active = 0;                ///< Contacts that carry force.
  double penetration_m = 0.0;             ///< Deepest deformed gap of a contact.
  std::array<double, kFingers> slip_m{};  ///< Smallest |delta_t| among a finger's loaded contacts; 0 without any.
  double assemble_s = 0.0;                ///< 0 if the frame was known.
  double solve_s = 0.0;                   ///< Free motion, Gauss-Seidel and commit.
  double deform_s = 0.0;                  ///< 0 for rigid fingertips.
};

/// What one contact tick works in, and what it keeps from tick to tick beside the state: room for the model's most
/// contacts, taken once. It serves one run: it knows a frame by its sequence number.
class ContactWorkspace {
 public:
  explicit ContactWorkspace(const Model& model, const FramePolicy& policy = {});

  /// The operator and vectors of n contacts.
  [[nodiscard]] Eigen::Map<Eigen::MatrixXd> W(Eigen::Index n) { return {W_.data(), 3 * n, 3 * n}; }

  std::int64_t sequence = -1;  ///< Of the frame that W and f belong to.
  Eigen::VectorXd delta_free, delta, f, mu;
  Eigen::MatrixX3d kernel_sum;  ///< Control points x 3.
  HandPose pose;

 private:
  Eigen::VectorXd W_;
};

/// Carries forces to the contacts of a frame by finger and control point; both lists are sorted. Tangents are carried
/// by parallel transport, so the components keep their meaning, and the cone is the same. f: out, 3 rows a contact.
void carry_forces(const Frame& frame, const std::vector<ContactForce>& forces, Eigen::VectorXd& f);

/// Advances the state by one step h of the contact loop on a frozen frame.
///
/// 1. Free motion of the rigid bodies, h B^-1 (tau - g, W_ext), and of the pulps, u* = rho u.
/// 2. delta_free: gaps, absolute, from the body-fixed geometry at the state; slips, relative to the tick. The bodies' free
///    motion enters through J_c, as the contact motion does, so that what contact forbids cancels to the last bit.
/// 3. Contact forces by Gauss-Seidel on W(h), formed when the frame is new, from the forces of the last tick.
/// 4. Commit: (q, x) moves by h B^-1 (drive + J_c' f), u = rho u + (1 - rho) C f.
///
/// After the first call on a state it does not allocate. It does not lock, log or throw.
TickReport contact_tick(const Model& model, const Frame& frame, ContactWorkspace& work, State& state,
                        const TickInput& input = {}) noexcept;

}  // namespace thenar
