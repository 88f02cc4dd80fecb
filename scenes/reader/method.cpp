#include <fmt/format.h>

#include <cmath>

#include "scenes/reader/reader.h"

namespace taut::scenes {

MethodChoice read_method(const Document& document, const Value* table, int fps, double duration) {
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
    const std::string wrong = step_complaint(choice.settings, duration);
    if (!wrong.empty()) document.fail(*step, wrong);
    const auto exact = dividing_step(step->number, fps);
    if (!exact) document.mismatch(*step, dividing_text(step->number, fps));
    choice.settings["step"] = *exact;
  }
  return choice;
}

}  // namespace taut::scenes
