// SPDX-License-Identifier: Apache-2.0
#include "app/record_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "app/scene_flags.h"
#include "engine/formats/byte_source.h"
#include "engine/scenes/config.h"
#include "engine/scenes/units.h"

namespace thenar::app {

namespace {

/// A bare number is one of hertz.
std::string in_hertz(const std::string& rate) { return number_in<double>(rate) ? rate + " Hz" : rate; }

double rate_Hz(const RecordFlags& flags) {
  if (flags.rate.empty()) return kRecordingRate_Hz;
  return read_quantity(in_hertz(flags.rate), Dimension::kFrequency).value;
}

CLI::Validator some_rate() {
  const CLI::Validator rule = quantity(Dimension::kFrequency, kLeastRecordingRate_Hz, 100e3, "200 Hz");
  return {[rule](const std::string& text) {
            std::string rate = in_hertz(text);
            return rule(rate);
          },
          ""};
}

}  // namespace

RecordingSettings RecordFlags::settings() const {
  return {.rate_Hz = rate_Hz(*this), .fields = fields, .contacts = contacts};
}

void add_record(CLI::App& command, RecordFlags& flags, const char* what) {
  CLI::Option* const record =
      command.add_option("--record", flags.file, what)->type_name("FILE")->check(named())->check(no_folder());
  command
      .add_option("--record-rate", flags.rate,
                  "States of a simulated second in it, default 50; as many as contact ticks at most")
      ->type_name("HZ")
      ->check(some_rate())
      ->needs(record);
  command
      .add_option("--record-fields", flags.fields,
                  "Names of the fields that are kept of a state, such as q_rad,force_N; default: all, which a picture "
                  "needs")
      ->type_name("NAME,...")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->needs(record);
  command.add_flag("--record-contacts", flags.contacts, "Keeps the force and slip of every contact in every tick, too")
      ->needs(record);
}

void check_record(const Model& model, const RecordFlags& flags) {
  const std::string unknown = unknown_field(model, flags.fields);
  if (!unknown.empty()) throw ConfigError({{"--record-fields", "", unknown}});
  const double contact_Hz = 1.0 / model.scene.step_s;
  if (rate_Hz(flags) <= contact_Hz * (1.0 + 1e-9)) return;
  throw ConfigError({{"--record-rate", "",
                      fmt::format("{} is more than the {:.6g} Hz of the contact loop", flags.rate, contact_Hz)}});
}

void finish_recording(RecordingFile& film, const Recording& run) {
  if (!film.missing().empty()) std::cerr << "warning: " << film.missing() << '\n';
  film.finish(run);
}

}  // namespace thenar::app
