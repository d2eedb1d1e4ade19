// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace thenar {

// What the report is drawn from. A part of it is a program that measures and writes one JSON file:
//
//     {"part", "title", "text", "measured": {machine, threads, compiler, flags, type, version, quick}, "figures":
//     [...]}
//
// and a figure is an object with "kind", "id", "title", "caption" (the figure is understood from it alone), "runs"
// (what a number is the median of, and how runs were interleaved), and by its kind:
//
//     work_precision  error over time, a panel a case. "error", "time": labels with units; "choice": what is chosen
//                     among ("contact solver"); "cases": [{"name", "points": [WorkPoint]}]
//     map             what becomes of a grasp over two settings. "x", "y": {"label", "values", "log"}; "panels":
//                     [{"name", "ours", "cells": rows by y of columns by x of {"outcome", "reason"}, "limits":
//                     [{"label", "x": [], "y": []}]}]; "reference": [x, y], where the scene itself is, or null
//     curves          "x", "y": {"label", "log"}; "panels": [{"name", "curves": [{"name", "x", "y", "exponent" or null,
//                     "peer"}]}]; a curve may have "low" and "high", a band of scatter, and "theory": true, a black
//                     line without markers, which is a law or a limit and no measurement
//     table           "columns": [text], "rows": [[text or number]]
//
// A number that is not finite is written as null.

/// A method at one of its settings.
struct WorkPoint {
  std::string method, setting;  ///< Points of one method are joined by a line.
  double error = 0.0, us = 0.0;
  double us_p99 = std::numeric_limits<double>::quiet_NaN();
  bool is_default = false;  ///< What a scene gets that says nothing else.
  bool peer = false;        ///< Not part of Thenar: another project's, or a textbook's.
  bool published = false;   ///< Part of the published model: kept for fidelity.
};

/// Points that are no part of Thenar, and those of the published model, are no candidates for a default.
void to_json(nlohmann::ordered_json& json, const WorkPoint& point);

/// p of y = c x^p, by least squares of logarithms over the upper half of x, where what does not grow no longer counts;
/// over all of fewer than six.
[[nodiscard]] double exponent(const std::vector<double>& x, const std::vector<double>& y);

/// A curve, with its exponent.
[[nodiscard]] nlohmann::ordered_json curve(const std::string& name, const std::vector<double>& x,
                                           const std::vector<double>& y, bool peer = false);

/// A curve that is no power of x.
[[nodiscard]] nlohmann::ordered_json plain_curve(const std::string& name, const std::vector<double>& x,
                                                 const std::vector<double>& y);

/// What a law says, or where a limit lies.
[[nodiscard]] nlohmann::ordered_json theory_curve(const std::string& name, const std::vector<double>& x,
                                                  const std::vector<double>& y);

/// Appends a figure to the part; what its kind needs beside these is the caller's to fill in.
nlohmann::ordered_json& add_figure(nlohmann::ordered_json& part, const std::string& kind, const std::string& id,
                                   const std::string& title, const std::string& caption, const std::string& runs);

/// Measures something, and adds it to the part.
using Section = void (*)(nlohmann::ordered_json& part, bool quick);

/// All of a part's program, `[--quick] FILE`: returns its exit code, 2 for another command line, 1 where it fails.
[[nodiscard]] int run_part(int argc, char** argv, const std::string& name, const std::string& title,
                           const std::string& text, const std::vector<Section>& sections);

}  // namespace thenar
