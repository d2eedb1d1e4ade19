// SPDX-License-Identifier: Apache-2.0
#include "app/run/fields.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <iterator>
#include <string_view>

#include "engine/finder/grasp_measures.h"
#include "engine/results/contact_fields.h"
#include "engine/results/run_measures.h"
#include "engine/results/tick_fields.h"

namespace thenar::app {

namespace {

struct OfInWords {
  std::string_view count, owner, place, type;
};
/// In the order of Of.
constexpr std::array<OfInWords, 13> kWords = {{{"1", "", "", "float"},
                                               {"1", "", "", "int"},
                                               {"1", "", "", "bool"},
                                               {"3", "", "x", "_Array"},
                                               {"12", "", "x", "_Array"},
                                               {"1 a finger", "FINGER", "", "_Array"},
                                               {"3 a finger", "FINGER", "x", "_Array"},
                                               {"3 a body", "BODY", "x", "_Array"},
                                               {"1 a joint", "JOINT", "", "_Array"},
                                               {"1 a muscle", "MUSCLE", "", "_Array"},
                                               {"3", "", "p50", "_Array"},
                                               {"some", "", "", "_Array"},
                                               {"some", "", "", "_Array"}}};

const OfInWords& of_in_words(const TickField& field) { return kWords.at(static_cast<std::size_t>(field.of)); }

/// Its first column: "FINGER_slip_um".
std::string column_of(const TickField& field) {
  if (field.of == Of::kShape) return "";
  if (field.of == Of::kList) return fmt::format("`{}[0]`", field.name);
  const OfInWords& words = of_in_words(field);
  std::string name;
  for (const std::string_view part : {words.owner, field.shown, words.place, field.shown_unit}) {
    if (!part.empty()) name.append(name.empty() ? "" : "_").append(part);
  }
  const bool is_named = !field.shown.empty() || !words.owner.empty();
  return fmt::format("`{}`", is_named ? name : std::string(field.name));
}

/// What it is, and of which scenes.
template <typename AnyField>
std::string sentence_of(const AnyField& field) {
  if (field.scenes == nullptr) return std::string(field.sentence);
  return fmt::format("{} Only {}.", field.sentence, field.scenes->which);
}

std::string_view lists_of(const TickField& field) {
  if (field.is_in_signals()) return "all";
  return field.is_in_python() ? "all but signals.csv" : "messages";
}

/// "`width`, mm".
std::string shown_as(const GraspMeasure& measure) {
  if (measure.shown.empty()) return "";
  return fmt::format("`{}`{}{}", measure.shown, measure.shown_unit.empty() ? "" : ", ", measure.shown_unit);
}

void add_property(std::string_view name, std::string_view type, std::string& lines) {
  fmt::format_to(std::back_inserter(lines), "    @property\n    def {}(self) -> {}: ...\n", name, type);
}

}  // namespace

std::string fields_as_markdown() {
  std::string page =
      "# The fields of a tick\n\n"
      "This page is written by `thenar fields`, from the rows in `engine/results/tick_fields.cpp` that all of these "
      "lists are made\nof: state messages and recordings, their columns and exports (\"messages\"), `signals.csv`, and "
      "in "
      "Python the views of\n`Simulation`, `rollout()` and `Realtime.state()`.\n\n"
      "A column is named by the finger, joint or muscle that it belongs to, by its axis and by its unit; of several "
      "columns the\nfirst is shown. A pose is position, then rotation by rows (columns `_R_11` to `_R_33`); in Python "
      "it is a matrix of 4 x 4.\nA field with a condition is in scenes that fulfil it; elsewhere messages, columns and "
      "`Realtime.state()` leave it out, and\nviews have no rows; a number keeps its default, and a stiffness is None. "
      "`Simulation` has more than a number of\n`contacts` and `reflex`, and its `target` can be set.\n\n"
      "| field | count | unit | column | in | |\n|---|---|---|---|---|---|\n";
  for (const TickField& field : tick_fields()) {
    fmt::format_to(std::back_inserter(page), "| `{}` | {} | {} | {} | {} | {} |\n", field.name,
                   of_in_words(field).count, field.unit, column_of(field), lists_of(field), sentence_of(field));
  }
  page +=
      "\n## The fields of a contact\n\nA row for each contact, behind the fields of a state message; in Python a "
      "structured array.\n\n| field | count | unit | |\n|---|---|---|---|\n";
  for (const ContactField& field : contact_fields()) {
    fmt::format_to(std::back_inserter(page), "| `{}` | {} | {} | {} |\n", field.name, field.count, field.unit,
                   sentence_of(field));
  }
  page +=
      "\n## The measures of a found grasp\n\nMessages and Python have them by their names. The table of `thenar grasp` "
      "and the window show them by other\nnames, in other units. Measures that are shown by one name share a column: "
      "it has the first one that the grasp has.\n\n| measure | unit | shown as | |\n|---|---|---|---|\n";
  for (const GraspMeasure& measure : grasp_measures()) {
    fmt::format_to(std::back_inserter(page), "| `{}` | {} | {} | {} |\n", measure.name, measure.unit, shown_as(measure),
                   measure.sentence);
  }
  return page;
}

std::string fields_as_stub() {
  std::string lines;
  for (const TickField& field : tick_fields()) {
    if (!field.is_in_python()) continue;
    const std::string_view type = of_in_words(field).type;
    const std::string optional = field.from == From::kState ? fmt::format("Optional[{}]", type) : std::string(type);
    add_property(field.name, optional, lines);
  }
  lines += '\n';
  for (const GraspMeasure& measure : grasp_measures()) add_property(measure.name, "float", lines);
  return lines;
}

std::string measures_as_markdown() {
  std::string page =
      "# The measures of a run\n\n"
      "This page is written by `thenar fields --measures`, from the rows in `engine/results/run_measures.cpp`, of\n"
      "which `summary.json`, the printed table and the columns of `rows.csv` are made. A dot is an object within; "
      "`[]`\n"
      "is a list with an object for each. A stage is an object with `p50_us` and `p99_us`, over the ticks that ran\n"
      "it. What was not measured is `null`. A measure with a condition is in runs that fulfil it.\n\n"
      "| in `summary.json` | unit | in `rows.csv` | |\n|---|---|---|---|\n";
  for (const MeasureSection& section : measure_sections()) {
    const std::string within = std::string(section.key) + (section.items != nullptr ? "[]" : "");
    for (const RunMeasure& measure : section.measures) {
      const Runs& runs = measure.runs != nullptr ? *measure.runs : *section.runs;
      fmt::format_to(std::back_inserter(page), "| {} | {} | {} | {}{} |\n",
                     section.heading == Heading::kSweepAlone
                         ? ""
                         : fmt::format("`{}{}{}`", within, within.empty() ? "" : ".", measure.key),
                     measure.unit.name, measure.column > 0 ? fmt::format("`{}`", measure.column_name()) : "",
                     measure.sentence, runs.which.empty() ? "" : fmt::format(" Only {}.", runs.which));
    }
  }
  return page;
}

}  // namespace thenar::app
