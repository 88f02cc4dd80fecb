#include "sim/run/companion.h"

#include <algorithm>

namespace taut {
namespace {

/// Multiplies a number, up to its maximum; how many times as large it is now.
double raise(const MethodInfo& method, Settings& settings, std::string_view name, double times) {
  double& value = std::get<double>(settings.find(name)->second);
  const double before = value;
  value = std::min(times * value, find_setting(method, name)->maximum);
  return value / before;
}

}  // namespace

Companion with_tolerance_raised(const MethodInfo& method, Settings settings,
                                std::string_view tolerance) {
  const double asked =
      find_setting(method, tolerance)->unit == "m" ? number(settings, tolerance) : 0;
  const double ratio = raise(method, settings, tolerance, 4);
  if (ratio < 2) return {.asked = asked, .none = "has no tolerance twice as large"};
  return {.method = method.make(settings), .ratio = ratio, .asked = asked};
}

Companion with_step_doubled(const MethodInfo& method, Settings settings, double order) {
  raise(method, settings, "step", 2);
  return {.method = method.make(settings), .order = order};
}

}  // namespace taut
