// The methods there are, in the order in which they are listed.
#include <algorithm>

#include "sim/methods/direct/direct.h"
#include "sim/methods/methods.h"
#include "sim/run/method.h"

namespace taut::methods {
namespace {

std::vector<MethodInfo>& list_of_methods() {
  static std::vector<MethodInfo> list = {
      impulse_method(), dynamic_constraints_method(), springs_method(),
      xpbd_method(),    direct::direct_method(),
  };
  return list;
}

}  // namespace
}  // namespace taut::methods

std::span<const taut::MethodInfo> taut::all_methods() {
  return methods::list_of_methods();
}

void taut::add_method(MethodInfo method, std::string_view before) {
  auto& list = methods::list_of_methods();
  list.insert(std::ranges::find(list, before, &MethodInfo::name), std::move(method));
}
