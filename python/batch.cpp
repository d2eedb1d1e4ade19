// SPDX-License-Identifier: Apache-2.0
#include "python/batch.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/recordings/recording_file.h"
#include "engine/recordings/signals.h"
#include "engine/results/scene_run.h"
#include "engine/results/summary.h"
#include "engine/sweeps/sweep.h"
#include "python/arrays.h"
#include "python/interpreter.h"
#include "python/laws.h"
#include "python/scene.h"
#include "python/simulation.h"
#include "python/tick_views.h"

namespace thenar::python {

namespace {

const TickField& signal_called(const std::string& name) {
  std::string known;
  for (const TickField& field : tick_fields()) {
    if (!field.is_in_python()) continue;
    if (name == field.name) return field;
    known.append(known.empty() ? "" : ", ").append(field.name);
  }
  throw py::value_error(fmt::format("rollout keeps no '{}': {}", name, known));
}

/// How many numbers of a field a simulation has: none where its scene does not have the field.
py::ssize_t count_of(const TickField& field, const Simulation& s) {
  if (!field.is_in(*s.model)) return 0;
  return std::ssize(SeenTick(*s.model, s.record, s.run.state, s.run.controller.f_muscle).numbers(field));
}

/// Samples of one signal of all simulations.
struct Kept {
  const TickField* signal;
  py::ssize_t size;
  Array array;
};

struct RolloutPlan {
  std::vector<Simulation*> all;
  std::int64_t ticks, every;
  std::vector<Kept> kept;
  std::vector<double*> into;  // Of each kept signal.
};

void run_one(RolloutPlan& plan, std::size_t row, const std::atomic<bool>& stop) {
  Simulation& simulation = *plan.all[row];
  const std::int64_t samples = plan.ticks / plan.every;
  const auto stops = [&] { return stop.load(std::memory_order_relaxed); };
  for (std::int64_t sample = 0; sample < samples && !stops(); ++sample) {
    simulation.ticks(plan.every, false, stops);
    SeenTick seen(*simulation.model, simulation.record, simulation.run.state, simulation.run.controller.f_muscle);
    for (std::size_t k = 0; k < plan.kept.size(); ++k) {
      const py::ssize_t size = plan.kept[k].size;
      if (size == 0) continue;
      std::ranges::copy(seen.numbers(*plan.kept[k].signal),
                        plan.into[k] + (static_cast<std::int64_t>(row) * samples + sample) * size);
    }
  }
}

int threads_of(const py::object& threads) {
  if (threads.is_none()) return std::max(1U, std::thread::hardware_concurrency());
  return static_cast<int>(whole_number(threads, "threads", 1, 4096));
}

/// Calls `work` for 0 .. count - 1, whichever thread is free, and `look` now and then meanwhile. Rethrows the first
/// fault, when all have ended.
template <typename Work, typename Look>
void in_threads(std::size_t count, int threads, std::atomic<bool>& stop, Work&& work, Look&& look) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::condition_variable ended;
  std::exception_ptr fault;
  int running = std::min<int>(threads, static_cast<int>(count));
  const auto worker = [&] {
    std::exception_ptr thrown;
    try {
      for (std::size_t i = next.fetch_add(1); i < count && !stop; i = next.fetch_add(1)) work(i);
    } catch (...) {
      thrown = std::current_exception();
      stop = true;
    }
    const std::lock_guard lock(mutex);
    if (thrown && !fault) fault = thrown;
    if (--running == 0) ended.notify_all();
  };
  std::vector<std::jthread> all;
  try {
    for (int t = running; t > 0; --t) all.emplace_back(worker);
  } catch (...) {
    stop = true;  // There are no more threads to be had: those that there are end soon.
    throw;
  }
  std::unique_lock lock(mutex);
  while (!ended.wait_for(lock, std::chrono::milliseconds(50), [&] { return running == 0; })) {
    lock.unlock();
    look();
    lock.lock();
  }
  lock.unlock();
  all.clear();
  if (fault) std::rethrow_exception(fault);
}

py::dict rollout(const std::vector<std::shared_ptr<Simulation>>& simulations, std::int64_t ticks, std::int64_t every,
                 const std::vector<std::string>& names, const py::object& threads) {
  if (ticks < 0) throw py::value_error("ticks must be 0 or more");
  if (every < 1 || ticks % every != 0) throw py::value_error("every must be 1 or more, and divide ticks");
  const int jobs = threads_of(threads);
  RolloutPlan plan{{}, ticks, every, {}, {}};
  std::vector<std::unique_ptr<Hold>> holds;
  for (const auto& simulation : simulations) {
    if (!simulation) throw py::type_error("rollout takes a list of simulations");
    plan.all.push_back(simulation.get());
    if (simulation->model->fingers() != simulations[0]->model->fingers() ||
        simulation->model->scene.hand.joints.size() != simulations[0]->model->scene.hand.joints.size()) {
      throw py::value_error("the simulations of a rollout have hands of as many fingers and joints");
    }
    holds.push_back(std::make_unique<Hold>(*simulation));
  }
  SignalWatch watch;
  py::dict result;
  for (const std::string& name : names) {
    const TickField& signal = signal_called(name);
    const py::ssize_t size =
        simulations.empty() ? (shape_of(signal, 1).empty() ? 1 : 0) : count_of(signal, *simulations[0]);
    for (const auto& simulation : simulations) {
      if (count_of(signal, *simulation) != size)
        throw py::value_error(name + " is of another size in some simulations");
    }
    plan.kept.push_back(
        {&signal, size,
         Array({static_cast<py::ssize_t>(simulations.size()), static_cast<py::ssize_t>(ticks / every), size})});
    plan.into.push_back(plan.kept.back().array.mutable_data());
  }
  {
    const Unlocked others;
    std::atomic<bool> stop{false};
    in_threads(
        plan.all.size(), jobs, stop, [&](std::size_t row) { run_one(plan, row, stop); },
        [&] {
          if (!stop && watch()) stop = true;
        });
  }
  watch.rethrow();
  for (Kept& kept : plan.kept) {
    std::vector<py::ssize_t> shape = shape_of(*kept.signal, static_cast<std::size_t>(kept.size));
    shape.insert(shape.begin(), {kept.array.shape(0), kept.array.shape(1)});
    result[py::str(std::string(kept.signal->name))] = kept.array.reshape(shape);
  }
  return result;
}

py::dict columns_of(const Model& model, const Recording& recording) {
  const SignalTable table = signal_table(model, recording);
  py::dict columns;
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    columns[py::str(table.names[i])] = copy(Eigen::VectorXd(table.numbers.col(static_cast<Eigen::Index>(i))));
  }
  return columns;
}

std::filesystem::path path_of(const py::object& value, const char* name) {
  try {
    return value.cast<std::filesystem::path>();
  } catch (const py::cast_error&) {
    throw py::type_error(fmt::format("{} takes the path of a file", name));
  }
}

std::vector<std::string> names_of(const py::object& value, const char* name) {
  try {
    if (!py::isinstance<py::str>(value)) return value.cast<std::vector<std::string>>();
  } catch (const py::cast_error&) {
  }
  throw py::type_error(fmt::format("{} takes a list of names", name));
}

RecordingSettings recording_settings(const Model& model, const py::object& rate, const py::object& fields,
                                     bool contacts) {
  RecordingSettings settings;
  settings.contacts = contacts;
  if (py::isinstance<py::str>(rate)) {
    settings.rate_Hz = quantity_of(rate, Dimension::kFrequency, "record_rate");
  } else if (!rate.is_none()) {
    settings.rate_Hz = number(rate, "record_rate");
  }
  const double contact_Hz = 1.0 / model.scene.step_s;
  if (settings.rate_Hz < kLeastRecordingRate_Hz || settings.rate_Hz > contact_Hz * (1.0 + 1e-9)) {
    throw py::value_error(fmt::format("record_rate must lie within {} .. {:.6g} Hz, the contact loop's",
                                      kLeastRecordingRate_Hz, contact_Hz));
  }
  if (fields.is_none()) return settings;
  settings.fields = names_of(fields, "record_fields");
  if (settings.fields.empty()) throw py::value_error("record_fields names no field");
  const std::string unknown = unknown_field(model, settings.fields);
  if (!unknown.empty()) throw py::value_error(unknown);
  return settings;
}

py::dict run(const std::shared_ptr<const SceneHandle>& scene, const py::object& record, const py::object& record_rate,
             const py::object& record_fields, bool record_contacts, const py::object& lockstep, py::object wrench,
             py::object forces, py::object torques, py::object muscles) {
  RunSettings settings;
  settings.lockstep = lockstep_of(lockstep);
  SignalWatch watch;
  settings.progress = [&](double, double) { return !watch(); };
  std::optional<std::filesystem::path> file;
  if (!record.is_none()) file = path_of(record, "record");
  const std::shared_ptr<const Model> model = model_of(*scene);
  settings.own =
      own_control(model->scene, std::move(wrench), std::move(forces), std::move(torques), std::move(muscles));
  const RecordingSettings kept = recording_settings(*model, record_rate, record_fields, record_contacts);
  Recording recording;
  {
    const Unlocked others;
    std::optional<RecordingFile> film;
    if (file) film.emplace(*file, *model, kept);
    if (film) settings.watchers.push_back(&*film);
    State state(*model);
    recording = run_scene(*model, state, settings);
    if (film) film->finish(recording);
  }
  watch.rethrow();
  py::dict result;
  result["summary"] = of_json(summarize(*model, recording));
  result["signals"] = columns_of(*model, recording);
  return result;
}

/// `given`: what the caller has for each value of a key; of a range there is the text.
SweepPlan plan_of(const SceneHandle& scene, const py::dict& vary, std::vector<std::vector<py::object>>& given) {
  if (scene.grasp()) throw py::value_error("sweep takes scenes of files: set grasp.rank instead");
  SweepPlan plan{scene.file(), scene.changes(), {}};
  for (const auto& [key, values] : vary) {
    Variation variation{text_of(py::str(key), "a key of vary"), {}};
    std::vector<py::object>& objects = given.emplace_back();
    if (py::isinstance<py::str>(values)) {
      variation = read_variation(variation.key + "=" + text_of(values, variation.key));
      for (const std::string& value : variation.values) objects.push_back(py::str(value));
    } else if (py::isinstance<py::iterable>(values)) {
      for (const py::handle value : values) {
        variation.values.push_back(yaml_text(value, variation.key));
        objects.push_back(py::reinterpret_borrow<py::object>(value));
      }
    } else {
      throw py::type_error(variation.key + " takes a list of values, or text such as '0.2:0.8:4'");
    }
    if (variation.values.empty()) throw py::value_error(variation.key + " varies over nothing");
    plan.vary.push_back(std::move(variation));
  }
  return plan;
}

py::list sweep(const std::shared_ptr<const SceneHandle>& scene, const py::dict& vary, const py::object& threads) {
  std::vector<std::vector<py::object>> given;
  const SweepPlan plan = plan_of(*scene, vary, given);
  const int jobs = threads_of(threads);
  std::map<std::size_t, SweepRow> rows;
  std::string failed;
  SignalWatch watch;
  {
    const Unlocked others;
    (void)first_scene(plan);
    std::vector<std::size_t> all(plan.rows());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    struct Interrupted {};
    try {
      run_sweep(plan, all, jobs, [](const Model& model) { return run_row(model); },
                {[&](std::size_t row, SweepRow result) {
                   rows.emplace(row, std::move(result));
                   if (watch()) throw Interrupted();
                 },
                 [&](std::size_t row, const std::string& why) { failed = fmt::format("row {}: {}", row, why); }});
    } catch (const Interrupted&) {
    }
  }
  watch.rethrow();
  if (!failed.empty()) throw std::runtime_error(failed);
  py::list table;
  for (const auto& [row, result] : rows) {
    py::dict line;
    std::size_t rest = row, below = plan.rows();
    for (std::size_t i = 0; i < given.size(); ++i) {
      below /= given[i].size();  // The last key turns fastest.
      line[py::str(plan.vary[i].key)] = given[i][rest / below];
      rest %= below;
    }
    line["outcome"] = to_string(result.verdict.outcome);
    line["reason"] = result.verdict.reason;
    if (!result.measures.is_null()) line.attr("update")(of_json(result.measures));
    table.append(line);
  }
  return table;
}

}  // namespace

void bind_batch(py::module_& module) {
  module.def("_run", &run, py::arg("scene"), py::arg("record"), py::arg("record_rate"), py::arg("record_fields"),
             py::arg("record_contacts"), py::arg("lockstep"), py::arg("wrench"), py::arg("forces"), py::arg("torques"),
             py::arg("muscles"));
  module.def("rollout", &rollout, py::arg("simulations"), py::arg("ticks"), py::kw_only(), py::arg("every") = 1,
             py::arg("signals") = std::vector<std::string>{"time_s", "object", "force_N", "margin"},
             py::arg("threads") = py::none(),
             R"(Advances many simulations by so many ticks, each on one thread, all at once.

Returns a dict: for each signal an array (simulations, ticks / every, ...), sampled every so many ticks. Names as of
Simulation; contacts is their number, and reflex is 0, 1 for a load or 2 for a slip. A field that a scene does not have
has no numbers. The bits are those of step(), whatever the threads.)");
  module.def("sweep", &sweep, py::arg("scene"), py::arg("vary"), py::kw_only(), py::arg("threads") = py::none(),
             R"(Runs all combinations of what varies, as `thenar sweep`.

vary: key to values, {'contact.friction': [0.3, 0.5], 'object.mass': '50 g:200 g:4'}; the last key turns fastest.
Returns a list of rows: a dict of what varies, as the list had it, outcome, reason and the measures of summary.json. A
combination that is no scene is a row: 'refused', and why.)");
}

}  // namespace thenar::python
