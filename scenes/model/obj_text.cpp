#include "scenes/model/obj_text.h"

#include <algorithm>

namespace taut::scenes {

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view blanks = " \t\r\v\f";
  for (std::size_t at = line.find_first_not_of(blanks); at != line.npos;) {
    const std::size_t end = std::min(line.find_first_of(blanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(blanks, end);
  }
  return words;
}

std::string_view words_from(const std::vector<std::string_view>& words, std::size_t first) {
  const char* end = words.back().data() + words.back().size();
  return {words[first].data(), static_cast<std::size_t>(end - words[first].data())};
}

ObjLines::ObjLines(std::string_view text) : text_(text) {
  if (text_.starts_with(kByteOrderMark)) text_.remove_prefix(kByteOrderMark.size());
}

bool ObjLines::next(std::string& line) {
  if (text_.empty()) return false;
  first_ = next_;
  line.clear();
  for (bool goes_on = true; goes_on && !text_.empty();) {
    const std::size_t end = std::min(text_.find('\n'), text_.size());
    std::string_view part = text_.substr(0, end);
    text_.remove_prefix(std::min(end + 1, text_.size()));
    ++next_;
    if (part.ends_with('\r')) part.remove_suffix(1);
    line += part;
    goes_on = line.ends_with('\\') && !line.starts_with('#');
    if (goes_on) line.back() = ' ';
  }
  return true;
}

}  // namespace taut::scenes
