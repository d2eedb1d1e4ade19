// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/loops/known_stiffness.h"
#include "engine/loops/picture.h"
#include "engine/loops/shown_environment.h"
#include "engine/results/loop_figures.h"
#include "engine/results/recording.h"

/// Fields of a tick, described once: a row a field. State messages, recordings, their columns, signals.csv,
/// Python's views, rollout() and state(), and the tables of the reference are made of these rows.
namespace thenar {

/// Owner of a field's numbers: determines their count, the names of their columns, and their shape and type in Python.
enum class Of : std::uint8_t {
  kNumber,
  kCount,       ///< One whole number.
  kFlag,        ///< 0 or 1.
  kAxis,        ///< x, y, z.
  kPose,        ///< Position, then rotation by rows: 12 numbers; in Python a matrix of 4 x 4.
  kFinger,      ///< One a finger.
  kFingerAxis,  ///< Three a finger.
  kBodyAxis,    ///< Three a body of the environment.
  kJoint,
  kMuscle,
  kPercentile,  ///< p50, p99, p99.9.
  kList,        ///< Numbered from 0.
  kShape,       ///< For display alone, without columns.
};

/// Source that a field needs.
enum class From : std::uint8_t {
  kTick,     ///< The record of the tick.
  kClock,    ///< The record too, but different from run to run.
  kState,    ///< The known part of a chosen stiffness, and the state.
  kPicture,  ///< The picture made for display.
  kLoops,    ///< The loops' own measures, by the clock on the wall.
};

/// View of an instant for the fields. Null members are not available.
struct TickView {
  const Model& model;
  const TickRecord& tick;
  std::int64_t number;  ///< Number of the tick.
  const JointVector& q;
  const Eigen::Isometry3d& X_WO;
  const PerFinger<FingerLoad>& load;
  std::span<const double> muscle_N;  ///< Forces that act; empty for a scene without muscles.
  std::span<const double> asked_N;   ///< Forces asked for; read for a scene whose muscles act on the contact side.
  const ShownStiffness* stiffness = nullptr;
  const Picture* picture = nullptr;
  const ShownEnvironment* environment = nullptr;
  const LoopFigures* loops = nullptr;
};

/// Returns the view of a record, all else of it in memory that the record owns.
[[nodiscard]] TickView view_of(const Model& model, const TickRecord& tick, std::span<const double> muscle_N,
                               std::span<const double> asked_N = {});

/// Numbers that lie in a view's memory: `rows` times `columns` next to one another, from row to row `stride` numbers.
struct FieldNumbers {
  const double* first = nullptr;
  Eigen::Index rows = 1, columns = 1, stride = 1;
};

/// Scenes that have a field.
struct Scenes {
  bool (*have)(const Model&);
  std::string_view which;  ///< "of scenes with an environment".
};

/// Those whose fingertips feel. \hideinitializer
inline constexpr Scenes kFeelingScenes{[](const Model& model) { return model.feels(); },
                                       "of scenes with `fingertips.touch`"};

/// Place of a field's columns in signals.csv: those of a block together, finger by finger.
enum class Block : std::uint8_t {
  kTime,
  kPath,
  kGrip,
  kJoints,
  kSolve,
  kMuscles,
  kTouch,
  kReflex,
  kAround,
  kTask,
  kNone
};

struct TickField {
  std::string_view name = {}, unit = {};  ///< In messages, recordings and Python. Unit: empty for a plain number.
  Of of = Of::kNumber;
  /// Name in columns, as `<whose>_<shown>_<axis>_<shown unit>`, times the factor; empty: by its name.
  std::string_view shown = {}, shown_unit = {};
  double factor = 1.0;
  std::string_view sentence = {};
  const Scenes* scenes = nullptr;  ///< Null: all.
  From from = From::kTick;
  Block block = Block::kNone;
  /// Exactly one is set: `at` gives the place of the numbers (for a pose its 4 x 4 matrix); `compute` appends them.
  FieldNumbers (*at)(const TickView&) = nullptr;
  void (*compute)(const TickView&, std::vector<double>&) = nullptr;

  [[nodiscard]] bool is_in(const Model& model) const { return scenes == nullptr || scenes->have(model); }
  /// Returns true if signals.csv has the field: those that people plot, since the figures read it repeatedly.
  [[nodiscard]] bool is_in_signals() const { return block != Block::kNone; }
  [[nodiscard]] bool is_in_python() const { return of != Of::kShape && from != From::kPicture && from != From::kLoops; }
};

/// Returns all fields, in the order of a state message.
[[nodiscard]] std::span<const TickField> tick_fields();

/// Returns the field of this name, or null.
[[nodiscard]] const TickField* tick_field(std::string_view name);

/// Returns a pose as a state has it: position, then rotation by rows.
[[nodiscard]] std::array<double, 12> pose_numbers(const Eigen::Isometry3d& X);

/// Appends a field's numbers to the list.
void add_numbers(const TickField& field, const TickView& view, std::vector<double>& to);

}  // namespace thenar
