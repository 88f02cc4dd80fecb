#include <charconv>

#include "scenes/reader/reader.h"

namespace taut {

Plan read_plan(const Document& document, const Value& table, int fps) {
  Plan plan;
  plan.tolerance = table.find("tolerance")->text;
  plan.error = table.find("error")->number;
  plan.until = table.find("until")->number;
  if (const Value* energy = table.find("energy")) plan.energy = energy->number;
  const Value& stamp = *table.find("stamp");
  const char* const end = stamp.text.data() + stamp.text.size();
  const auto [last, error] = std::from_chars(stamp.text.data(), end, plan.stamp, 16);
  if (error != std::errc() || last != end || stamp.text.size() != 16) {
    document.mismatch(stamp, "16 hexadecimal digits");
  }
  plan.method = read_method(document, table.find("method"), fps);
  const Value* connectors = document.root.find("connectors");
  if (const Value* changed = table.find("connectors")) {
    for (const Value& connector : changed->children) {
      if (!connectors || !connectors->find(connector.name)) {
        document.fail_at_key(connector, "is no connector of the scene");
      }
      plan.particles[connector.name] =
          static_cast<std::size_t>(number_or(connector, "particles", 0));
    }
  }
  return plan;
}

}  // namespace taut
