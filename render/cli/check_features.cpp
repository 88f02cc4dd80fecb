#include "render/cli/check_features.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "render/chart/table.h"
#include "sim/run/method.h"

namespace taut::cli {
namespace {

std::vector<std::string> names_of(Features some) {
  std::vector<std::string> names;
  for (std::size_t f = 0; f < kFeatureCount; ++f) {
    const auto feature = static_cast<Feature>(f);
    if (some.has(feature)) names.emplace_back(name(feature));
  }
  return names;
}

std::string within(const Apart& apart) {
  return apart.within == Apart::Within::world ? "a scene" : "one connector";
}

}  // namespace

std::string features_as_markdown() {
  chart::Table follows{{"feature"}, {}};
  for (const MethodInfo& method : all_methods()) {
    follows.columns.push_back(fmt::format("`{}`", method.name));
  }
  for (std::size_t f = 0; f < kFeatureCount; ++f) {
    const auto feature = static_cast<Feature>(f);
    std::vector<std::string>& row = follows.rows.emplace_back();
    row.emplace_back(name(feature));
    for (const MethodInfo& method : all_methods()) {
      row.emplace_back(method.abilities.follows.has(feature) ? "yes" : "");
    }
  }
  chart::Table apart{{"method", "does not follow", "together with", "in"}, {}};
  for (const MethodInfo& method : all_methods()) {
    for (const Apart& entry : method.abilities.apart) {
      const Features both = method.abilities.follows;
      apart.rows.push_back({fmt::format("`{}`", method.name),
                            fmt::format("{}", fmt::join(names_of(entry.one & both), ", ")),
                            fmt::format("{}", fmt::join(names_of(entry.other & both), ", ")),
                            within(entry)});
    }
  }
  return chart::to_markdown(follows) + "\n" + chart::to_markdown(apart);
}

}  // namespace taut::cli
