#include <charconv>

#include "scenes/format/format_keys.h"
#include "scenes/reader/reader.h"

namespace taut::scenes {
namespace {

std::uint64_t hexadecimal(const Document& document, const Value& value) {
  std::uint64_t number = 0;
  const char* const end = value.text.data() + value.text.size();
  const auto [last, error] = std::from_chars(value.text.data(), end, number, 16);
  if (error != std::errc() || last != end || value.text.size() != 16) {
    document.mismatch(value, "16 hexadecimal digits");
  }
  return number;
}

Plan::Afterwards read_afterwards(const Value& table) {
  using Work = Plan::Afterwards::Work;
  const std::string_view work = table.find("work")->text;
  return {.work = work == "none"    ? Work::none
                  : work == "known" ? Work::known
                                    : Work::unknown,
          .energy = table.find("energy")->number,
          .stretch = table.find("stretch")->number,
          .speeds = table.find("speeds")->number};
}

/// Calls `visit` for each member of the table `name`, all of which must be members of the scene's.
template <class Visit>
void each_of_scene(const Document& document, const Value& plan, std::string_view name,
                   const char* unknown, Visit visit) {
  const Value* all = document.root.find(name);
  const Value* some = plan.find(name);
  if (!some) return;
  for (const Value& one : some->children) {
    if (!all || !all->find(one.name)) document.fail_at_key(one, unknown);
    visit(one);
  }
}

}  // namespace

Plan read_plan(const Document& document, const Value& table, int fps) {
  check_format(document, table, plan_format());
  Plan plan;
  const Value& tolerance = *table.find("tolerance");
  if (!read_length(tolerance.text)) document.mismatch(tolerance, "as in 1px or 0.5mm");
  plan.tolerance = tolerance.text;
  plan.error = table.find("error")->number;
  plan.until = table.find("until")->number;
  plan.end = text_or(table, "end", "");
  if (const Value* later = table.find("afterwards")) plan.afterwards = read_afterwards(*later);
  plan.exposures = static_cast<int>(number_or(table, "exposures", 0));
  plan.stamp = hexadecimal(document, *table.find("stamp"));
  plan.program = hexadecimal(document, *table.find("program"));
  plan.method = read_method(document, table.find("method"), fps, plan.until);
  if (const Value* neglected = table.find("neglected")) {
    for (const Value& name : neglected->children) {
      const auto physics = physics_named(name.text);
      if (!physics) document.mismatch(name, "one of: air, twist, bending, stretch");
      plan.neglected.push_back(*physics);
    }
  }
  each_of_scene(
      document, table, "connectors", "is no connector of the scene", [&](const Value& one) {
        plan.particles[one.name] = static_cast<std::size_t>(number_or(one, "particles", 0));
      });
  each_of_scene(document, table, "bodies", "is no body of the scene",
                [&](const Value& one) { plan.links.push_back(one.name); });
  return plan;
}

}  // namespace taut::scenes
