#include "scenes/model/obj.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "scenes/files/regular_file.h"
#include "scenes/model/limits.h"

namespace taut::scenes {
namespace {

constexpr std::size_t corner_limit = 256;  // of one face

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

template <typename Number>
std::optional<Number> parse(std::string_view word) {
  Number value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return {};
  return value;
}

class ObjCheck {
 public:
  explicit ObjCheck(const std::filesystem::path& file) : file_(file) {}

  void run(const std::string& content) {
    for (std::size_t start = 0; start < content.size(); ++line_) {
      const std::size_t end = std::min(content.find('\n', start), content.size());
      const std::string_view text = std::string_view(content).substr(start, end - start);
      start = end + 1;
      if (text.find('\0') != text.npos) fail("not a text file");
      if (text.ends_with('\\')) fail("continued lines are not read");
      const auto words = words_of(text);
      if (!words.empty() && words[0][0] != '#') statement(words);
    }
    if (faces_ == 0) throw bad_asset(file_, "has no faces");
  }

 private:
  [[noreturn]] void fail(const std::string& cause) const {
    throw bad_asset(file_, fmt::format("line {}: {}", line_, cause));
  }

  void statement(const std::vector<std::string_view>& words) {
    static const std::set<std::string_view> harmless = {"o", "g", "s", "usemtl", "mtllib"};
    if (words[0] == "v") return numbers(words, 3, 7), void(++points_);
    if (words[0] == "vt") return numbers(words, 1, 3), void(++textures_);
    if (words[0] == "vn") return numbers(words, 3, 3), void(++normals_);
    if (words[0] == "f") return face(words);
    const auto known = harmless.find(words[0]);
    if (known == harmless.end()) fail(fmt::format("unknown statement \"{}\"", words[0]));
    // The importer makes a piece of each, and looks for it among all others.
    if (++seen_[*known] > model_limits::meshes && *known != "s") {
      fail(fmt::format("more than {} statements \"{}\"", model_limits::meshes, *known));
    }
  }

  void numbers(const std::vector<std::string_view>& words, std::size_t least, std::size_t most) {
    if (words.size() - 1 < least || words.size() - 1 > most)
      fail(fmt::format("{} numbers after {}, expected {} to {}", words.size() - 1, words[0], least,
                       most));
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto value = parse<double>(words[i]);
      if (!value || !std::isfinite(*value) || std::abs(*value) > 1e9)
        fail(fmt::format("\"{}\" is not a number", words[i]));
    }
  }

  void face(const std::vector<std::string_view>& words) {
    if (words.size() < 4 || words.size() > corner_limit)
      fail(fmt::format("a face of {} corners, expected 3 or more", words.size() - 1));
    ++faces_;
    const std::int64_t counts[3] = {points_, textures_, normals_};
    for (std::size_t i = 1; i < words.size(); ++i) {
      std::string_view rest = words[i];
      for (int part = 0; part < 3; ++part) {
        const std::size_t slash = std::min(rest.find('/'), rest.size());
        const std::string_view word = rest.substr(0, slash);
        if (!word.empty() || part == 0) reference(word, counts[part]);
        if (slash == rest.size()) break;
        if (part == 2) fail(fmt::format("\"{}\" is not a corner", words[i]));
        rest.remove_prefix(slash + 1);
      }
    }
  }

  /// Corners count from 1, or backwards from -1.
  void reference(std::string_view word, std::int64_t count) const {
    const auto value = parse<std::int64_t>(word);
    if (!value) fail(fmt::format("\"{}\" is not an index", word));
    if (*value == 0 || *value > count || *value < -count)
      fail(fmt::format("index {}, but there are {} so far", *value, count));
  }

  const std::filesystem::path& file_;
  std::size_t line_ = 1, faces_ = 0;
  std::map<std::string_view, std::size_t> seen_;  // statements of each kind
  std::int64_t points_ = 0, textures_ = 0, normals_ = 0;
};

}  // namespace

void check_obj(const std::filesystem::path& file, const std::string& content) {
  ObjCheck(file).run(content);
}

}  // namespace taut::scenes
