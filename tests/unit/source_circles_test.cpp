// Within a room, too, what is above includes what is below, and never the other way round.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>

#include "tests/support/folder.h"

namespace taut::source_circles_test {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;
using Files = std::map<std::string, std::string>;            // of a room: name, text
using Units = std::map<std::string, std::set<std::string>>;  // name, those that it includes

/// The headers of the room that a text includes.
Names included(const std::string& room, const std::string& text) {
  static const std::regex include("#include \"([^\"]+)/([^\"/]+)\"");
  Names names;
  for (std::sregex_iterator i(text.begin(), text.end(), include), end; i != end; ++i) {
    if ((*i)[1] == room) names.push_back((*i)[2]);
  }
  return names;
}

/// The functions that a source defines for others, each by its class or else by its own name.
Names defined(std::string text) {
  const std::string opened = "\nnamespace {\n", closed = "\n}  // namespace\n";
  for (std::size_t from = 0; (from = text.find(opened)) != std::string::npos;) {
    text.erase(from, text.find(closed, from) - from);
  }
  static const std::regex function("\n(?:[A-Za-z_][^\n(#=]*[ &*])?(?:(\\w+)::)?~?(\\w+)\\(");
  Names names;
  for (std::sregex_iterator i(text.begin(), text.end(), function), end; i != end; ++i) {
    names.push_back((*i)[1].matched ? (*i)[1] : (*i)[2]);
  }
  return names;
}

bool declares(const std::string& header, const std::string& name) {
  return std::regex_search(header, std::regex("\\b" + name + "\\(|(class|struct) " + name +
                                              "( final)?( : [^{;]*)? \\{"));
}

/// A unit is a header with its sources: that of its name, and those of which it declares most of
/// what they define and which have no header of their own.
std::string unit_of(const std::string& file, const Files& files, const std::string& room) {
  const std::string stem = fs::path(file).stem();
  if (file.ends_with(".h") || files.contains(stem + ".h")) return stem;
  const Names names = defined(files.at(file));
  std::string unit = stem;
  std::ptrdiff_t most = 0;
  for (const std::string& header : included(room, files.at(file))) {
    const std::ptrdiff_t count = std::ranges::count_if(
        names, [&](const std::string& name) { return declares(files.at(header), name); });
    if (count > most) unit = fs::path(header).stem();
    most = std::max(most, count);
  }
  return unit;
}

Units units_of(const Files& files, const std::string& room) {
  Units units;
  for (const auto& [file, text] : files) {
    const std::string unit = unit_of(file, files, room);
    for (const std::string& header : included(room, text)) {
      const std::string other = fs::path(header).stem();
      if (other != unit) units[unit].insert(other);
      units[other];
    }
    units[unit];
  }
  return units;
}

/// One that is as short as any through its first unit; empty: there is none.
std::string circle_in(const Units& units) {
  for (const auto& [first, seen] : units) {
    std::map<std::string, std::string> before;  // on the way from the first
    Names reached{first};
    for (std::size_t k = 0; k < reached.size(); ++k) {
      for (const std::string& next : units.at(reached[k])) {
        if (next == first) {
          std::string circle = first;
          for (std::string at = reached[k]; at != first; at = before.at(at)) {
            circle = at + " -> " + circle;
          }
          return first + " -> " + circle;
        }
        if (before.emplace(next, reached[k]).second) reached.push_back(next);
      }
    }
  }
  return {};
}

TEST(Circles, GoThroughSourcesOfOtherNames) {
  Files files = {{"a.h", "struct A {\n  void go();\n};\nvoid run(A& a);\n"},
                 {"a.cpp", "#include \"room/a.h\"\n"},
                 {"b.h", "#include \"room/a.h\"\nvoid walk();\n"},
                 {"b.cpp", "#include \"room/b.h\"\n#include \"other/c.h\"\n"},
                 {"c.h", "#include \"room/b.h\"\n"},
                 {"steps.cpp",
                  "#include \"room/a.h\"\n#include \"room/b.h\"\n"
                  "\nnamespace {\nvoid run() {}\n\n}  // namespace\n"
                  "void walk() {}\n"}};
  EXPECT_EQ(units_of(files, "room"), (Units{{"a", {}}, {"b", {"a"}}, {"c", {"b"}}}));
  EXPECT_EQ(circle_in(units_of(files, "room")), "");
  files["steps.cpp"] = "#include \"room/a.h\"\n#include \"room/c.h\"\n\nvoid A::go() {}\n";
  EXPECT_EQ(circle_in(units_of(files, "room")), "a -> c -> b -> a");
}

TEST(SourceTree, NoRoomHasACircle) {
  const fs::path root = TAUT_SOURCE_DIR;
  std::map<std::string, Files> rooms;
  for (const char* house : {"sim", "scenes", "render"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / house)) {
      const fs::path file = fs::relative(entry.path(), root);
      if (file.extension() != ".h" && file.extension() != ".cpp") continue;
      rooms[file.parent_path().string()][file.filename().string()] = read_file(entry.path());
    }
  }
  std::size_t seen = 0;
  for (const auto& [room, files] : rooms) {
    const Units units = units_of(files, room);
    EXPECT_EQ(circle_in(units), "") << "units of " << room << " include each other";
    for (const auto& [unit, others] : units) seen += others.size();
  }
  EXPECT_GT(seen, 150u) << "the includes are found at all";
}

}  // namespace
}  // namespace taut::source_circles_test
