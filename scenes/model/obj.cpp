#include "scenes/model/obj.h"

#include <fmt/format.h>

#include <algorithm>
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
#include "scenes/model/obj_materials.h"
#include "scenes/model/obj_text.h"

namespace taut::scenes {
namespace {

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

}  // namespace taut::scenes
