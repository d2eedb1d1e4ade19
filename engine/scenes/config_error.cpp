// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include "engine/formats/text.h"
#include "engine/scenes/config.h"

namespace thenar {

namespace {

/// Messages quote files and their names, whatever bytes these have.
std::vector<ConfigDiagnostic> in_print(std::vector<ConfigDiagnostic> diagnostics) {
  for (ConfigDiagnostic& d : diagnostics) {
    d = {printable(d.location), printable(d.key), printable(d.message)};
  }
  return diagnostics;
}

std::string lines(const std::vector<ConfigDiagnostic>& diagnostics) {
  std::string text;
  for (const ConfigDiagnostic& d : diagnostics) {
    if (!text.empty()) text += '\n';
    // "--set key" and "--vary key" have said it.
    const bool told = d.key.empty() || (d.location.starts_with("--") && d.location.ends_with(" " + d.key));
    text += d.location + ": " + (told ? "" : d.key + ": ") + d.message;
  }
  return text;
}

}  // namespace

ConfigError::ConfigError(const std::vector<ConfigDiagnostic>& diagnostics)
    : std::runtime_error(lines(in_print(diagnostics))), diagnostics_(in_print(diagnostics)) {}

}  // namespace thenar
