// Which method a scene asks for.
#pragma once

#include <optional>
#include <string>

#include "sim/run/method_choice.h"

namespace taut::scenes {

/// The method of a scene that names none.
MethodChoice default_method();

/// The longest step that is at most `step` (s) and divides a frame of 1/`fps`; none where that
/// would change it by more than 2%.
std::optional<double> dividing_step(double step, int fps);
/// The step to give instead, as messages say it.
std::string dividing_text(double step, int fps);

}  // namespace taut::scenes
