#include <fmt/format.h>

#include <cmath>

#include "scenes/reader/reader.h"

namespace taut {

MethodChoice default_method() {
  return {"direct", {}};
}

std::optional<double> dividing_step(double step, int fps) {
  // A step is the longest allowed. The next shorter one that divides the frame stands for it where
  // the two are within 2%, as 1/1020 s does for 0.001 s at 60 frames per second.
  const double fitted = 1 / (fps * std::ceil(1 / (fps * step) - 1e-6));
  if (std::abs(fitted - step) > 0.02 * step) return {};
  return fitted;
}

std::string dividing_text(double step, int fps) {
  const double count = std::ceil(1 / (fps * step));
  return fmt::format("a step that divides the frame of 1/{} s, such as {:.12g} (1/{} s)", fps,
                     1 / (fps * count), fps * count);
}

MethodChoice read_method(const Document& document, const Value* table, int fps) {
  if (!table) return default_method();
  const Value& name = *table->find("name");
  const MethodInfo& method = *find_method(name.text);
  if (!method.missing.empty()) {
    document.mismatch(name, fmt::format("a method that this build has ({})", method.missing));
  }
  MethodChoice choice{name.text, {}};
  for (const Value& member : table->children) {
    if (&member == &name) continue;
    if (member.kind == Value::Kind::flag) {
      choice.settings[member.name] = member.flag;
    } else if (member.kind == Value::Kind::text) {
      choice.settings[member.name] = member.text;
    } else {
      choice.settings[member.name] = member.number;
    }
  }
  if (const Value* step = table->find("step")) {
    const auto exact = dividing_step(step->number, fps);
    if (!exact) document.mismatch(*step, dividing_text(step->number, fps));
    choice.settings["step"] = *exact;
  }
  return choice;
}

}  // namespace taut
