#include "sim/run/method.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "sim/motion/printable.h"
#include "sim/world/world.h"

namespace taut {

std::string refusal(const MethodInfo& method, const World& world) {
  const auto found = find_refusal(method.abilities, world);
  return found ? words(world, *found) : "";
}

bool follows(const MethodInfo& method, const World& world) {
  return !find_refusal(method.abilities, world);
}

std::string methods_that_follow(const World& world) {
  std::string names;
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty() || !follows(method, world)) continue;
    names += (names.empty() ? "" : ", ") + std::string(method.name);
  }
  return names;
}

void require(std::string_view method, const World& world) {
  const MethodInfo* info = find_method(method);
  const auto found = info ? find_refusal(info->abilities, world) : std::nullopt;
  if (!found) return;
  throw Diverged(std::string(method), world.time, words(world, *found));
}

const MethodInfo* find_method(std::string_view name) {
  const auto list = all_methods();
  const auto found = std::ranges::find(list, name, &MethodInfo::name);
  return found == list.end() ? nullptr : &*found;
}

const MethodInfo* find_method(PaperRole role) {
  const auto found = std::ranges::find(all_methods(), role, &MethodInfo::paper_role);
  return found == all_methods().end() ? nullptr : &*found;
}

const SettingInfo* find_setting(const MethodInfo& method, std::string_view name) {
  const auto found = std::ranges::find(method.settings, name, &SettingInfo::name);
  return found == method.settings.end() ? nullptr : &*found;
}

namespace {

std::string join(const auto& words) {
  std::string line;
  for (const auto& word : words) line += (line.empty() ? "" : ", ") + std::string(word);
  return line;
}

std::string number_complaint(const SettingInfo& info, double value) {
  const bool low = info.above ? !(value > info.minimum) : !(value >= info.minimum);
  std::ostringstream line;
  if (!std::isfinite(value)) {
    line << "is " << value << ", expected a finite number";
  } else if (low) {
    line << "is " << value << ", expected " << (info.above ? "more than " : "at least ")
         << info.minimum;
  } else if (value > info.maximum) {
    line << "is " << value << ", expected at most " << info.maximum;
  } else if (info.whole && value != std::floor(value)) {
    line << "is " << value << ", expected a whole number";
  }
  return line.str();
}

std::string setting_complaint(const SettingInfo& info, const Setting& value) {
  static constexpr std::string_view kinds[] = {"a number", "true or false", "a string"};
  if (value.index() != info.fallback.index()) {
    return "is " + std::string(kinds[value.index()]) + ", expected " +
           std::string(kinds[info.fallback.index()]);
  }
  if (const double* n = std::get_if<double>(&value)) return number_complaint(info, *n);
  if (const std::string* choice = std::get_if<std::string>(&value)) {
    if (std::ranges::find(info.choices, *choice) == info.choices.end()) {
      return "is \"" + *choice + "\", expected one of: " + join(info.choices);
    }
  }
  return {};
}

}  // namespace

std::string method_complaint(std::string_view name) {
  const MethodInfo* info = find_method(name);
  if (!info) {
    std::vector<std::string_view> known;
    for (const MethodInfo& method : all_methods()) known.push_back(method.name);
    return "there is no method \"" + std::string(name) + "\", expected one of: " + join(known);
  }
  if (info->missing.empty()) return {};
  return "the method " + std::string(name) + " is not in this build (" +
         std::string(info->missing) + ")";
}

std::string complaint(const MethodInfo& method, const Settings& settings) {
  for (const auto& [name, value] : settings) {
    const SettingInfo* info = find_setting(method, name);
    if (!info) {
      std::vector<std::string_view> known;
      for (const SettingInfo& setting : method.settings) known.push_back(setting.name);
      return "method " + std::string(method.name) + " has no setting " + name +
             ", expected one of: " + join(known);
    }
    const std::string wrong = setting_complaint(*info, value);
    if (!wrong.empty()) return "setting " + name + " " + wrong;
  }
  return {};
}

Settings with_defaults(const MethodInfo& method, Settings settings) {
  for (const SettingInfo& setting : method.settings) {
    settings.try_emplace(std::string(setting.name), setting.fallback);
  }
  return settings;
}

Settings with_defaults(const MethodInfo& method, Settings settings, const World& world) {
  settings = with_defaults(method, std::move(settings));
  return method.fit ? method.fit(world, std::move(settings)) : settings;
}

std::unique_ptr<Method> make_method(std::string_view name, const Settings& settings) {
  std::string wrong = method_complaint(name);
  if (!wrong.empty()) throw std::invalid_argument(wrong);
  const MethodInfo* info = find_method(name);
  wrong = complaint(*info, settings);
  if (!wrong.empty()) throw std::invalid_argument(wrong);
  auto method = info->make(with_defaults(*info, settings));
  method->called = name;
  method->step = step_of(with_defaults(*info, settings));
  method->again = [info, full = with_defaults(*info, settings)] {
    auto another = info->make(full);
    another->called = info->name;
    return another;
  };
  return method;
}

double number(const Settings& settings, std::string_view name) {
  return std::get<double>(settings.find(name)->second);
}

bool flag(const Settings& settings, std::string_view name) {
  return std::get<bool>(settings.find(name)->second);
}

const std::string& text(const Settings& settings, std::string_view name) {
  return std::get<std::string>(settings.find(name)->second);
}

double step_of(const Settings& settings) {
  const auto step = settings.find("step");
  const double* value = step == settings.end() ? nullptr : std::get_if<double>(&step->second);
  return value ? *value : 0;
}

SettingInfo step_setting(std::string_view open, int sweep) {
  SettingInfo info{
      .name = "step",
      .meaning =
          open.empty() ? "Length of a time step. Raising it costs less and errs more." : open,
      .unit = "s",
      .fallback = open.empty() ? 0.001 : 0.0,
      .maximum = 1,
      .above = open.empty(),
  };
  for (int i = 0; i < sweep; ++i) info.sweep.emplace_back(std::ldexp(1.0 / 60, -i));
  return info;
}

bool has_laden_materials(const World& world) {
  return std::ranges::any_of(world.connectors, [&](const Connector& connector) {
    const auto carried = [&](const Hold& hold) { return !is_prescribed(world, hold.to); };
    return !connector.sections.empty() && std::ranges::any_of(connector.holds, carried);
  });
}

bool has_hinges(const World& world) {
  return std::ranges::any_of(world.connectors, [&](const Connector& connector) {
    const auto carried = [&](const Hold& hold) { return !is_prescribed(world, hold.to); };
    return connector.length == 0 && connector.model == ConnectorModel::links &&
           std::ranges::any_of(connector.holds, carried);
  });
}

std::string_view kind_name(Event::Kind kind) {
  constexpr std::string_view kNames[] = {"taut",  "impulse", "slack", "hit",
                                         "leave", "slide",   "stick", "break"};
  return kNames[static_cast<std::size_t>(kind)];
}

Event in_world(Event event, std::span<const std::size_t> connectors,
               std::span<const std::size_t> bodies) {
  if (!event.of_contact) {
    event.connector = connectors[event.connector];
    return event;
  }
  for (Forces::Side* side : {&event.one, &event.other}) {
    using Kind = Forces::Side::Kind;
    if (side->kind == Kind::obstacle) continue;
    side->index = side->kind == Kind::body ? bodies[side->index] : connectors[side->index];
  }
  return event;
}

Counters& Counters::operator+=(const Counters& other) {
  steps += other.steps;
  solves += other.solves;
  rejected += other.rejected;
  handed_over += other.handed_over;
  cycles += other.cycles;
  return *this;
}

Counters& Counters::operator-=(const Counters& other) {
  steps -= other.steps;
  solves -= other.solves;
  rejected -= other.rejected;
  handed_over -= other.handed_over;
  cycles -= other.cycles;
  return *this;
}

Diverged::Diverged(std::string method_name, double at, std::uint64_t step_number,
                   std::string connector_name, std::size_t link_index, std::string what)
    : std::runtime_error([&] {
        std::ostringstream line;
        line << method_name << ": " << what << " at " << at << " s (step " << step_number
             << "), connector " << connector_name << ", link " << link_index;
        return printable(line.str());
      }()),
      method(std::move(method_name)),
      reason(std::move(what)),
      time(at),
      step(step_number),
      connector(std::move(connector_name)),
      link(link_index) {}

Diverged::Diverged(std::string method_name, double at, std::uint64_t step_number, const Body& body,
                   const std::string& what)
    : std::runtime_error([&] {
        std::ostringstream line;
        line << method_name << ": " << what << " at " << at << " s (step " << step_number
             << "), body " << body.name;
        return line.str();
      }()),
      method(std::move(method_name)),
      reason(what),
      time(at),
      step(step_number),
      connector(body.name),
      link(0) {}

Diverged::Diverged(std::string method_name, double at, std::string refusal)
    : std::runtime_error(printable(method_name + ": " + refusal)),
      method(std::move(method_name)),
      reason(std::move(refusal)),
      time(at),
      step(0),
      link(0) {}

namespace {

// A frame time is a rounded quotient and a step a rounded decimal: their ratio misses a whole
// number by a few units in the last place. A thousandth of a millionth of a step is neither.
constexpr double kWhole = 1e-9;

/// The whole number that `ratio` is but for rounding, or -1.
double whole(double ratio) {
  const double nearest = std::round(ratio);
  return std::abs(ratio - nearest) <= kWhole * std::max(1.0, nearest * 1e-3) ? nearest : -1;
}

std::string too_many_steps(double step, double duration) {
  std::ostringstream line;
  line << "step is " << step << ", expected at least " << duration / kMostRunSteps << ": "
       << duration << " s would take more than " << kMostRunSteps << " steps";
  return line.str();
}

}  // namespace

std::string step_complaint(const Settings& settings, double duration) {
  const double step = step_of(settings);
  return step > 0 && duration / step > kMostRunSteps ? too_many_steps(step, duration) : "";
}

std::uint64_t step_count(double interval, double step) {
  if (!(interval > 0)) return 0;
  const double ratio = interval / step;
  if (!(ratio <= kMostRunSteps)) throw std::invalid_argument(too_many_steps(step, interval));
  const double exact = whole(ratio);
  return static_cast<std::uint64_t>(std::max(1.0, exact >= 0 ? exact : std::ceil(ratio)));
}

StepTimes::StepTimes(double from, double until, double step)
    : count(step_count(until - from, step)), from_(from), until_(until) {
  const double first = whole(from / step), last = whole(until / step);
  on_grid_ = first >= 0 && last > first;
  if (on_grid_) {
    first_ = first;
    dt = step;
    count = static_cast<std::uint64_t>(last - first);
  } else {
    dt = count > 0 ? (until - from) / static_cast<double>(count) : 0;
  }
}

double StepTimes::at(std::uint64_t i) const {
  if (on_grid_) return (first_ + static_cast<double>(i)) * dt;
  return i == count ? until_ : from_ + static_cast<double>(i) * dt;
}

namespace {

constexpr int kDescribed = 6;  // digits

/// Exact numbers have an exponent below 1e-4 and from 1e16 on.
std::string number_text(double value, int digits) {
  const double size = std::abs(value);
  const bool plain = !std::isfinite(value) || size == 0 || (size >= 1e-4 && size < 1e16);
  char text[32];
  char* const end = text + sizeof text;
  const auto last = digits > 0 ? std::to_chars(text, end, value, std::chars_format::general, digits)
                    : plain    ? std::to_chars(text, end, value, std::chars_format::fixed)
                               : std::to_chars(text, end, value, std::chars_format::scientific);
  return {text, last.ptr};
}

}  // namespace

Settings with_defaults(const MethodChoice& choice) {
  return with_defaults(*find_method(choice.name), choice.settings);
}

std::string setting_text(const Setting& value, int digits) {
  if (const double* number = std::get_if<double>(&value)) return number_text(*number, digits);
  if (const bool* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  return std::get<std::string>(value);
}

std::string describe(const Settings& settings) {
  std::string line;
  for (const auto& [name, value] : settings) {
    line += (line.empty() ? "" : ", ") + name + " " + setting_text(value, kDescribed);
  }
  return line.empty() ? "defaults" : line;
}

std::string describe(const MethodChoice& choice) {
  return choice.name + " (" + describe(choice.settings) + ")";
}

}  // namespace taut
