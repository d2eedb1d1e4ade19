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

/// What is said of a tick, described once: a row a field. State messages, recordings, their columns, signals.csv,
/// Python's views, rollout() and state(), and the tables of the reference are made of these rows.
namespace thenar {

/// Whose the numbers of a field are: how many there are, how their columns are called, and of which shape and type they
/// are in Python.
enum class Of : std::uint8_t {
  kNumber,
  kCount,       ///< One whole number.
  kFlag,        ///< 0 or 1.
  kAxis,        ///< x, y, z.
  kPose,        ///< Position, then rotation by rows: 12 numbers; in Python a matrix of 4 x 4.
  kFinger,      ///< One a finger.
  kFingerAxis,  ///< Three a finger.
  kJoint,
  kMuscle,
  kPercentile,  ///< p50, p99, p99.9.
  kList,        ///< Numbered from 0.
  kShape,       ///< For eyes alone: it has no columns.
};

/// What has to be at hand for a field to be known.
enum class From : std::uint8_t {
  kTick,     ///< The record of the tick.
  kClock,    ///< That, too, but it differs from run to run.
  kState,    ///< What is known of a chosen stiffness, and the state.
  kPicture,  ///< What is made for eyes.
  kLoops,    ///< The loops' own measures, by the clock on the wall.
};

/// An instant as fields see it. What is null is not at hand.
struct TickView {
  const Model& model;
  const TickRecord& tick;
  std::int64_t number;  ///< Of the tick.
  const JointVector& q;
  const Eigen::Isometry3d& X_WO;
  const PerFinger<FingerLoad>& load;
  std::span<const double> muscle_N;  ///< Of a scene without muscles none.
  const ShownStiffness* stiffness = nullptr;
  const Picture* picture = nullptr;
  const ShownEnvironment* environment = nullptr;
  const LoopFigures* loops = nullptr;
};

/// Of a record, all of it in memory that the record owns.
[[nodiscard]] TickView view_of(const Model& model, const TickRecord& tick, std::span<const double> muscle_N);

/// Numbers that lie in a view's memory: `rows` times `columns` next to one another, from row to row `stride` numbers.
struct Place {
  const double* first = nullptr;
  Eigen::Index rows = 1, columns = 1, stride = 1;
};

/// Which scenes have a field.
struct Scenes {
  bool (*have)(const Model&);
  std::string_view which;  ///< "of scenes with an environment".
};

inline constexpr Scenes kFeelingScenes{[](const Model& model) { return model.feels(); },
                                       "of scenes with `fingertips.touch`"};

/// Where the columns of a field are in signals.csv: those of a block together, finger by finger.
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
  /// In columns, as <whose>_<shown>_<axis>_<shown unit>, times the factor; empty: by its name.
  std::string_view shown = {}, shown_unit = {};
  double factor = 1.0;
  std::string_view sentence = {};
  const Scenes* scenes = nullptr;  ///< Null: all.
  From from = From::kTick;
  Block block = Block::kNone;
  /// One of these: where the numbers lie, of a pose its matrix of 4 x 4; or what puts them behind those in a list.
  Place (*at)(const TickView&) = nullptr;
  void (*compute)(const TickView&, std::vector<double>&) = nullptr;

  [[nodiscard]] bool is_in(const Model& model) const { return scenes == nullptr || scenes->have(model); }
  /// signals.csv has what people plot: the figures read it again and again.
  [[nodiscard]] bool is_in_signals() const { return block != Block::kNone; }
  [[nodiscard]] bool is_in_python() const { return of != Of::kShape && from != From::kPicture && from != From::kLoops; }
};

/// All of them, in the order of a state message.
[[nodiscard]] std::span<const TickField> tick_fields();

/// Null if no field has this name.
[[nodiscard]] const TickField* tick_field(std::string_view name);

/// A pose as a state has it: position, then rotation by rows.
[[nodiscard]] std::array<double, 12> pose_numbers(const Eigen::Isometry3d& X);

/// Puts a field's numbers behind those in the list.
void add_numbers(const TickField& field, const TickView& view, std::vector<double>& to);

}  // namespace thenar
