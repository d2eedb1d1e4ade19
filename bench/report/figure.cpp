// SPDX-License-Identifier: Apache-2.0
#include "bench/report/figure.h"

#include <cmath>
#include <fstream>
#include <iostream>
#include <string_view>
#include <thread>

#include "engine/formats/files.h"
#include "engine/results/summary.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(": ") + 2);
  }
  return "an unknown processor";
}

ordered_json measured(bool quick) {
  ordered_json measured = build_settings();
  measured["machine"] = processor();
  measured["threads"] = std::thread::hardware_concurrency();
#ifdef THENAR_PEERS
  measured["peers"] = THENAR_PEER_VERSIONS;
#endif
  measured["quick"] = quick;
  return measured;
}

}  // namespace

void to_json(ordered_json& json, const WorkPoint& point) {
  json = {{"method", point.method}, {"setting", point.setting},    {"error", point.error},
          {"us", point.us},         {"us_p99", point.us_p99},      {"default", point.is_default},
          {"peer", point.peer},     {"published", point.published}};
}

double exponent(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t first = x.size() < 6 ? 0 : x.size() / 2;
  const auto count = static_cast<double>(x.size() - first);
  double x_mean = 0.0, y_mean = 0.0, xy = 0.0, xx = 0.0;
  for (std::size_t i = first; i < x.size(); ++i) {
    x_mean += std::log(x[i]) / count;
    y_mean += std::log(y[i]) / count;
  }
  for (std::size_t i = first; i < x.size(); ++i) {
    xy += (std::log(x[i]) - x_mean) * (std::log(y[i]) - y_mean);
    xx += (std::log(x[i]) - x_mean) * (std::log(x[i]) - x_mean);
  }
  return xy / xx;
}

ordered_json curve(const std::string& name, const std::vector<double>& x, const std::vector<double>& y, bool peer) {
  return {{"name", name}, {"x", x}, {"y", y}, {"exponent", exponent(x, y)}, {"peer", peer}};
}

ordered_json plain_curve(const std::string& name, const std::vector<double>& x, const std::vector<double>& y) {
  return {{"name", name}, {"x", x}, {"y", y}, {"exponent", nullptr}, {"peer", false}};
}

ordered_json theory_curve(const std::string& name, const std::vector<double>& x, const std::vector<double>& y) {
  ordered_json theory = plain_curve(name, x, y);
  theory["theory"] = true;
  return theory;
}

ordered_json& add_figure(ordered_json& part, const std::string& kind, const std::string& id, const std::string& title,
                         const std::string& caption, const std::string& runs) {
  part["figures"].push_back({{"kind", kind}, {"id", id}, {"title", title}, {"caption", caption}, {"runs", runs}});
  return part["figures"].back();
}

int run_part(int argc, char** argv, const std::string& name, const std::string& title, const std::string& text,
             const std::vector<Section>& sections) try {
  const bool quick = argc == 3 && std::string_view(argv[1]) == "--quick";
  if (argc != (quick ? 3 : 2) || std::string_view(argv[argc - 1]).starts_with("-")) {
    std::cerr << "usage: " << argv[0] << " [--quick] FILE\n";
    return 2;
  }
  ordered_json part{{"part", name}, {"title", title}, {"text", text}, {"measured", measured(quick)}};
  part["figures"] = ordered_json::array();
  for (const Section section : sections) section(part, quick);
  write_file(argv[argc - 1], part.dump(1) + "\n");
  return 0;
} catch (const std::exception& error) {
  std::cerr << name << ": " << error.what() << '\n';
  return 1;
}

}  // namespace thenar
