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

/// The rooms that each room may look into, beside its own files.
const std::map<std::string, std::set<std::string>> kSees = {
    {"sim/motion", {}},
    {"sim/winch", {"sim/motion"}},
    {"sim/world", {"sim/motion", "sim/winch"}},
    {"sim/topology", {"sim/world"}},
    {"sim/measure", {"sim/motion", "sim/world", "sim/topology"}},
    {"sim/material", {"sim/motion", "sim/world", "sim/measure"}},
    {"sim/links", {"sim/motion", "sim/world", "sim/topology", "sim/material"}},
    {"sim/contact", {"sim/motion", "sim/world", "sim/links"}},
    {"sim/interventions", {"sim/motion", "sim/world", "sim/topology", "sim/links"}},
    {"sim/features", {"sim/world", "sim/interventions"}},
    {"sim/run",
     {"sim/motion", "sim/world", "sim/topology", "sim/measure", "sim/links", "sim/interventions",
      "sim/features"}},
    {"sim/batch", {"sim/world", "sim/links", "sim/run"}},
    {"sim/choreography",
     {"sim/motion", "sim/world", "sim/interventions", "sim/features", "sim/contact", "sim/run"}},
    {"sim/methods/direct/system",
     {"sim/motion", "sim/world", "sim/topology", "sim/material", "sim/links"}},
    {"sim/methods/direct/schemes", {"sim/motion", "sim/methods/direct/system"}},
    {"sim/methods/direct",
     {"sim/motion", "sim/world", "sim/topology", "sim/measure", "sim/material", "sim/links",
      "sim/contact", "sim/run", "sim/methods/direct/system", "sim/methods/direct/schemes"}},
    {"sim/methods",
     {"sim/motion", "sim/world", "sim/topology", "sim/measure", "sim/material", "sim/links",
      "sim/contact", "sim/run", "sim/methods/direct"}},
    {"sim/options", {"sim/run"}},
    {"sim/reference/sdfast", {"sim/motion", "sim/world"}},
    {"sim/reference",
     {"sim/motion", "sim/world", "sim/links", "sim/contact", "sim/run", "sim/reference/sdfast"}},
    {"sim/truth", {"sim/motion", "sim/interventions", "sim/run"}},
    {"sim/evaluation",
     {"sim/motion", "sim/world", "sim/topology", "sim/interventions", "sim/measure", "sim/contact",
      "sim/run", "sim/truth"}},
    {"sim/study", {"sim/motion", "sim/measure", "sim/truth", "sim/evaluation"}},
    {"sim/examples", {"taut"}},
    {"scenes/files", {"sim/motion"}},
    {"scenes/model", {"sim/motion", "scenes/files"}},
    {"scenes/character", {"sim/motion", "sim/world", "sim/run", "scenes/files", "scenes/model"}},
    {"scenes/scene",
     {"sim/motion", "sim/world", "sim/run", "sim/choreography", "scenes/model",
      "scenes/character"}},
    {"scenes/format", {"sim/motion", "sim/run", "scenes/files"}},
    {"scenes/reader",
     {"sim/motion", "sim/world", "sim/features", "sim/contact", "sim/choreography", "scenes/files",
      "scenes/model", "scenes/character", "scenes/scene", "scenes/format"}},
    {"scenes/load",
     {"sim/choreography", "sim/contact", "sim/motion", "sim/run", "scenes/files",
      "scenes/character", "scenes/scene", "scenes/format", "scenes/reader"}},
    {"render/base", {"sim/motion"}},
    {"render/picture", {"scenes/files"}},
    {"render/chart", {"sim/motion", "render/base"}},
    {"render/gl", {"render/base", "render/picture"}},
    {"render/mesh", {"sim/motion", "sim/world", "scenes/model", "scenes/scene"}},
    {"render/draw/shading",
     {"sim/motion", "scenes/model", "scenes/scene", "scenes/character", "render/picture",
      "render/gl", "render/mesh"}},
    {"render/draw",
     {"sim/motion", "sim/world", "sim/run", "scenes/scene", "render/picture", "render/gl",
      "render/mesh", "render/draw/shading"}},
    {"render/film",
     {"sim/motion", "sim/world", "scenes/files", "scenes/scene", "render/base", "render/picture",
      "render/chart", "render/gl", "render/draw"}},
    {"render/golden",
     {"sim/motion", "sim/run", "scenes/files", "scenes/load", "render/base", "render/picture",
      "render/chart"}},
    {"render/export",
     {"sim/run", "scenes/files", "scenes/format", "scenes/character", "scenes/scene"}},
    {"render/export/gltf",
     {"sim/motion", "scenes/files", "scenes/format", "scenes/model", "scenes/character",
      "scenes/scene", "render/mesh", "render/export"}},
    {"render/program",
     {"sim/motion", "sim/interventions", "sim/run", "scenes/files", "scenes/format", "scenes/load",
      "render/base", "render/chart"}},
    {"render/options",
     {"sim/motion", "sim/topology", "sim/run", "sim/evaluation", "scenes/files", "scenes/scene",
      "scenes/format", "scenes/load", "render/base", "render/picture", "render/chart",
      "render/film", "render/program"}},
    {"render/study",
     {"sim/motion", "sim/run", "sim/truth", "sim/evaluation", "sim/study", "scenes/files",
      "scenes/scene", "render/base", "render/chart", "render/draw/shading", "render/program",
      "render/options"}},
    {"render/plan",
     {"sim/motion", "sim/topology", "sim/run", "sim/evaluation", "sim/study", "scenes/files",
      "scenes/scene", "scenes/load", "render/base", "render/chart", "render/draw", "render/program",
      "render/options"}},
    {"render/clip",
     {"sim/motion", "sim/world", "sim/measure", "sim/run", "sim/evaluation", "scenes/files",
      "scenes/scene", "scenes/load", "render/base", "render/picture", "render/chart", "render/gl",
      "render/draw", "render/film", "render/golden", "render/program", "render/options",
      "render/study"}},
    {"render/report",
     {"sim/run", "sim/truth", "sim/evaluation", "scenes/files", "scenes/scene", "render/base",
      "render/chart", "render/program", "render/options", "render/study", "render/clip"}},
    {"render/cli",
     {"sim/choreography", "sim/contact",    "sim/links",      "sim/motion",    "sim/measure",
      "sim/run",          "sim/truth",      "sim/evaluation", "sim/study",     "scenes/files",
      "scenes/scene",     "scenes/format",  "scenes/load",    "render/base",   "render/chart",
      "render/draw",      "render/film",    "render/golden",  "render/export", "render/export/gltf",
      "render/program",   "render/options", "render/study",   "render/plan",   "render/clip",
      "render/report"}},
    {"render/package", {"sim/run", "render/program", "render/cli"}},
    {"render/python",
     {"sim/motion", "sim/world", "sim/topology", "sim/measure", "sim/interventions", "sim/run",
      "sim/batch", "sim/truth", "sim/evaluation", "sim/study", "scenes/files", "scenes/scene",
      "scenes/load", "render/base", "render/gl", "render/film"}},
};

TEST(SourceTree, RoomsDoNotSeeEachOtherInCircles) {
  std::set<std::string> below;  // that see nothing but each other, from the bottom up
  for (bool grew = true; grew;) {
    grew = false;
    for (const auto& [room, seen] : kSees) {
      const auto is_below = [&](const std::string& other) {
        return below.contains(other) || !kSees.contains(other);
      };
      if (std::ranges::all_of(seen, is_below)) grew |= below.insert(room).second;
    }
  }
  for (const auto& [room, seen] : kSees) {
    EXPECT_TRUE(below.contains(room)) << room << " sees itself through others";
  }
}

TEST(SourceTree, NoIncludeRunsTheWrongWay) {
  const fs::path root = TAUT_SOURCE_DIR;
  const std::regex include("#include \"([^\"]+)/[^\"/]+\"");
  std::size_t seen = 0;
  for (const char* house : {"sim", "scenes", "render"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / house)) {
      const fs::path file = fs::relative(entry.path(), root);
      if (file.extension() != ".h" && file.extension() != ".cpp") continue;
      const std::string room = file.parent_path().string();
      ASSERT_TRUE(kSees.contains(room)) << room << " is new: say above what it may see";
      const std::string text = read_file(entry.path());
      for (std::sregex_iterator i(text.begin(), text.end(), include), end; i != end; ++i) {
        const std::string other = (*i)[1];
        ++seen;
        EXPECT_TRUE(other == room || kSees.at(room).contains(other)) << file << " sees " << (*i)[0];
      }
    }
  }
  EXPECT_GT(seen, 1000u) << "the includes are found at all";
}

/// The namespace of each room, within taut. The core of sim is the library's own: taut itself.
const std::map<std::string, std::string> kNamespaces = {
    {"sim/motion", ""},
    {"sim/winch", ""},
    {"sim/world", ""},
    {"sim/topology", ""},
    {"sim/measure", ""},
    {"sim/links", ""},
    {"sim/interventions", ""},
    {"sim/features", ""},
    {"sim/run", ""},
    {"sim/options", ""},
    {"sim/material", "material"},
    {"sim/contact", "contact"},
    {"sim/batch", "batch"},
    {"sim/choreography", "choreography"},
    {"sim/methods", "methods"},
    {"sim/methods/direct", "direct"},
    {"sim/methods/direct/system", "direct"},
    {"sim/methods/direct/schemes", "direct"},
    {"sim/reference", "reference"},
    {"sim/reference/sdfast", "sdfast"},
    {"sim/truth", "truth"},
    {"sim/evaluation", "study"},
    {"sim/study", "study"},
    {"scenes/files", "scenes"},
    {"scenes/model", "scenes"},
    {"scenes/character", "scenes"},
    {"scenes/scene", "scenes"},
    {"scenes/format", "scenes"},
    {"scenes/reader", "scenes"},
    {"scenes/load", "scenes"},
    {"render/base", "render"},
    {"render/picture", "picture"},
    {"render/chart", "chart"},
    {"render/gl", "gl"},
    {"render/mesh", "mesh"},
    {"render/draw", "draw"},
    {"render/draw/shading", "draw"},
    {"render/film", "film"},
    {"render/golden", "golden"},
    {"render/export", "exporting"},
    {"render/export/gltf", "exporting"},
    {"render/program", "program"},
    {"render/options", "options"},
    {"render/study", "studies"},
    {"render/plan", "planning"},
    {"render/clip", "clips"},
    {"render/report", "report"},
    {"render/cli", "cli"},
    {"render/package", "package"},
    {"render/python", "python"},
};

TEST(SourceTree, EachRoomHasItsNamespace) {
  const fs::path root = TAUT_SOURCE_DIR;
  const std::regex opened("\\nnamespace taut(?:::([a-z_]+))?[a-z_:]* \\{");
  std::size_t seen = 0;
  for (const auto& [room, name] : kNamespaces) {
    for (const fs::directory_entry& entry : fs::directory_iterator(root / room)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      const std::string text = read_file(entry.path());
      std::sregex_iterator i(text.begin(), text.end(), opened), end;
      EXPECT_TRUE(i != end || extension == ".cpp") << entry.path() << " has no namespace";
      for (; i != end; ++i, ++seen) EXPECT_EQ((*i)[1], name) << entry.path();
    }
  }
  EXPECT_GT(seen, 500u) << "the namespaces are found at all";
  for (const auto& [room, others] : kSees) {
    EXPECT_TRUE(kNamespaces.contains(room) || room == "sim/examples") << room;
  }
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
