#include "bench/report/figure.h"

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string_view>
#include <thread>

#include "engine/files.h"
#include "engine/summary.h"

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

}  // namespace

void to_json(ordered_json& json, const WorkPoint& point) {
  json = {{"method", point.method}, {"setting", point.setting},    {"error", point.error},
          {"us", point.us},         {"us_p99", point.us_p99},      {"default", point.is_default},
          {"peer", point.peer},     {"published", point.published}};
}

PartArguments part_arguments(int argc, char** argv) {
  PartArguments arguments;
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]) == "--quick") {
      arguments.quick = true;
    } else {
      arguments.file = argv[i];
    }
  }
  if (arguments.file.empty() || arguments.file.string().starts_with("-")) {
    std::cerr << "usage: " << argv[0] << " [--quick] FILE\n";
    std::exit(2);
  }
  return arguments;
}

ordered_json make_part(const std::string& name, const std::string& title, const std::string& text,
                       const PartArguments& arguments) {
  ordered_json measured = build_settings();
  measured["machine"] = processor();
  measured["threads"] = std::thread::hardware_concurrency();
  measured["quick"] = arguments.quick;
  return {{"part", name}, {"title", title}, {"text", text}, {"measured", measured}, {"figures", ordered_json::array()}};
}

ordered_json& add_figure(ordered_json& part, const std::string& kind, const std::string& id, const std::string& title,
                         const std::string& caption, const std::string& runs) {
  part["figures"].push_back({{"kind", kind}, {"id", id}, {"title", title}, {"caption", caption}, {"runs", runs}});
  return part["figures"].back();
}

void write_part(const ordered_json& part, const PartArguments& arguments) {
  write_file(arguments.file, part.dump(1) + "\n");
}

}  // namespace thenar
