// Studies of connectors that stretch and bend.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "render/chart/table.h"
#include "tests/cli/swing_scene.h"
#include "tests/cli/table_columns.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut::material_study_test {
namespace {

namespace fs = std::filesystem;

TEST(LongStability, MapsTheStiffnessesOfAMaterial) {
  const Folder folder;
  const fs::path scene = fs::path(TAUT_SOURCE_DIR) / "scenes/materials/bungee.toml";
  const ProgramResult result =
      run_taut({"stability", scene.string(), "--set", "duration=0.3", "--set",
                "connectors.rubber.bending_stiffness=1", "--quick", "--budget", "4", "--methods",
                "direct,springs", "--out", folder.path().string()},
               folder.path());
  ASSERT_EQ(result.code, 0) << result.messages;
  const chart::Table table = chart::from_csv(read_file(folder.path() / "stability.csv"));
  const auto maps = cells(table, "map"), classes = cells(table, "class"),
             methods = cells(table, "method");
  for (const char* map : {"axial_stiffness", "bending_stiffness"}) {
    EXPECT_NE(std::ranges::find(maps, map), maps.end()) << map;
    EXPECT_TRUE(fs::exists(folder.path() / fmt::format("stability_{}.png", map)));
  }
  for (std::size_t i = 0; i < classes.size(); ++i) {
    // Rubber that stretches as it should is no mistake of the method.
    const bool is_direct = methods[i] == "direct";
    EXPECT_FALSE(is_direct && classes[i] == "stretched") << table.rows[i][1];
  }
}

/// A rope that bends a little: by `stiffness`, N m^2.
std::string stiff_swing(const char* stiffness) {
  std::string text = kShortSwing;
  const std::string place = "[connectors.rope]\n";
  text.replace(text.find(place), place.size(),
               fmt::format("{}bending_stiffness = {}\n", place, stiffness));
  return text;
}

TEST(Plan, NeglectsWhatChangesNothing) {
  const Folder folder;
  for (const auto& [stiffness, is_kept] : {std::pair{"1e-9", false}, {"1e-2", true}}) {
    folder.write("swing.toml", stiff_swing(stiffness));
    const ProgramResult found = run_taut(
        {"plan", "swing.toml", "--tolerance", "0.5mm", "--json", "--write"}, folder.path());
    ASSERT_EQ(found.code, 0) << found.messages;
    const auto plan = nlohmann::json::parse(found.output);
    EXPECT_EQ(plan.at("neglected").empty(), is_kept) << stiffness;
    const double without = plan.at("model_error").at("without").at("bending").get<double>();
    EXPECT_EQ(without > 0.5, is_kept) << without;

    const ProgramResult planned =
        run_taut({"simulate", "swing.toml", "--planned", "--json"}, folder.path());
    ASSERT_EQ(planned.code, 0) << planned.messages;
    const ProgramResult check = run_taut({"check", "--plans", "swing.toml"}, folder.path());
    EXPECT_EQ(check.output.find("no bending") == std::string::npos, is_kept) << check.output;
  }
}

}  // namespace
}  // namespace taut::material_study_test
