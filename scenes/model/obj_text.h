// Lines and words of OBJ files and their libraries of materials.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace taut::scenes {

inline constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

/// The words of a line, between blanks.
std::vector<std::string_view> words_of(std::string_view line);

/// What the words of a line, from the `first` on, and the blanks between them are.
std::string_view words_from(const std::vector<std::string_view>& words, std::size_t first);

/// The lines of a text, without a byte order mark. A line that ends in a backslash goes on with the
/// next one, unless it is a comment.
class ObjLines {
 public:
  explicit ObjLines(std::string_view text);
  /// False at the end of the text.
  bool next(std::string& line);
  /// Of the line that came last, from 1; its first where it has gone on.
  std::size_t number() const { return first_; }

 private:
  std::string_view text_;
  std::size_t first_ = 1, next_ = 1;
};

}  // namespace taut::scenes
