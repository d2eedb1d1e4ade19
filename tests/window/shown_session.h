// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/window/session.h"
#include "engine/formats/files.h"
#include "engine/loops/realtime.h"
#include "engine/models/build_model.h"
#include "engine/recordings/state_message.h"
#include "tests/support/scenes.h"

namespace thenar::window::shown_session {

using nlohmann::ordered_json;
using std::chrono::milliseconds;

// Far beyond what anything here takes: the machine may be busy.
inline constexpr std::chrono::seconds kPatience{60};

/// A session that runs on a thread of its own, and what it has shown.
class ShownSession {
 public:
  explicit ShownSession(thenar::Scene scene, SessionSettings settings = quiet())
      : model_(thenar::build_model(scene)),
        fields_(thenar::state_fields(model_)),
        session_(thenar::build_model(std::move(scene)), settings) {
    thread_ = std::thread([this] {
      const Display display{[this](const std::string& s, const std::string&) {
                              const std::lock_guard lock(mutex_);
                              ++scenes_;
                              fields_of_scene_ = ordered_json::parse(s).at("fields");
                            },
                            [this](const std::string& s) {
                              const std::lock_guard lock(mutex_);
                              status_ = ordered_json::parse(s);
                            },
                            [this](const std::string& s) {
                              const std::lock_guard lock(mutex_);
                              grasps_ = ordered_json::parse(s);
                            },
                            [this](const std::string& s) {
                              const std::lock_guard lock(mutex_);
                              state_ = thenar::read_state_message(s);
                              states_.push_back(s);
                              if (const int away_ms = away_ms_.exchange(0); away_ms > 0) {
                                std::this_thread::sleep_for(milliseconds(away_ms));
                              }
                            },
                            [this] {
                              ++looks_;
                              return pages_.load();
                            }};
      try {
        session_.run(display, stop_);
      } catch (const thenar::FileError& error) {
        const std::lock_guard lock(mutex_);
        fault_ = error.what();
      }
    });
  }
  ~ShownSession() { end(); }
  void end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  static SessionSettings quiet() {
    SessionSettings settings;
    settings.realtime = false;
    settings.quiet = true;
    return settings;
  }

  std::string receive(const Message& message) { return session_.receive(message); }

  /// Whether it comes true.
  template <typename Condition>
  [[nodiscard]] bool comes(Condition condition, std::chrono::seconds patience = kPatience) {
    const auto end = std::chrono::steady_clock::now() + patience;
    while (std::chrono::steady_clock::now() < end) {
      if (condition()) return true;
      std::this_thread::sleep_for(milliseconds(5));
    }
    return false;
  }
  [[nodiscard]] ordered_json status() {
    const std::lock_guard lock(mutex_);
    return status_;
  }
  /// The newest message on grasps.
  [[nodiscard]] ordered_json grasps() {
    const std::lock_guard lock(mutex_);
    return grasps_;
  }
  /// Of the newest state; NaN before the first.
  [[nodiscard]] double value(const std::string& name, std::size_t i = 0) {
    const std::lock_guard lock(mutex_);
    return value_of(name, i);
  }
  /// The first numbers of a field, all of one state.
  [[nodiscard]] Eigen::Vector3d vector(const std::string& name) {
    const std::lock_guard lock(mutex_);
    return {value_of(name, 0), value_of(name, 1), value_of(name, 2)};
  }
  /// A time, and where the box is and how it is pulled then: all of one state.
  struct Pulled {
    double time_s;
    Eigen::Vector3d object, force_N;
  };
  [[nodiscard]] Pulled pulled() {
    const std::lock_guard lock(mutex_);
    const auto vector_of = [this](const std::string& name) {
      return Eigen::Vector3d(value_of(name, 0), value_of(name, 1), value_of(name, 2));
    };
    return {value_of("time_s", 0), vector_of("object"), vector_of("pull_force_N")};
  }
  [[nodiscard]] bool passes(double time_s) {
    return comes([&] { return value("time_s") > time_s; });
  }
  [[nodiscard]] int states() {
    const std::lock_guard lock(mutex_);
    return static_cast<int>(states_.size());
  }
  [[nodiscard]] std::vector<std::string> all_states() {
    const std::lock_guard lock(mutex_);
    return states_;
  }
  /// After a pause was asked for: whether all that was asked for until now is done, and its state shown. Of a further
  /// wish the status comes first, and the state next: the status of a second one comes after both.
  [[nodiscard]] bool rests() {
    const auto heeds = [this](double speed) {
      receive(Speed{speed});
      return comes([&] { return status()["speed"] == speed && status()["running"] == false; });
    };
    return heeds(0.999) && heeds(1.0);
  }
  /// Whether the session comes to ask so often if a page is there: each 3 ms in a run, more seldom on a busy machine.
  [[nodiscard]] bool looks(int times) {
    return comes([this, end = looks_ + times] { return looks_ >= end; });
  }
  [[nodiscard]] int scenes() {
    const std::lock_guard lock(mutex_);
    return scenes_;
  }
  /// What kept it from writing a file, after end().
  [[nodiscard]] std::string fault() {
    const std::lock_guard lock(mutex_);
    return fault_;
  }
  void set_pages(int pages) { pages_ = pages; }
  /// The next state that is shown takes so long.
  void be_away(int time_ms) { away_ms_ = time_ms; }

 private:
  double value_of(const std::string& name, std::size_t i) const {
    if (state_.empty()) return thenar::kNotMeasured;
    for (const ordered_json& field : fields_of_scene_) {
      if (field.at("name") == name) return state_.at(field.at("begin").get<std::size_t>() + i);
    }
    ADD_FAILURE() << "no field " << name;
    return thenar::kNotMeasured;
  }

  thenar::Model model_;
  std::vector<thenar::Field> fields_;
  Session session_;
  std::atomic<bool> stop_{false};
  std::atomic<int> pages_{1}, looks_{0}, away_ms_{0};
  std::mutex mutex_;
  ordered_json status_ = ordered_json::object(), grasps_ = ordered_json::object(), fields_of_scene_;
  std::vector<double> state_;
  std::vector<std::string> states_;
  std::string fault_;
  int scenes_ = 0;
  std::thread thread_;
};

/// The box grasp, its task left out, at rates that a busy machine keeps: 500 Hz and 100 Hz.
inline thenar::Scene held_box(const std::vector<std::string>& more = {}) {
  std::vector<std::string> overrides = {kCoarseBox, "time.step=2 ms", "time.control_period=10 ms",
                                        "contact.tolerance=1e-7", "contact.max_sweeps=60"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  thenar::Scene scene = scene_of("box_grasp", overrides);
  scene.task = {};
  return scene;
}

}  // namespace thenar::window::shown_session
