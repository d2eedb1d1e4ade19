// SPDX-License-Identifier: Apache-2.0
// The program `thenar`: it runs scenes and says what they may name. What takes longer to be built than that is another
// program, which this one becomes when it is asked for: the first run of a scene does without.

#include <exception>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "app/completion.h"
#include "app/exit_code.h"
#include "app/host.h"
#include "app/man_page.h"
#include "app/program.h"
#include "app/run/docs.h"
#include "app/run/doctor.h"
#include "app/run/export.h"
#include "app/run/fields.h"
#include "app/run/keys.h"
#include "app/run/run.h"
#include "engine/scenes/shared_data.h"

namespace thenar::app {

namespace {

int tell_keys(const Options& options) {
  return print(options.markdown ? keys_as_markdown() : keys_as_text(options.prefix));
}

int tell_fields(const Options& options) {
  if (options.stub) return print(fields_as_stub());
  return print(options.measures ? measures_as_markdown() : fields_as_markdown());
}

int tell_machine(const Options& options) {
  doctor(std::cout, options.core);
  return kDone;
}

int tell_manual(const Options& /*options*/) {
  std::string page;
  with_command_line([&page](const CLI::App& program) { page = man_page(program); });
  return print(page);
}

/// Not a command of the help: shells call it while a command line is typed.
int complete(const std::vector<std::string>& words) try {
  std::string lines;
  with_command_line([&](const CLI::App& program) { lines = completions(program, words); });
  return print(lines);
} catch (const std::exception&) {
  return kBadFile;  // Scenes that cannot be read: nothing is completed, and no message breaks the line.
}

int run_command(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "complete") return complete({argv + 2, argv + argc});
  const Commands commands{{"run", run},
                          {"export", export_recording},
                          {"keys", tell_keys},
                          {"fields", tell_fields},
                          {"schema", [](const Options&) { return print(keys_as_schema()); }},
                          {"doctor", tell_machine},
                          {"docs", show_docs},
                          {"man", tell_manual},
                          {"scenes", [](const Options&) { return print(list_of_scenes()); }}};
  return run_program(argc, argv, commands, "thenar-studies");
}

}  // namespace

}  // namespace thenar::app

int main(int argc, char** argv) {
  thenar::app::hold_standard_streams();
  return thenar::app::run_command(argc, argv);
}
