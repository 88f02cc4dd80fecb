#include "sim/evaluation/sweep.h"

namespace taut::study {
namespace {

std::vector<Setting> values_of(const SettingInfo& setting, bool thin) {
  const std::vector<Setting>& all = setting.sweep;
  if (!thin || all.size() <= 3 || !std::holds_alternative<double>(all.front())) return all;
  return {all.front(), all[all.size() / 2], all.back()};
}

}  // namespace

std::vector<MethodChoice> sweep(const MethodInfo& method, bool thin) {
  std::vector<MethodChoice> candidates{{std::string(method.name), {}}};
  for (const SettingInfo& setting : method.settings) {
    if (setting.sweep.empty()) continue;
    std::vector<MethodChoice> wider;
    for (const MethodChoice& candidate : candidates) {
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
