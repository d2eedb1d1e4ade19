// SPDX-License-Identifier: Apache-2.0
#include "app/scene_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "engine/formats/byte_source.h"
#include "engine/formats/text.h"
#include "engine/loops/realtime.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/shared_data.h"

namespace thenar::app {

namespace {

constexpr double kFastest_Hz = 100e3, kSlowest_Hz = 1.0;  // Of a loop: what may make sense, with room.
constexpr double kContact_Hz = 4000.0, kControl_Hz = 1000.0;

CLI::Validator or_auto(const CLI::Validator& rule) {
  return {[rule](std::string& text) { return text == "auto" ? "" : rule(text); }, ""};
}
CLI::Validator rate() { return quantity(Dimension::kFrequency, kSlowest_Hz, kFastest_Hz, "200Hz"); }

double rate_Hz(const std::string& text) { return read_quantity(text, Dimension::kFrequency).value; }
/// A check that a text is one of these words.
CLI::Validator one_of(const std::vector<std::string>& words) {
  const std::string all = fmt::format("{}", fmt::join(words, ", "));
  return {[words, all](const std::string& text) -> std::string {
            if (std::ranges::find(words, text) != words.end()) return "";
            const std::vector<std::string_view> candidates(words.begin(), words.end());
            return fmt::format("'{}' is none of {}{}", printable(text), all,
                               did_you_mean(nearest_word(text, candidates)));
          },
          ""};
}

std::string period(double frequency_Hz) { return to_text(1.0 / frequency_Hz, Dimension::kTime); }

}  // namespace

CLI::Validator quantity(Dimension dimension, double low, double high, const char* example) {
  return {[=](const std::string& text) -> std::string {
            const Quantity read = read_quantity(text, dimension);
            if (!read.fault.empty()) return read.fault + fmt::format(", such as '{}'", example);
            if (read.value >= low && read.value <= high) return "";
            return fmt::format("{} must lie within {} .. {}", text, to_text(low, dimension), to_text(high, dimension));
          },
          ""};
}

CLI::Validator named() {
  return {[](const std::string& text) -> std::string { return text.empty() ? "needs a name" : ""; }, ""};
}
CLI::Validator no_folder() {
  return {[](const std::string& text) -> std::string {
            std::error_code none;  // What cannot be looked at is found out when it is written.
            return std::filesystem::is_directory(text, none) ? text + " is a folder, and must be a file" : "";
          },
          ""};
}

CLI::Validator within(double low, double high) {
  return {[=](const std::string& text) -> std::string {
            const auto number = number_in<double>(text);
            if (number && *number >= low && *number <= high) return "";
            return fmt::format("'{}' is no number within {:g} .. {:g}", printable(text), low, high);
          },
          ""};
}

CLI::Validator whole_within(std::int64_t low, std::int64_t high) {
  return {[=](const std::string& text) -> std::string {
            const auto number = number_in<std::int64_t>(text);
            if (number && *number >= low && *number <= high) return "";
            return fmt::format("'{}' is no whole number within {} .. {}", printable(text), low, high);
          },
          ""};
}

CLI::Option* add_choice(CLI::App& command, const char* flag, std::string& value, const std::vector<std::string>& words,
                        const char* description) {
  return command.add_option(flag, value, description)
      ->type_name(fmt::format("{}", fmt::join(words, "|")))
      ->check(one_of(words));
}

void add_core(CLI::App& command, int& core) {
  command.add_option("--core", core, "The contact thread's core; default: the last one that the program may use")
      ->type_name("N")
      ->check({[](const std::string& text) -> std::string {
                 std::string all;
                 for (const int allowed : allowed_cores()) {
                   if (text == std::to_string(allowed)) return "";
                   all += (all.empty() ? "" : ", ") + std::to_string(allowed);
                 }
                 return fmt::format("{} is none of the cores that the program may use: {}", text, all);
               },
               ""});
}

Quantity read_unit(const std::string& text) {
  Quantity unit = read_quantity(text, Dimension::kLength);
  if (!unit.fault.empty()) unit = read_quantity("1 " + text, Dimension::kLength);
  if (!unit.fault.empty()) unit.fault = text + " is no unit of length, such as mm or '25.4 mm'";
  return unit;
}

std::string with_unit(const std::string& text) { return number_in<double>(text) ? text + " s" : text; }

CLI::Validator some_time() {
  const CLI::Validator rule = quantity(Dimension::kTime, 1e-6, 1e5, "500 ms");
  return {[rule](const std::string& text) {
            std::string time = with_unit(text);
            return rule(time);
          },
          ""};
}

double time_s(const std::string& text) { return read_quantity(text, Dimension::kTime).value; }

std::vector<std::string> RateFlags::changes() const {
  std::vector<std::string> asked;
  if (!contact.empty()) asked.push_back("time.step=" + period(rate_Hz(contact)));
  if (!control.empty() && !auto_control()) asked.push_back("time.control_period=" + period(rate_Hz(control)));
  return asked;
}

std::vector<std::string> RateFlags::defaults() const {
  const double contact_Hz = contact.empty() ? kContact_Hz : rate_Hz(contact);
  // Control is no faster than contact.
  const double control_Hz = std::min(kControl_Hz, contact_Hz);
  return {"time.step=" + period(contact_Hz), "time.control_period=" + period(control_Hz)};
}

std::vector<std::string> realtime_defaults() { return {"contact.tolerance=1e-7", "contact.max_sweeps=60"}; }

void add_scene(CLI::App& command, std::filesystem::path& scene, std::vector<std::string>& overrides,
               const char* description, bool or_hand) {
  const CLI::Validator by_name{[or_hand](std::string& text) -> std::string {
                                 text = (or_hand ? find_scene_or_hand(text) : find_scene(text)).string();
                                 return "";
                               },
                               ""};
  command.add_option(or_hand ? "SCENE|HAND" : "SCENE", scene, description)->required()->transform(by_name);
  command.add_option("--set", overrides, "Changes a value: key.path=value, as often as needed")
      ->take_all()
      ->type_name("KEY=VALUE");
}

void add_rates(CLI::App& command, RateFlags& rates, bool may_be_auto) {
  command.add_option("--contact-rate", rates.contact, "Ticks a second of the contact loop, such as 4kHz")
      ->type_name("RATE")
      ->check(rate());
  command
      .add_option("--control-rate", rates.control,
                  may_be_auto ? "Of the control loop, such as 1kHz; auto, in real time: what this machine keeps"
                              : "Of the control loop, such as 1kHz")
      ->type_name(may_be_auto ? "RATE|auto" : "RATE")
      ->check(may_be_auto ? or_auto(rate()) : rate());
}

void check_rates(const RateFlags& rates) {
  if (rates.contact.empty() || rates.control.empty() || rates.auto_control()) return;
  if (rate_Hz(rates.control) <= rate_Hz(rates.contact)) return;
  throw CLI::ValidationError("--control-rate", rates.control + " must not be faster than --contact-rate");
}

Scene scene_at_rates(const std::filesystem::path& scene, const std::vector<std::string>& overrides,
                     const RateFlags& rates) try {
  return load_scene(scene, overrides);
} catch (const ConfigError& error) {
  std::vector<ConfigDiagnostic> diagnostics = error.diagnostics();
  for (ConfigDiagnostic& fault : diagnostics) {
    if (fault.key != "time.control_period" || !fault.message.starts_with("must not be shorter")) continue;
    if (!rates.control.empty() && !rates.auto_control()) {
      fault = {"--control-rate", "",
               rates.control + " must not be faster than " +
                   (rates.contact.empty() ? "the contact loop: give --contact-rate, too" : "--contact-rate")};
    } else if (!rates.contact.empty()) {
      fault = {"--contact-rate", "",
               rates.contact + " must not be slower than the control loop: give --control-rate, too"};
    }
  }
  throw ConfigError(diagnostics);
}

}  // namespace thenar::app
