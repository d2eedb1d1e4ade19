// SPDX-License-Identifier: Apache-2.0
#include "app/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "app/exit_code.h"
#include "app/version.h"
#include "app/wrong_command.h"
#include "engine/formats/byte_source.h"
#include "engine/formats/text.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/units.h"

namespace thenar::app {

namespace {

/// The texts of the flags that change the scene, as they were written.
struct SceneFlags {
  std::string time, tolerance, control_delay, control_jitter, spin;
  std::string solve_time = "1 s";  ///< Of no scene.
  RateFlags rates;
};

CLI::Option* add_file(CLI::App& command, const char* option, std::filesystem::path& file, const char* what) {
  return command.add_option(option, file, what)->type_name("FILE")->check(named())->check(no_folder());
}

void add_results(CLI::App& command, Options& options, const char* results) {
  command.add_option("--out", options.out, std::string("Folder for ") + results)->type_name("DIR")->check(named());
  add_choice(command, "--format", options.format, {"text", "json"}, "What to print");
  command.add_flag("--quiet", options.quiet, "Prints nothing but errors (and JSON, if asked for)");
}

void add_time(CLI::App& command, SceneFlags& flags) {
  command.add_option("--time", flags.time, "Simulated time in seconds, or with a unit, such as '500 ms'")
      ->type_name("T")
      ->check(some_time());
}

/// The flags of two loops, whoever runs them.
void add_loops(CLI::App& command, SceneFlags& flags) {
  add_rates(command, flags.rates, true);
  command.add_option("--tolerance", flags.tolerance, "Residual at which a contact tick stops its sweeps, such as 1e-3")
      ->type_name("NUMBER")
      ->check(quantity(Dimension::kNone, 1e-12, 1.0, "1e-3"));
}

/// The flags of two threads, which need the flag `realtime`.
void add_threads(CLI::App& command, CLI::Option* realtime, SceneFlags& flags, Options& options) {
  add_core(command, options.core);
  command.get_option("--core")->needs(realtime);
  command.add_option("--spin", flags.spin, "The contact thread wakes so long before its tick and spins, default 50us")
      ->type_name("T")
      ->check(quantity(Dimension::kTime, 0.0, 1e-2, "50us"))
      ->needs(realtime);
  command
      .add_flag_callback(
          "--no-realtime", [&options] { options.realtime = false; },
          "Takes what any thread gets: no SCHED_FIFO, no core of its own")
      ->needs(realtime);
  command
      .add_flag("--floor", options.floor,
                "Runs cyclictest first, in turns with the scene: what this machine can do at best")
      ->needs(realtime);
  add_file(command, "--trace", options.trace, "File for the last 5 s as a Chrome trace, which Perfetto opens")
      ->needs(realtime);
}

/// The flags that write problem files. The first of them returns so that it can be tied to another flag.
CLI::Option* add_dump(CLI::App& command, Options& options) {
  CLI::Option* const folder =
      command
          .add_option(
              "--dump-problems", options.dump_problems,
              "Folder for contact-T.fcp, grasp-T.json and muscle-T.json: the problems that were solved in tick T, for "
              "thenar solve; and stiffness-T.json: an object stiffness that was asked for and had no solution. Not "
              "with --realtime, where writing would make ticks late")
          ->type_name("DIR")
          ->check(named());
  command.add_option("--dump-every", options.dump_every, "Ticks from one dump to the next")
      ->type_name("N")
      ->capture_default_str()
      ->check(whole_within(1, 1'000'000'000))
      ->needs(folder);
  return folder;
}

/// The command that solves problem files.
void add_solve(CLI::App& app, SceneFlags& flags, Options& options) {
  CLI::App* const command = app.add_subcommand(
      "solve", "Solves problem files, and tells the residuals, recomputed from the files, and the times");
  command
      ->add_option("FILE", options.problems,
                   "Problem files: .fcp (contact), .hdf5 or .h5 (contact, in the format of FCLIB), .json (P1 grasp "
                   "forces, P2 muscle forces, P3 those under an object stiffness, LCP)")
      ->required();
  add_choice(
      *command, "--method", options.method, {"newton", "gauss_seidel", "active_set", "lemke", "exact_cone", "all"},
      "How; the first is the default. contact: newton (Gauss-Seidel, then Newton), gauss_seidel. P1: active_set, "
      "lemke (pyramids), exact_cone. P2: active_set, lemke. P3: newton. LCP: lemke. all: each that applies");
  command
      ->add_option("--tolerance", options.tolerance,
                   "Largest residual of a solution, default 1e-8 for contact (natural map), else 1e-10 (share of the "
                   "forces); for grasps not less than what rounding does to the forces of contacts that are nearly on "
                   "a line")
      ->type_name("NUMBER")
      ->check(within(1e-15, 1.0));
  command
      ->add_option(
          "--repeat", options.repeat,
          "Timed solves of each problem at most, from no forces. An .fcp file with several steps, or with the forces "
          "of the tick before, has a second row: each step from the forces before it, iterations a step")
      ->type_name("N")
      ->capture_default_str()
      ->check(whole_within(1, 1'000'000));
  command
      ->add_option(
          "--time", flags.solve_time,
          "For a file, after which it is solved no more: each of its rows has an equal share, and one solve at least")
      ->type_name("T")
      ->capture_default_str()
      ->check(some_time());
  add_choice(*command, "--format", options.format, {"text", "json"}, "What to print");
  command->add_flag("--forces", options.forces, "Shows the forces (z of an LCP), too");
  add_file(
      *command, "--write", options.written,
      "Writes the contact problem, with the solution that the first method found, as .hdf5 or .h5 (FCLIB, the first "
      "step) or as .fcp");
  command->footer(
      "Exit code: 0 if every verdict is right and every solution within the tolerance, 2 for a wrong command and for "
      "FCLIB files where HDF5 is missing, 3 for a file that cannot be read or written, else 6.");
}

/// The command that runs a scene many times.
void add_sweep(CLI::App& app, SceneFlags& flags, Options& options) {
  CLI::App* const command = app.add_subcommand(
      "sweep", "Runs all combinations of what varies in a scene, one a core, and makes one table of them");
  add_scene(*command, options.scene, options.overrides);
  command
      ->add_option("--vary", options.vary,
                   "What varies, as often as needed, the last one fastest: 'contact.friction=0.4:1:7' is 7 values from "
                   "0.4 to 1, with :log at the end by equal ratios; 'time.step=0.5 ms,1 ms' is these values")
      ->take_all()
      ->required()
      ->type_name("KEY=VALUES");
  command
      ->add_option("--out", options.out,
                   "Folder for rows.csv and the journals of what has run: the same command goes on where it stopped")
      ->required()
      ->type_name("DIR")
      ->check(named());
  add_time(*command, flags);
  command->add_option("--jobs", options.jobs, "Rows at a time; default: one a core, and under mpirun one a process")
      ->type_name("N")
      ->check(whole_within(1, 1024));
  command->add_flag_callback(
      "--lockstep", [&options] { options.runner = Runner::kLockstep; }, "Runs the two loops on a virtual clock");
  command->add_flag("--quiet", options.quiet, "Prints nothing but errors");
  command->footer(
      "Exit code: 0 if all rows were run, whatever became of them, 2 for a wrong command or a folder that holds "
      "another sweep, 3 for a file, 6 if rows are missing, such as one that found no memory, 130 if interrupted.");
}

/// What is said of an object that no scene describes yet.
void add_object(CLI::App& command, Options& options) {
  command
      .add_option("--hand", options.hand_file,
                  "The hand's file, or the name of a hand that comes with the program; default: hand")
      ->type_name("HAND")
      ->check(named());
  command.add_option("--unit", options.unit, "What 1 in the object's file measures, such as mm; default: m")
      ->type_name("UNIT")
      ->check({[](const std::string& text) { return read_unit(text).fault; }, ""});
  command.add_option("--mass", options.mass, "The object's mass, such as 80g; default: 100 g")
      ->type_name("M")
      ->check(quantity(Dimension::kMass, 1e-6, 1e3, "80g"));
  command.add_option("--friction", options.friction, "Friction of the contacts; default: 0.6")
      ->type_name("NUMBER")
      ->check(within(0.0, 10.0));
  command.add_option("--press", options.press, "Normal load of the least loaded finger, such as 0.5N")
      ->type_name("F")
      ->check(quantity(Dimension::kForce, 1e-3, 1e3, "0.5N"));
}

/// The commands that find how a hand can hold an object.
void add_grasp(CLI::App& app, Options& options) {
  CLI::App* const grasp =
      app.add_subcommand("grasp", "Finds how a hand can hold an object: ranks grasps, and writes each as a scene");
  grasp
      ->add_option("OBJECT|SCENE", options.subject,
                   "A mesh or a point cloud; or a scene (YAML, or the name of one that comes with the program)")
      ->required()
      ->check(named());
  grasp->add_option("--set", options.overrides, "Of a scene: changes a value, key.path=value, as often as needed")
      ->take_all()
      ->type_name("KEY=VALUE");
  add_object(*grasp, options);
  grasp
      ->add_option(
          "--best", options.best,
          "How many grasps, each unlike the others: each more takes its time, for it is tried before it is offered")
      ->type_name("N")
      ->capture_default_str()
      ->check(whole_within(1, 100));
  grasp
      ->add_option("--out", options.out,
                   "Folder for grasp-1.yaml, grasp-1.png and so on: scenes that run, and pictures")
      ->type_name("DIR")
      ->check(named());
  grasp->add_flag("--quiet", options.quiet, "Prints nothing but errors");
  grasp->footer(
      "Below the table stands what its columns are.\n"
      "Exit code: 0 if a grasp was found, 2 for a wrong command or scene, 3 for a file that cannot be read, 6 if none "
      "was found, 130 if interrupted: what was found until then is ranked and written.");
  CLI::App* const command =
      app.add_subcommand("new", "Writes a commented scene in which a hand is to grasp an object from a file");
  command->add_option("FILE", options.scene, "The scene's file, which must not be there yet")
      ->required()
      ->check(named())
      ->check(no_folder());
  command->add_option("--object", options.object, "A mesh or a point cloud")
      ->required()
      ->type_name("FILE")
      ->check(named());
  add_object(*command, options);
  command->add_flag("--quiet", options.quiet, "Prints nothing but errors");
}

/// The commands that tell what a scene may say.
void add_keys(CLI::App& app, Options& options) {
  CLI::App* const command =
      app.add_subcommand("keys", "Lists the keys of scenes: values, units, ranges, defaults and meanings");
  command->add_option("PREFIX", options.prefix, "Lists this key and those below it, such as contact")
      ->type_name("KEY")
      ->check(named());
  command->add_flag("--markdown", options.markdown, "Prints the page docs/reference/scene.md")->excludes("PREFIX");
  CLI::App* const fields = app.add_subcommand(
      "fields", "Prints the page docs/reference/fields.md: the fields of a tick, and the measures of a found grasp");
  fields->add_flag("--stub", options.stub, "Prints them as properties in python/thenar/_core.pyi instead");
  fields->add_flag("--measures", options.measures, "Prints the page docs/reference/measures.md instead")
      ->excludes("--stub");
}

/// The flags as changes of the scene, around those that the user set by key: a default of ours gives way to them, a
/// flag does not.
void apply(const SceneFlags& flags, Options& options) {
  std::vector<std::string> defaults, asked = flags.rates.changes();
  options.rates = flags.rates;
  if (options.runner == Runner::kRealtime) defaults = realtime_defaults();
  if (!flags.control_delay.empty()) asked.push_back("time.control_delay=" + flags.control_delay);
  if (!flags.tolerance.empty()) asked.push_back("contact.tolerance=" + flags.tolerance);
  if (!flags.time.empty()) asked.push_back("time.duration=" + with_unit(flags.time));
  options.solve_time_s = time_s(with_unit(flags.solve_time));
  if (!flags.spin.empty()) options.spin_s = time_s(flags.spin);
  if (!flags.control_jitter.empty()) options.control_jitter_s = time_s(flags.control_jitter);
  options.overrides.insert(options.overrides.begin(), defaults.begin(), defaults.end());
  options.overrides.insert(options.overrides.end(), asked.begin(), asked.end());
}

/// What is wrong with the first word, where it should be a command; empty: nothing.
std::string wrong_command(const CLI::App& app, const std::vector<std::string>& words) {
  if (words.empty()) return "name a command";
  const std::string& word = words.front();
  if (word == "profile") return "'profile' is no command: profile is run --realtime now";
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  if (word.starts_with("-") || std::find(names.begin(), names.end(), word) != names.end()) return {};
  const std::vector<std::string_view> candidates(names.begin(), names.end());
  const std::string_view nearest = nearest_word(word, candidates);
  return fmt::format("'{}' is no command{}", printable(word), did_you_mean(nearest));
}

/// What the flags cannot say together.
void check_together(const RateFlags& rates, Runner runner) {
  const char* const first = rates.contact.empty() ? "--control-rate" : "--contact-rate";
  if (rates.any() && runner == Runner::kMonolithic) throw CLI::ValidationError(first, "needs --realtime or --lockstep");
  if (rates.auto_control() && runner == Runner::kLockstep) {
    throw CLI::ValidationError("--control-rate", "auto needs --realtime: a virtual clock is never late");
  }
  check_rates(rates);
}

void add_run(CLI::App& app, SceneFlags& flags, Options& options) {
  CLI::App* const run = app.add_subcommand("run", "Runs a scene and prints what came of it");
  add_scene(*run, options.scene, options.overrides);
  add_results(*run, options, "summary.json, signals.csv and figures");
  run->add_flag_callback(
      "--no-figures", [&options] { options.figures = false; }, "Draws no figures into the folder of --out");
  add_time(*run, flags);
  CLI::Option* const realtime = run->add_flag_callback(
      "--realtime", [&] { options.runner = Runner::kRealtime; }, "Runs it on two threads, in real time");
  CLI::Option* const lockstep = run->add_flag_callback(
      "--lockstep", [&] { options.runner = Runner::kLockstep; }, "Runs the two loops on a virtual clock");
  lockstep->excludes(realtime);
  add_loops(*run, flags);
  add_threads(*run, realtime, flags, options);
  run->add_option("--control-delay", flags.control_delay,
                  "From a control tick's start to its frame's use, such as 20ms")
      ->type_name("T")
      ->check(quantity(Dimension::kTime, 0.0, 1e3, "20ms"))
      ->needs(lockstep);
  run->add_option("--control-jitter", flags.control_jitter, "Each frame takes up to so much longer, such as 2ms")
      ->type_name("T")
      ->check(quantity(Dimension::kTime, 0.0, 1.0, "2ms"))
      ->needs(lockstep);
  add_record(*run, options.record,
             "MCAP file of what the run looks like: thenar demo replays it, thenar export shares it, others open it");
  add_dump(*run, options)->excludes(realtime);
  run->footer(codes_of_outcomes());
}

void add_insertion(CLI::App& app, Options& options) {
  CLI::App* const command = app.add_subcommand(
      "insertion", "Runs a scene whose peg goes into a hole, and tells how it touches, jams and wedges");
  add_scene(*command, options.scene, options.overrides);
  add_results(*command, options, "insertion.json, insertion.csv and insertion.svg");
  command->footer("Exit code: that of thenar run; 2 also for a scene without a peg, which is a cylinder, or a hole.");
}

void add_check(CLI::App& app, Options& options) {
  CLI::App* const check = app.add_subcommand(
      "check", "Says what a scene will model, what it leaves out, and the defaults; lists and draws a hand");
  add_scene(*check, options.scene, options.overrides,
            "Scene or hand (YAML), or the name of one that comes with the program", true);
  add_file(*check, "--out", options.hand.out, "Of a hand: its picture (PNG)");
  check->add_flag("--parts", options.parts,
                  "Of a scene: runs it, too, and again without each part of its model: what it costs and gives");
}

void add_docs(CLI::App& app, Options& options) {
  CLI::App* const docs =
      app.add_subcommand("docs", "Prints where the documents are as a site, and opens them on a desktop");
  docs->add_flag_callback(
      "--no-browser", [&options] { options.browser = false; }, "Opens no browser, only prints the file's path");
  docs->footer("Exit code: 0, 2 for a wrong command, 3 if the site is missing.");
}

void add_doctor(CLI::App& app, Options& options) {
  CLI::App* const doctor =
      app.add_subcommand("doctor", "Says what this machine can keep, and how to get what it refuses");
  add_core(*doctor, options.core);
}

/// Every command has a line on its exit codes, this one if it has no other.
void add_exit_codes(CLI::App& command) {
  if (command.get_footer().empty()) command.footer(kCodesOfMost);
  for (CLI::App* below : command.get_subcommands([](CLI::App* b) { return !b->get_name().empty(); })) {
    add_exit_codes(*below);
  }
}

/// The command line: help, man page and completions are made of this.
void describe(CLI::App& app, SceneFlags& flags, Options& options) {
  app.name("thenar");
  app.description("Real-time human grasp: deformable fingertips, muscles, and grasps that are found");
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  app.failure_message(wrong_command_line);
  // In the order of the help.
  add_run(app, flags, options);
  add_window(app, options.window);
  add_solve(app, flags, options);
  add_check(app, options);
  add_hand(app, options.hand);
  add_grasp(app, options);
  add_sweep(app, flags, options);
  add_stiffness(app, options.stiffness);
  add_insertion(app, options);
  add_export(app, options.exported);
  add_keys(app, options);
  app.add_subcommand("schema", "Prints the JSON Schema of scenes, by which editors complete and check them");
  add_doctor(app, options);
  app.add_subcommand("scenes", "Lists the scenes that come with the program");
  add_docs(app, options);
  app.add_subcommand("man", "Prints this program's manual page: thenar man | man -l -");
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) add_exit_codes(*command);
  app.footer(kAllCodes);
}

}  // namespace

void with_command_line(const std::function<void(const CLI::App&)>& use) {
  CLI::App app;
  Options options;
  SceneFlags flags;
  describe(app, flags, options);
  use(app);
}

std::optional<Options> parse_options(int argc, const char* const* argv, int& exit_code) {
  CLI::App app;
  Options options;
  SceneFlags flags;
  describe(app, flags, options);
  const std::string wrong = wrong_command(app, {argv + std::min(argc, 1), argv + argc});
  if (!wrong.empty()) {
    std::cerr << "thenar: " << wrong << (wrong.ends_with('?') ? "" : ";") << " `thenar --help` lists all commands\n";
    exit_code = kBadUsage;
    return std::nullopt;
  }
  try {
    app.parse(argc, argv);
    options.command = app.get_subcommands().front()->get_name();
    check_together(flags.rates, options.runner);
    check_rates(options.window.rates);
  } catch (const CLI::ParseError& error) {
    exit_code = app.exit(error) == 0 ? kDone : kBadUsage;
    return std::nullopt;
  }
  apply(flags, options);
  return options;
}

namespace {

/// Tells on stderr of surfaces that take long to be made ready, before they are.
void tell_of_samples(const Scene& scene) {
  constexpr Eigen::Index kMany = 200'000;
  const auto tell = [](const char* key, Eigen::Index samples) {
    if (samples < kMany) return;
    std::cerr << fmt::format("warning: {}: {} samples take a minute or more to be made ready\n", key, samples);
  };
  tell("object.points", std::holds_alternative<CloudShape>(scene.object.shape) ? 0 : scene.object.points);
  if (scene.fingertips) tell("fingertips.points", scene.fingertips->points);
}

}  // namespace

Scene scene_of(const Options& options) {
  Scene scene = scene_at_rates(options.scene, options.overrides, options.rates);
  if (!options.quiet) tell_of_samples(scene);
  return scene;
}

}  // namespace thenar::app
