// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/app/refusals.h"

namespace thenar::refusals {

/// A recording by its first bytes: the mark of MCAP and a header.
inline std::string begun_recording() {
  const std::string header = bytes_of({4}) + "ros2" + bytes_of({0});
  return "\x89MCAP0\r\n\x01" + bytes_of({static_cast<std::uint32_t>(header.size()), 0}) + header;
}

/// One without any message, which another program may have written.
inline std::string foreign_recording() {
  return begun_recording() + "\x02" + bytes_of({20, 0, 0, 0, 0, 0, 0}) + "\x89MCAP0\r\n";
}

/// Problems, recordings, sweeps, tasks, command lines, and what surrounds the program.
inline Refusals refused_runs() {
  const auto command = [](const char* what, const char* line, const char* message) {
    return Refusal{what, line, "", "", 2, message, ""};
  };
  const auto task = [](const char* what, const char* set, const char* message) {
    return Refusal{what, std::string("check grip_lift --set '") + set + "'", "", "", 2, message, ""};
  };
  return {
      // Problems
      {"a comma too many", "solve FILE", "lcp.json", R"({"problem": "LCP", "M": [[1, 0], [0, 1]], "q": [1, 2],})", 3,
       "FILE: line 1, column 55: is no JSON: unexpected '}'; expected string literal", ""},
      {"a method of other problems", "solve FILE --method newton", "lcp.json",
       R"({"problem": "LCP", "M": [[1, 0], [0, 1]], "q": [1, 2]})", 2,
       "--method: newton does not solve FILE (LCP), for which there are lemke and all", ""},
      // Recordings
      {"a recording that was cut off", "export FILE --csv film.csv", "film.mcap", begun_recording(), 3,
       "FILE: was cut off before its first state: record it again", ""},
      {"a recording of another program", "export FILE --csv film.csv", "film.mcap", foreign_recording(), 3,
       "FILE: holds no states: it is no recording of `thenar run --record`", ""},
      // Sweeps
      command("a range without a count", "sweep minimal --out out --vary contact.friction=0.4:1",
              "--vary contact.friction=0.4:1: write a range as from:to:count or from:to:count:log"),
      // Tasks
      task("fingers that lift before they hold",
           "task.phases=[{close: {press: 0.3 N, speed: 20 mm/s}}, {lift: {by: [0 mm, 0 mm, 30 mm], over: 1 s}}]",
           "--set task.phases: task.phases[1].lift: needs fingers that hold the object: load comes before"),
      task("a phase that there is not", "task.phases=[{clsoe: {press: 0.3 N, speed: 20 mm/s}}]",
           "--set task.phases: task.phases[0].clsoe: unknown key, did you mean 'task.phases[0].close'?"),
      // Command lines
      command("a command is misspelt", "rnu minimal",
              "thenar: 'rnu' is no command, did you mean 'run'? `thenar --help` lists all commands"),
      command("a flag is misspelt", "run minimal --tme 1s",
              "there is no flag --tme, did you mean '--time'? `thenar run --help` lists what it takes"),
      command("a flag without its value", "run minimal --time",
              "--time: its value is missing; `thenar run --help` lists what it takes"),
      command("blanks about an equals sign", "run minimal --set contact.friction = 0.5",
              "--set contact.friction: write it without blanks about the '=': 'contact.friction=0.5'"),
      Refusal{"a scene that there is not", "run box_gasp", "", "", 3,
              "box_gasp: no such file, nor a scene that comes with the program, did you mean 'box_grasp'?", ""},
      // Surroundings
      {"a file where a folder should be", "run minimal --set object.points=2000 --out FILE", "out", "kept", 3,
       "FILE: cannot make this folder: FILE is a file", ""},
      {"a full disk", "keys contact", "", "", 3, "standard output: could not be written in full",
       "sh -c '\"$@\" 3>&1 >/dev/full 2>&3' - "},
  };
}

}  // namespace thenar::refusals
