#include "demo/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <system_error>
#include <utility>

#include "demo/exit_code.h"
#include "engine/build_info.h"
#include "engine/config.h"
#include "engine/profile_figures.h"
#include "engine/units.h"

namespace {

namespace fs = std::filesystem;
using thenar::Dimension;

constexpr double kFastest_Hz = 100e3, kSlowest_Hz = 1.0;  // Of a loop: what may make sense, with room.
constexpr double kProfileContact_Hz = 4000.0, kProfileControl_Hz = 200.0;

/// The texts of the flags that change the scene, as they were written.
struct SceneFlags {
  std::string time, duration, contact_rate, control_rate, tolerance, control_delay, control_jitter, spin;
};

/// Whether the text is a quantity within [low, high], as CLI11 asks: what is wrong, or nothing.
CLI::Validator quantity(Dimension dimension, double low, double high, const char* example) {
  return {[=](const std::string& text) -> std::string {
            const thenar::Quantity read = thenar::read_quantity(text, dimension);
            if (!read.fault.empty()) return read.fault + fmt::format(", such as '{}'", example);
            if (read.value >= low && read.value <= high) return "";
            return fmt::format("{} must lie within {} .. {}", text, thenar::to_text(low, dimension),
                               thenar::to_text(high, dimension));
          },
          ""};
}
CLI::Validator or_auto(const CLI::Validator& rule) {
  return {[rule](std::string& text) { return text == "auto" ? "" : rule(text); }, ""};
}
CLI::Validator rate() { return quantity(Dimension::kFrequency, kSlowest_Hz, kFastest_Hz, "200Hz"); }

double rate_Hz(const std::string& text) { return thenar::read_quantity(text, Dimension::kFrequency).value; }
double time_s(const std::string& text) { return thenar::read_quantity(text, Dimension::kTime).value; }

/// A bare number, without a unit.
bool is_number(const std::string& text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && rest == end;
}

/// A bare number is one of seconds.
std::string with_unit(const std::string& text) { return is_number(text) ? text + " s" : text; }

CLI::Validator simulated_time() {
  const CLI::Validator rule = quantity(Dimension::kTime, 1e-6, 1e5, "500 ms");
  return {[rule](const std::string& text) {
            std::string time = with_unit(text);
            return rule(time);
          },
          ""};
}

CLI::Validator named() {
  return {[](const std::string& text) -> std::string { return text.empty() ? "needs a name" : ""; }, ""};
}
CLI::Validator no_folder() {
  return {[](const std::string& text) -> std::string {
            std::error_code none;  // What cannot be looked at is found out when it is written.
            return fs::is_directory(text, none) ? text + " is a folder, and must be a file" : "";
          },
          ""};
}

void add_scene(CLI::App& command, Options& options) {
  command.add_option("SCENE", options.scene, "Scene file (YAML)")->required();
  command.add_option("--set", options.overrides, "Changes a value: key.path=value, as often as needed")
      ->take_all()
      ->type_name("KEY=VALUE");
}

void add_results(CLI::App& command, Options& options, const char* results) {
  command.add_option("--out", options.out, std::string("Folder for ") + results)->type_name("DIR")->check(named());
  command.add_option("--format", options.format, "What to print")->check(CLI::IsMember({"text", "json"}));
  command.add_flag("--quiet", options.quiet, "Prints nothing but errors (and JSON, if asked for)");
}

/// The flags of two loops, whoever runs them.
void add_loops(CLI::App& command, SceneFlags& flags) {
  command.add_option("--contact-rate", flags.contact_rate, "Ticks a second of the contact loop, such as 4kHz")
      ->type_name("RATE")
      ->check(rate());
  command
      .add_option("--control-rate", flags.control_rate,
                  "Of the control loop, such as 200Hz; auto, in real time: what this machine keeps")
      ->type_name("RATE|auto")
      ->check(or_auto(rate()));
  command.add_option("--tolerance", flags.tolerance, "Residual at which a contact tick stops its sweeps, such as 1e-3")
      ->type_name("NUMBER")
      ->check(quantity(Dimension::kNone, 1e-12, 1.0, "1e-3"));
}

/// The flags of two threads. They return so that they can be tied to another flag.
std::array<CLI::Option*, 2> add_threads(CLI::App& command, SceneFlags& flags, Options& options) {
  return {
      command
          .add_option("--spin", flags.spin, "The contact thread wakes so long before its tick and spins, default 50us")
          ->type_name("T")
          ->check(quantity(Dimension::kTime, 0.0, 1e-2, "50us")),
      command.add_flag_callback(
          "--no-realtime", [&options] { options.realtime = false; },
          "Takes what any thread gets: no SCHED_FIFO, no core of its own")};
}

/// The flags that write problem files. The first of them returns so that it can be tied to another flag.
CLI::Option* add_dump(CLI::App& command, Options& options) {
  CLI::Option* const folder =
      command
          .add_option(
              "--dump-problems", options.dump_problems,
              "Folder for contact-T.fcp, grasp-T.json and muscle-T.json: the problems that were solved in tick T, for "
              "thenar solve. Not with --realtime, where writing would make ticks late")
          ->type_name("DIR")
          ->check(named());
  command.add_option("--dump-every", options.dump_every, "Ticks from one dump to the next")
      ->type_name("N")
      ->capture_default_str()
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}).description(""))
      ->needs(folder);
  return folder;
}

/// The command that solves problem files.
CLI::App* add_solve(CLI::App& app, Options& options) {
  CLI::App* const command = app.add_subcommand(
      "solve", "Solves problem files, and tells the residuals, recomputed from the files, and the times");
  command
      ->add_option("FILE", options.problems,
                   "Problem files: .fcp (contact), .json (P1 grasp forces, P2 muscle forces, LCP)")
      ->required();
  command
      ->add_option(
          "--method", options.method,
          "How; the first is the default. contact: newton (Gauss-Seidel, then Newton), gauss_seidel. P1: "
          "active_set, lemke (pyramids), exact_cone. P2: active_set, lemke. LCP: lemke. all: each that applies")
      ->type_name("METHOD")
      ->check(CLI::IsMember({"newton", "gauss_seidel", "active_set", "lemke", "exact_cone", "all"}).description(""));
  command
      ->add_option("--tolerance", options.tolerance,
                   "Largest residual of a solution, default 1e-8 for contact (natural map), else 1e-10 (share of the "
                   "forces); for "
                   "grasps not less than what rounding does to the forces of contacts that are nearly on a line")
      ->type_name("NUMBER")
      ->check(CLI::Range(1e-15, 1.0).description(""));
  command
      ->add_option("--repeat", options.repeat,
                   "Timed solves of each problem, from no forces. An .fcp file with several steps, or with the forces "
                   "of the tick before, has a second row: each step from the forces before it, iterations a step")
      ->type_name("N")
      ->capture_default_str()
      ->check(CLI::Range(1, 1'000'000).description(""));
  command->add_option("--format", options.format, "What to print")->check(CLI::IsMember({"text", "json"}));
  command->add_flag("--forces", options.forces, "Shows the forces (z of an LCP), too");
  command->footer(
      "Exit code: 0 if every verdict is right and every solution within the tolerance, 2 for a wrong command, "
      "3 for a file that cannot be read, else 6.");
  return command;
}

std::string period(double frequency_Hz) { return thenar::to_text(1.0 / frequency_Hz, Dimension::kTime); }

/// The flags as changes of the scene, around those that the user set by key: a default of ours gives way to them, a flag
/// does not.
void apply(const SceneFlags& flags, Options& options) {
  std::vector<std::string> defaults, asked;
  const double contact_Hz = flags.contact_rate.empty() ? kProfileContact_Hz : rate_Hz(flags.contact_rate);
  options.auto_control_rate = flags.control_rate == "auto";
  options.contact_rate = flags.contact_rate;
  options.control_rate = flags.control_rate;
  if (options.runner == Runner::kRealtime) defaults = {"contact.tolerance=1e-7", "contact.max_sweeps=60"};
  if (options.command == Command::kProfile) {
    defaults.push_back("time.step=" + period(contact_Hz));
    // What is measured later only has to go with the contact rate until then.
    const double control_Hz = options.auto_control_rate ? std::min(kProfileControl_Hz, contact_Hz) : kProfileControl_Hz;
    defaults.push_back("time.control_period=" + period(control_Hz));
  }
  if (!flags.contact_rate.empty()) asked.push_back("time.step=" + period(contact_Hz));
  if (!flags.control_rate.empty() && !options.auto_control_rate) {
    asked.push_back("time.control_period=" + period(rate_Hz(flags.control_rate)));
  }
  if (!flags.control_delay.empty()) asked.push_back("time.control_delay=" + flags.control_delay);
  if (!flags.tolerance.empty()) asked.push_back("contact.tolerance=" + flags.tolerance);
  if (options.command == Command::kProfile) asked.push_back("time.duration=" + flags.duration);
  if (!flags.time.empty()) asked.push_back("time.duration=" + with_unit(flags.time));
  if (!flags.spin.empty()) options.spin_s = time_s(flags.spin);
  if (!flags.control_jitter.empty()) options.control_jitter_s = time_s(flags.control_jitter);
  options.overrides.insert(options.overrides.begin(), defaults.begin(), defaults.end());
  options.overrides.insert(options.overrides.end(), asked.begin(), asked.end());
}

/// What the flags cannot say together.
void check_together(const SceneFlags& flags, Runner runner) {
  const bool rates = !flags.contact_rate.empty() || !flags.control_rate.empty();
  const char* const first = flags.contact_rate.empty() ? "--control-rate" : "--contact-rate";
  if (rates && runner == Runner::kMonolithic) throw CLI::ValidationError(first, "needs --realtime or --lockstep");
  if (flags.control_rate == "auto" && runner == Runner::kLockstep) {
    throw CLI::ValidationError("--control-rate", "auto needs --realtime: a virtual clock is never late");
  }
  if (flags.contact_rate.empty() || flags.control_rate.empty() || flags.control_rate == "auto") return;
  if (rate_Hz(flags.control_rate) <= rate_Hz(flags.contact_rate)) return;
  throw CLI::ValidationError("--control-rate", flags.control_rate + " must not be faster than --contact-rate");
}

/// Throws if the trace would be one of the results, of which it would leave nothing.
void check_trace(const Options& options) {
  if (options.trace.empty() || options.out.empty()) return;
  const auto is_trace = [trace = fs::weakly_canonical(options.trace), &options](const char* result) {
    return fs::weakly_canonical(options.out / result) == trace;
  };
  if (is_trace("profile.json") ||
      std::any_of(thenar::kProfileFigures.begin(), thenar::kProfileFigures.end(), is_trace)) {
    throw CLI::ValidationError("--trace", options.trace.string() + " is a file of --out's own");
  }
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv, int& exit_code) {
  CLI::App app{"Real-time human grasp: three deformable fingertips, 23 muscles"};
  app.set_version_flag("--version", std::string("thenar ") + std::string(thenar::build_info::kVersion));
  app.require_subcommand(1);
  Options options;
  SceneFlags flags;

  CLI::App* const run = app.add_subcommand("run", "Runs a scene and prints what came of it");
  add_scene(*run, options);
  add_results(*run, options, "summary.json, signals.csv and figures");
  run->add_option("--time", flags.time, "Simulated time in seconds, or with a unit, such as '500 ms'")
      ->type_name("T")
      ->check(simulated_time());
  CLI::Option* const realtime = run->add_flag_callback(
      "--realtime", [&] { options.runner = Runner::kRealtime; }, "Runs it on two threads, in real time");
  CLI::Option* const lockstep = run->add_flag_callback(
      "--lockstep", [&] { options.runner = Runner::kLockstep; }, "Runs the two loops on a virtual clock");
  lockstep->excludes(realtime);
  add_loops(*run, flags);
  for (CLI::Option* option : add_threads(*run, flags, options)) option->needs(realtime);
  run->add_option("--control-delay", flags.control_delay,
                  "From a control tick's start to its frame's use, such as 20ms")
      ->type_name("T")
      ->check(quantity(Dimension::kTime, 0.0, 1e3, "20ms"))
      ->needs(lockstep);
  run->add_option("--control-jitter", flags.control_jitter, "Each frame takes up to so much longer, such as 2ms")
      ->type_name("T")
      ->check(quantity(Dimension::kTime, 0.0, 1e3, "2ms"))
      ->needs(lockstep);
  run->add_option(
         "--record", options.record,
         "MCAP file of what the run looks like, 50 states a second: thenar demo replays it, thenar export shares it")
      ->type_name("FILE")
      ->check(named())
      ->check(no_folder());
  add_dump(*run, options)->excludes(realtime);

  CLI::App* const profile = app.add_subcommand("profile", "Runs a scene in real time and tells the times of its loops");
  add_scene(*profile, options);
  add_results(*profile, options, "profile.json and figures");
  add_loops(*profile, flags);
  add_threads(*profile, flags, options);
  flags.duration = "30s";
  profile->add_option("--duration", flags.duration, "How long, such as 30s")
      ->type_name("T")
      ->capture_default_str()
      ->check(quantity(Dimension::kTime, 1e-3, 1e5, "30s"));
  profile->add_flag("--floor", options.floor, "Runs cyclictest in between: what this machine can do at best");
  profile->add_option("--trace", options.trace, "File for the last 5 s as a Chrome trace, which Perfetto opens")
      ->type_name("FILE")
      ->check(named())
      ->check(no_folder());

  CLI::App* const solve = add_solve(app, options);
  CLI::App* const check =
      app.add_subcommand("check", "Says what a scene will model, what it leaves out, and the defaults");
  add_scene(*check, options);
  CLI::App* const doctor =
      app.add_subcommand("doctor", "Says what this machine can keep, and how to get what it refuses");

  try {
    app.parse(argc, argv);
    if (check->parsed()) options.command = Command::kCheck;
    if (solve->parsed()) options.command = Command::kSolve;
    if (doctor->parsed()) options.command = Command::kDoctor;
    if (profile->parsed()) options.command = Command::kProfile;
    if (profile->parsed()) options.runner = Runner::kRealtime;
    check_together(flags, options.runner);
    check_trace(options);
  } catch (const CLI::ParseError& error) {
    exit_code = app.exit(error) == 0 ? kDone : kBadUsage;
    return std::nullopt;
  }
  apply(flags, options);
  return options;
}

thenar::Scene load_scene(const Options& options) try {
  return thenar::load_scene(options.scene, options.overrides);
} catch (const thenar::ConfigError& error) {
  std::vector<thenar::ConfigDiagnostic> diagnostics = error.diagnostics();
  for (thenar::ConfigDiagnostic& fault : diagnostics) {
    if (fault.key != "time.control_period" || !fault.message.starts_with("must not be shorter")) continue;
    if (!options.control_rate.empty() && !options.auto_control_rate) {
      fault = {"--control-rate", "",
               options.control_rate + " must not be faster than " +
                   (options.contact_rate.empty() ? "the contact loop: give --contact-rate, too" : "--contact-rate")};
    } else if (!options.contact_rate.empty()) {
      fault = {"--contact-rate", "",
               options.contact_rate + " must not be slower than the control loop: give --control-rate, too"};
    }
  }
  throw thenar::ConfigError(std::move(diagnostics));
}
