#include "scenes/plan.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "scenes/reader/reader.h"
#include "sim/hash.h"

namespace taut {
namespace {

constexpr std::string_view kHeading = "[plan]";
constexpr std::string_view kRemark = "  # what taut plan found; --planned takes it";

/// Where the lines of the plan begin and end; both at the end of the text where there is none.
std::pair<std::size_t, std::size_t> plan_lines(std::string_view text) {
  for (std::size_t line = 0; line < text.size();) {
    const std::size_t next = std::min(text.find('\n', line), text.size() - 1) + 1;
    if (text.substr(line).starts_with(kHeading)) {
      std::size_t end = next;
      while (end < text.size() && text[end] != '[') {
        end = std::min(text.find('\n', end), text.size() - 1) + 1;
      }
      return {line, end};
    }
    line = next;
  }
  return {text.size(), text.size()};
}

/// The text without the plan, and without space at its end.
std::string without_plan(std::string_view text) {
  const auto [begin, end] = plan_lines(text);
  std::string rest(text.substr(0, begin));
  rest += text.substr(end);
  rest.erase(rest.find_last_not_of(" \n") + 1);
  return rest;
}

std::string contents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// With two digits, never nearer than it is: rounded `up`, or down.
std::string two_digits(double value, bool up) {
  if (!(value > 0) || !std::isfinite(value)) return fmt::format("{:g}", value);
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  constexpr double kRounding = 1e-9;
  const double units = value / unit;
  return fmt::format("{:.2g}",
                     unit * (up ? std::ceil(units - kRounding) : std::floor(units + kRounding)));
}

std::string toml(const Setting& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return '"' + *text + '"';
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  return fmt::format("{}", std::get<double>(value));
}

}  // namespace

std::uint64_t plan_stamp(const std::filesystem::path& scene) {
  const Document document = read_document(scene);
  Hash hash;
  hash.text(without_plan(contents(scene)));
  if (!document.base.empty()) hash.text(without_plan(contents(document.base)));
  if (const Value* paths = document.root.find("paths")) {
    for (const Value& path : paths->children) {
      if (const Value* file = path.find("file")) hash.text(contents(find_file(document, *file)));
    }
  }
  return hash.value();
}

std::string with_plan(std::string_view text, const Plan& plan) {
  std::string method = fmt::format("name = \"{}\"", plan.method.name);
  for (const auto& [name, value] : plan.method.settings) {
    method += fmt::format(", {} = {}", name, toml(value));
  }
  std::string connectors;
  for (const auto& [name, particles] : plan.particles) {
    const std::string model =
        particles > 0 ? fmt::format("particles = {}", particles) : "model = \"span\"";
    connectors += fmt::format("{}{} = {{ {} }}", connectors.empty() ? "" : ", ", name, model);
  }
  std::string table = fmt::format("{}{}\ntolerance = \"{}\"\nerror = {:.3g}\nuntil = {:.6g}  # s\n",
                                  kHeading, kRemark, plan.tolerance, plan.error, plan.until);
  if (plan.energy) table += fmt::format("energy = {:.3g}\n", *plan.energy);
  table += fmt::format("stamp = \"{:016x}\"\nmethod = {{ {} }}\n", plan.stamp, method);
  if (!connectors.empty()) table += fmt::format("connectors = {{ {} }}\n", connectors);
  return without_plan(text) + "\n\n" + table;
}

std::string certificate(const Plan& plan) {
  const std::size_t unit = plan.tolerance.find_first_not_of("0123456789.e-+");
  std::string text;
  if (plan.until > 0) {
    text = fmt::format("within {} {} of the exact motion until {} s", two_digits(plan.error, true),
                       plan.tolerance.substr(std::min(unit, plan.tolerance.size())),
                       two_digits(plan.until, false));
  } else {
    text = "of a motion that nobody can foretell";
  }
  if (plan.energy) {
    text += fmt::format("; {}energy within {}%", plan.until > 0 ? "afterwards " : "",
                        two_digits(100 * *plan.energy, true));
  }
  return text;
}

}  // namespace taut
