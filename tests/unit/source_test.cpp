// The rules of the source tree that neither compiler nor linker checks.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>

#include "tests/support/definitions.h"
#include "tests/support/folder.h"

namespace taut::source_test {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

TEST(Definitions, AreFoundInNamedNamespacesAlone) {
  EXPECT_EQ(
      type_definitions("namespace a { struct B { struct C {}; }; struct D; enum class E { x };\n"
                       "namespace { struct F {}; }\n"
                       "namespace b::c { template <class T> class G final : public B {}; }\n"
                       "using H = B; void f() { struct I {}; }\n"
                       "struct J<int> {}; struct B::K {}; }"),
      (Names{"a::B", "a::E", "a::b::c::G", "a::H", "a::J<int>", "a::B::K"}));
  EXPECT_EQ(type_definitions(
                "// struct A {};\n/* struct B {}; */\n#define C struct C {};\\\n struct D {};\n"
                "const char* e = \"struct E {};\\\"\"; char f = '{';\n"
                "auto g = R\"x(struct G {})x\"; int h = 1'000'000; struct I {};"),
            Names{"I"});
}

/// Two types of one name in one program share the code that the compiler makes of them: the one
/// definition rule leaves undefined what happens then.
TEST(SourceTree, NoProgramHasTwoTypesOfOneName) {
  const fs::path root = TAUT_SOURCE_DIR;
  std::map<std::string, std::map<std::string, std::set<std::string>>> seen;  // type, program, files
  const std::string all = "";
  for (const char* room : {"sim", "scenes", "render", "tests"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / room)) {
      const fs::path file = fs::relative(entry.path(), root);
      if (file.extension() != ".h" && file.extension() != ".cpp") continue;
      const fs::path kind = *std::next(file.begin());
      const bool is_shared = *file.begin() != "tests" || kind == "support";
      const std::string program = is_shared         ? all
                                  : kind == "bench" ? file.parent_path().string()
                                                    : kind.string();
      for (const std::string& type : type_definitions(read_file(entry.path()))) {
        seen[type][program].insert(file.string());
      }
    }
  }
  EXPECT_GT(seen.size(), 300u) << "the types are found at all";
  for (auto& [type, programs] : seen) {
    const std::set<std::string> shared = programs[all];
    for (auto& [program, files] : programs) {
      files.insert(shared.begin(), shared.end());
      std::string list;
      for (const std::string& file : files) list += " " + file;
      EXPECT_LE(files.size(), 1u) << type << " is defined in" << list;
    }
  }
}

using Folders = std::map<std::string, std::set<std::string>>;

/// The folders that the files of each folder include from, beside their own.
Folders included_folders() {
  const fs::path root = TAUT_SOURCE_DIR;
  const std::regex include("#include \"([^\"]+)/[^\"/]+\"");
  Folders folders;
  for (const char* module : {"sim", "scenes", "render"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / module)) {
      const fs::path file = fs::relative(entry.path(), root);
      if (file.extension() != ".h" && file.extension() != ".cpp") continue;
      const std::string folder = file.parent_path().string();
      std::set<std::string>& included = folders[folder];
      const std::string text = read_file(entry.path());
      for (std::sregex_iterator i(text.begin(), text.end(), include), end; i != end; ++i) {
        if ((*i)[1] != folder) included.insert((*i)[1]);
      }
    }
  }
  return folders;
}

/// The folders that lie on a circle of includes, or include from one.
std::set<std::string> in_circles(Folders folders) {
  for (bool shrinks = true; shrinks;) {
    shrinks = false;
    for (auto i = folders.begin(); i != folders.end();) {
      const bool is_free = std::ranges::none_of(
          i->second, [&](const std::string& other) { return folders.contains(other); });
      i = is_free ? folders.erase(i) : std::next(i);
      shrinks |= is_free;
    }
  }
  std::set<std::string> left;
  for (const auto& [folder, included] : folders) left.insert(folder);
  return left;
}

TEST(SourceTree, FoldersDoNotIncludeEachOtherInCircles) {
  EXPECT_EQ(in_circles({{"a", {"b"}}, {"b", {"c"}}, {"c", {}}, {"d", {"a", "c"}}}),
            std::set<std::string>{});
  EXPECT_EQ(in_circles({{"a", {"b"}}, {"b", {"a"}}, {"c", {}}, {"d", {"a"}}}),
            (std::set<std::string>{"a", "b", "d"}));
  const Folders folders = included_folders();
  EXPECT_GT(folders.size(), 30u) << "the folders are found at all";
  EXPECT_EQ(in_circles(folders), std::set<std::string>{});
}

/// sim <- scenes <- render.
TEST(SourceTree, ModulesIncludeFromTheirLeftAlone) {
  const std::vector<std::string> order{"sim", "scenes", "render"};
  const auto place = [&](const std::string& folder) {
    return std::ranges::find(order, folder.substr(0, folder.find('/'))) - order.begin();
  };
  std::size_t seen = 0;
  for (const auto& [folder, included] : included_folders()) {
    for (const std::string& other : included) {
      EXPECT_LE(place(other), place(folder)) << folder << " includes from " << other;
      ++seen;
    }
  }
  EXPECT_GT(seen, 200u) << "the includes are found at all";
}

/// One namespace in a folder, taut or one within it; subfolders may share it.
TEST(SourceTree, EachFolderHasOneNamespace) {
  const std::regex opened("\\nnamespace (taut(?:::[a-z_]+)?)[a-z_:]* \\{");
  std::size_t seen = 0;
  for (const auto& [folder, included] : included_folders()) {
    std::set<std::string> names;
    for (const fs::directory_entry& entry :
         fs::directory_iterator(fs::path(TAUT_SOURCE_DIR) / folder)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      const std::string text = read_file(entry.path());
      std::sregex_iterator i(text.begin(), text.end(), opened), end;
      EXPECT_TRUE(i != end || extension == ".cpp") << entry.path() << " has no namespace";
      for (; i != end; ++i, ++seen) names.insert((*i)[1]);
    }
    EXPECT_LE(names.size(), 1u) << folder;
  }
  EXPECT_GT(seen, 250u) << "the namespaces are found at all";
}

TEST(SourceTree, EveryModelHasLimits) {
  const fs::path assets = fs::path(TAUT_SOURCE_DIR) / "assets";
  const std::string checks = read_file(assets / "make/check.py");
  for (const fs::directory_entry& entry : fs::directory_iterator(assets)) {
    if (entry.path().extension() != ".glb") continue;
    const std::string name = entry.path().stem().string();
    EXPECT_NE(checks.find("\n    \"" + name + "\": ("), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace taut::source_test
