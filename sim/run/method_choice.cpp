#include "sim/run/method_choice.h"

#include <sstream>

namespace taut {
namespace {

struct Text {
  std::string operator()(double value) const {
    std::ostringstream out;
    out.exceptions(std::ios::badbit);  // or running out of memory would end the text
    out << value;
    return out.str();
  }
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(const std::string& value) const { return value; }
};

}  // namespace

Settings with_defaults(const MethodChoice& choice) {
  return with_defaults(*find_method(choice.name), choice.settings);
}

std::string describe(const Settings& settings) {
  std::string line;
  for (const auto& [name, value] : settings) {
    line += (line.empty() ? "" : ", ") + name + " " + std::visit(Text(), value);
  }
  return line.empty() ? "defaults" : line;
}

std::string describe(const MethodChoice& choice) {
  return choice.name + " (" + describe(choice.settings) + ")";
}

}  // namespace taut
