#include "sim/evaluation/candidate.h"

#include <sstream>

namespace taut::study {
namespace {

struct Text {
  std::string operator()(double value) const {
    std::ostringstream out;
    out.exceptions(std::ios::badbit);  // or running out of memory would end the text
    out << value;
    return out.str();
  }
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(const std::string& value) const { return value; }
};

std::vector<Setting> values_of(const SettingInfo& setting, bool thin) {
  const std::vector<Setting>& all = setting.sweep;
  if (!thin || all.size() <= 3 || !std::holds_alternative<double>(all.front())) return all;
  return {all.front(), all[all.size() / 2], all.back()};
}

}  // namespace

std::string describe(const Settings& settings) {
  std::string line;
  for (const auto& [name, value] : settings) {
    line += (line.empty() ? "" : ", ") + name + " " + std::visit(Text(), value);
  }
  return line.empty() ? "defaults" : line;
}

std::string describe(const Candidate& candidate) {
  return candidate.method + " (" + describe(candidate.settings) + ")";
}

std::vector<Candidate> sweep(const MethodInfo& method, bool thin) {
  std::vector<Candidate> candidates{{std::string(method.name), {}}};
  for (const SettingInfo& setting : method.settings) {
    if (setting.sweep.empty()) continue;
    std::vector<Candidate> wider;
    for (const Candidate& candidate : candidates) {
      for (const Setting& value : values_of(setting, thin)) {
        wider.push_back(candidate);
        wider.back().settings[std::string(setting.name)] = value;
      }
    }
    candidates = std::move(wider);
  }
  return candidates;
}

}  // namespace taut::study
