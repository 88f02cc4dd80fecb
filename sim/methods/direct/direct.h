// The direct method: all links of a connector at once, exactly, in linear time.
#pragma once

#include <vector>

#include "sim/run/method.h"

namespace taut::direct {

/// The row of the list of methods.
MethodInfo direct_method();

/// Of each body, whether the method steps it as one more link, which is exact where it hangs by one
/// point and moves in a plane; as far as the world's present state tells.
std::vector<bool> stepped_as_links(const World& world);

}  // namespace taut::direct
