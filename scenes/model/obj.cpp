// OBJ files and their libraries of materials, proved sound before the importer reads them.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/files/files.h"
#include "scenes/model/formats.h"
#include "scenes/model/model.h"

namespace taut::scenes {
namespace {

// Lines and words of OBJ files and their libraries of materials.

inline constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

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

/// The words of a line, between blanks.
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

/// What the words of a line, from the `first` on, and the blanks between them are.
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

constexpr std::size_t corner_limit = 256;  // of one face
constexpr std::size_t kUnknown = 16;       // words that start statements: more are no OBJ file

template <typename Number>
std::optional<Number> parse(std::string_view word) {
  Number value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return {};
  return value;
}

/// Statements that describe no polygons.
const std::map<std::string_view, const char*> kLeftOut = {{"p", "points"},
                                                          {"l", "lines"},
                                                          {"vp", "curves"},
                                                          {"cstype", "curves"},
                                                          {"deg", "curves"},
                                                          {"bmat", "curves"},
                                                          {"step", "curves"},
                                                          {"curv", "curves"},
                                                          {"curv2", "curves"},
                                                          {"surf", "surfaces"},
                                                          {"parm", "curves"},
                                                          {"trim", "curves"},
                                                          {"hole", "curves"},
                                                          {"scrv", "curves"},
                                                          {"sp", "curves"},
                                                          {"end", "curves"},
                                                          {"con", "curves"},
                                                          {"mg", "groups for merging"},
                                                          {"bevel", "rendering"},
                                                          {"c_interp", "rendering"},
                                                          {"d_interp", "rendering"},
                                                          {"lod", "rendering"},
                                                          {"shadow_obj", "rendering"},
                                                          {"trace_obj", "rendering"},
                                                          {"ctech", "curves"},
                                                          {"stech", "surfaces"},
                                                          {"maplib", "textures"},
                                                          {"usemap", "textures"},
                                                          {"call", "other files"},
                                                          {"csh", "commands"}};

class ObjCheck {
 public:
  ObjCheck(const std::filesystem::path& file, NamedFiles& files) : file_(file), files_(files) {}

  CheckedObj run(const std::string& content) {
    ObjLines lines(content);
    for (std::string line; lines.next(line);) {
      line_ = lines.number();
      if (line.find('\0') != line.npos) fail("not a text file");
      const auto words = words_of(line);
      if (!words.empty() && words[0][0] != '#') statement(words);
    }
    if (faces_ == 0 && !unknown_.empty()) fail_unknown(*unknown_.begin());
    if (faces_ == 0) throw bad_asset(file_, "has no faces");
    for (const auto& [word, found] : left_out_) say_left_out(kLeftOut.at(word), word, found);
    for (const auto& [word, found] : unknown_) say_left_out("unknown", word, found);
    if (lone_corners_.count > 0)
      say_left_out("faces of fewer than three corners", "f", lone_corners_);
    std::ranges::copy(materials_.left_out(), std::back_inserter(out_.left_out));
    out_.materials = materials_.text();
    out_.textures = materials_.take();
    return std::move(out_);
  }

 private:
  struct Found {
    std::size_t count = 0, line = 0;
  };

  [[noreturn]] void fail(const std::string& cause) const {
    throw bad_asset(file_, fmt::format("line {}: {}", line_, cause));
  }

  void say_left_out(std::string_view what, std::string_view word, const Found& found) {
    out_.left_out.push_back(fmt::format("{} ({} statement{} \"{}\", first in line {})", what,
                                        found.count, found.count == 1 ? "" : "s", word,
                                        found.line));
  }

  [[noreturn]] void fail_unknown(const std::pair<const std::string, Found>& unknown) {
    line_ = unknown.second.line;
    fail(fmt::format("unknown statement \"{}\"", unknown.first));
  }

  void note(Found& found) const {
    if (found.count++ == 0) found.line = line_;
  }

  void statement(const std::vector<std::string_view>& words) {
    static const std::set<std::string_view> harmless = {"o", "g", "s", "usemtl"};
    if (const auto other = kLeftOut.find(words[0]); other != kLeftOut.end()) {
      return note(left_out_[other->first]);
    }
    if (words[0] == "mtllib") return library(words);
    if (words[0] == "v") {
      numbers(words, 3, 7), ++points_;
    } else if (words[0] == "vt") {
      numbers(words, 1, 3), ++textures_;
    } else if (words[0] == "vn") {
      numbers(words, 3, 3), ++normals_;
    } else if (words[0] == "f") {
      if (words.size() < 4) return note(lone_corners_);
      face(words);
    } else {
      const auto known = harmless.find(words[0]);
      if (known == harmless.end()) {
        const auto unknown = unknown_.try_emplace(std::string(words[0])).first;
        note(unknown->second);
        if (unknown_.size() > kUnknown) fail_unknown(*unknown);
        return;
      }
      if (*known != "s") count(*known);
    }
    out_.text.append(words_from(words, 0)) += '\n';
  }

  /// The importer makes a piece of each, and looks for it among all others.
  void count(std::string_view word) {
    if (++seen_[word] > model_limits::meshes) {
      fail(fmt::format("more than {} statements \"{}\"", model_limits::meshes, word));
    }
  }

  /// A library of materials: what follows the word, which may have blanks in it; or several.
  void library(const std::vector<std::string_view>& words) {
    count("mtllib");
    if (words.size() == 1) return;
    const std::string_view whole = words_from(words, 1);
    if (words.size() == 2 || !files_.is_missing(name_of_library(whole))) {
      add_library(whole);
    } else {
      for (std::size_t i = 1; i < words.size(); ++i) add_library(words[i]);
    }
  }

  std::string name_of_library(std::string_view written) const {
    auto name = name_of_path(written);
    if (!name) {
      fail(fmt::format("mtllib {}: expected the name of a file, relative to the model's folder",
                       in_quotes(written)));
    }
    return std::move(*name);
  }

  void add_library(std::string_view written) {
    const std::string name = name_of_library(written);
    const std::string where = fmt::format("line {}: mtllib {}", line_, in_quotes(written));
    if (files_.is_missing(name)) {
      out_.left_out.push_back(fmt::format("materials ({}: there is no such file)", where));
    } else if (const std::string* bytes = files_.find({where, name, "a library of materials"})) {
      materials_.add(name, *bytes);
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
  NamedFiles& files_;
  CheckedObj out_;
  ObjMaterials materials_{file_, files_};
  std::size_t line_ = 1, faces_ = 0;
  std::map<std::string_view, Found> left_out_;
  std::map<std::string, Found> unknown_;  // by the word that starts it
  Found lone_corners_;
  std::map<std::string_view, std::size_t> seen_;  // statements of each kind
  std::int64_t points_ = 0, textures_ = 0, normals_ = 0;
};

}  // namespace

std::optional<CheckedObj> checked_obj(const std::filesystem::path& file, const std::string& content,
                                      NamedFiles& files) {
  CheckedObj checked = ObjCheck(file, files).run(content);
  if (!files.wanted().empty()) return {};
  return checked;
}

namespace {

/// How many words follow an option of a picture at most; numbers may be fewer.
const std::map<std::string_view, std::size_t> kOptions = {
    {"-blendu", 1}, {"-blendv", 1},  {"-bm", 1},  {"-boost", 1}, {"-cc", 1},
    {"-clamp", 1},  {"-imfchan", 1}, {"-mm", 2},  {"-o", 3},     {"-s", 3},
    {"-t", 3},      {"-texres", 1},  {"-type", 1}};

bool is_number(std::string_view word) {
  return word.find_first_not_of("0123456789+-.eE") == word.npos;
}

/// The first word that belongs to no option.
std::size_t after_options(const std::vector<std::string_view>& words, std::size_t at) {
  while (at < words.size()) {
    const auto option = kOptions.find(words[at]);
    if (option == kOptions.end()) break;
    const std::size_t end = at + 1 + option->second;
    ++at;
    const bool numbers = option->second > 1;
    while (at < std::min(end, words.size()) && (!numbers || is_number(words[at]))) ++at;
  }
  return at;
}

}  // namespace

std::optional<std::string> name_of_path(std::string_view written) {
  std::string name(written);
  std::ranges::replace(name, '\\', '/');
  const bool drive = name.size() > 1 && name[1] == ':';
  if (name.empty() || name[0] == '/' || drive || name.find('\0') != name.npos) return {};
  return name;
}

void ObjMaterials::add(const std::string& library, std::string_view text) {
  static const std::set<std::string_view> others = {
      "map_Ka",   "map_Ks", "map_Ke", "map_Ns", "map_d", "map_Pr", "map_Pm", "map_Ps", "map_Bump",
      "map_bump", "bump",   "disp",   "decal",  "refl",  "norm",   "map_Kn", "map_Tr", "map_refl"};
  std::string material;
  bool named = false;
  std::map<std::string_view, std::size_t> left;
  ObjLines lines(text);
  for (std::string line; lines.next(line);) {
    if (line.find('\0') != line.npos) {
      throw bad_asset(file_, fmt::format("{}: not a text file", in_quotes(library)));
    }
    const auto words = words_of(line);
    if (words.size() < 2) continue;
    const std::string where = fmt::format("{}: line {}: {}", library, lines.number(), words[0]);
    if (words[0] == "newmtl") {
      if (++materials_ > model_limits::meshes) {
        throw bad_asset(file_, fmt::format("{}: more than {}", where, model_limits::meshes));
      }
      material = words_from(words, 1);
      named = true;
      text_ += fmt::format("newmtl {}\n", material);
    }
    if (!named) continue;
    if (words[0] == "Kd" || words[0] == "Pr" || words[0] == "Pm") add_numbers(words, where);
    if (words[0] == "map_Kd") add_picture(library, words, material, where);
    if (const auto other = others.find(words[0]); other != others.end()) ++left[*other];
    if (words[0] == "d" && words[1] != "1" && !words[1].starts_with("1.")) ++left["d"];
  }
  for (const auto& [word, count] : left) {
    left_out_.push_back(fmt::format("{} ({}, {} of them)", word, library, count));
  }
}

void ObjMaterials::add_numbers(const std::vector<std::string_view>& words,
                               const std::string& where) {
  if (words[1] == "spectral" || words[1] == "xyz") {
    left_out_.push_back(fmt::format("a colour that is not red, green and blue ({})", where));
    return;
  }
  std::string line(words[0]);
  const std::size_t count = words[0] == "Kd" ? 3 : 1;
  for (std::size_t i = 1; i <= count; ++i) {
    const std::string_view word = words[i < words.size() ? i : 1];  // one number is a grey
    float value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() ||
        !(value >= 0 && value <= 1e3f)) {
      throw bad_asset(file_, fmt::format("{}: \"{}\" is not a number from 0", where, word));
    }
    line += fmt::format(" {}", value);
  }
  text_ += line + '\n';
}

void ObjMaterials::add_picture(const std::string& library,
                               const std::vector<std::string_view>& words,
                               const std::string& material, const std::string& where) {
  const std::size_t first = after_options(words, 1);
  if (first > 1) left_out_.push_back(fmt::format("options of pictures ({})", where));
  if (first >= words.size()) return;
  const std::string place = fmt::format("{} {}", where, in_quotes(words_from(words, first)));
  const auto written = name_of_path(words_from(words, first));
  if (!written) {
    throw bad_asset(
        file_, fmt::format("{}: expected the name of a file, relative to the library's", place));
  }
  const std::string name = (std::filesystem::path(library).parent_path() / *written).string();
  const auto known = known_.find(name);
  if (known != known_.end()) {
    if (known->second >= 0) textures_.of_name[material] = known->second;
    return;
  }
  if (files_.is_missing(name)) {
    left_out_.push_back(fmt::format("{}: there is no such file", place));
    return;
  }
  const std::string* bytes = files_.find({place, name, "an image"});
  if (!bytes) return;
  known_[name] = -1;
  if (kind_of_image(*bytes) == ImageKind::other) {
    left_out_.push_back(fmt::format("textures other than PNG and JPEG ({})", place));
    return;
  }
  try {
    Texture made = decode_image(*bytes, model_limits::pixels - pixels_);
    pixels_ += std::size_t{made.width} * made.height;
    textures_.all.push_back(std::move(made));
  } catch (const std::runtime_error& error) {
    throw bad_asset(file_, fmt::format("{}: {}", place, error.what()));
  }
  textures_.of_name[material] = known_[name] = static_cast<int>(textures_.all.size()) - 1;
}

}  // namespace taut::scenes
