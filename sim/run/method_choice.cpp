#include "sim/run/method_choice.h"

#include <charconv>
#include <cmath>

namespace taut {
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
