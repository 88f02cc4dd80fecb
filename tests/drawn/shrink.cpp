#include "tests/drawn/shrink.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <vector>

namespace taut::drawn {
namespace {

using Lines = std::vector<std::string>;

Lines lines_of(const std::string& text) {
  Lines lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    if (end > at) lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

std::string text_of(const Lines& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

/// The line after the last of the table that begins there.
std::size_t table_end(const Lines& lines, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < lines.size() && lines[end][0] != '[') ++end;
  return end;
}

/// Of a number in a line, simpler ones: with fewer digits, and half of it.
std::vector<std::string> simpler(const std::string& number) {
  double value = 0;
  std::from_chars(number.data(), number.data() + number.size(), value);
  std::vector<std::string> found;
  const bool whole = number.find_first_of(".e") == number.npos;
  const auto add = [&](const std::string& text) {
    if (text.size() < number.size() || (whole && text != number)) found.push_back(text);
  };
  if (whole) {
    if (value >= 2) add(fmt::format("{}", static_cast<long>(value / 2)));
  } else {
    for (const int digits : {1, 2, 4}) add(fmt::format("{:.{}g}", value, digits));
  }
  return found;
}

class Shrinking {
 public:
  Shrinking(Lines lines, const std::function<bool(const std::string&)>& fails)
      : lines_(std::move(lines)), fails_(fails) {}

  Lines run() {
    for (bool smaller = true; smaller;) {
      smaller = leave_out(true) | leave_out(false);
    }
    while (simplify()) {
    }
    return lines_;
  }

 private:
  bool keep_if_failing(Lines lines) {
    if (!fails_(text_of(lines))) return false;
    lines_ = std::move(lines);
    return true;
  }

  /// From the end on: what stands later may need what stands before.
  bool leave_out(bool tables) {
    bool any = false;
    for (std::size_t i = lines_.size(); i-- > 0;) {
      if (i >= lines_.size() || (tables && lines_[i][0] != '[')) continue;
      Lines rest = lines_;
      const auto begin = rest.begin() + static_cast<std::ptrdiff_t>(i);
      rest.erase(begin, tables ? rest.begin() + static_cast<std::ptrdiff_t>(table_end(rest, i))
                               : begin + 1);
      any |= keep_if_failing(std::move(rest));
    }
    return any;
  }

  bool simplify() {
    bool any = false;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      for (std::size_t at = 0; at < lines_[i].size();) {
        const std::size_t begin = lines_[i].find_first_of("0123456789", at);
        if (begin == std::string::npos) break;
        const std::size_t end =
            std::min(lines_[i].find_first_not_of("0123456789.e-+", begin), lines_[i].size());
        at = end;
        if (begin > 0 && std::isalpha(static_cast<unsigned char>(lines_[i][begin - 1]))) continue;
        for (const std::string& number : simpler(lines_[i].substr(begin, end - begin))) {
          Lines changed = lines_;
          changed[i].replace(begin, end - begin, number);
          if (!keep_if_failing(std::move(changed))) continue;
          at = begin + number.size();
          any = true;
          break;
        }
      }
    }
    return any;
  }

  Lines lines_;
  const std::function<bool(const std::string&)>& fails_;
};

}  // namespace

std::string shrunk(std::string scene, const std::function<bool(const std::string&)>& fails) {
  return text_of(Shrinking(lines_of(scene), fails).run());
}

}  // namespace taut::drawn
