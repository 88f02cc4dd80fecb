#include "scenes/load/plan_file.h"

#include <gtest/gtest.h>

#include "scenes/files/error.h"
#include "scenes/load/load_scene.h"
#include "scenes/scene/scene.h"
#include "tests/support/folder.h"

namespace taut::plan_file_test {
namespace {

constexpr const char* kPlanned = R"(duration = 1.0
[connectors.rope]
length = 0.2
mass = 0.05
particles = 21
from = { fixed = [0, 0, 0] }
to = { free = true }
start = { direction = [1, 0, 0] }
)";

scenes::Plan a_plan() {
  scenes::Plan plan;
  plan.tolerance = "1px";
  plan.error = 0.4;
  plan.until = 4.1;
  plan.afterwards = {scenes::Plan::Afterwards::Work::none, 0.001, 1e-4, 0.04};
  plan.method = {"xpbd", {{"step", 1.0 / 960}, {"iterations", 4.0}}};
  plan.program = scenes::method_stamp(plan.method);
  plan.particles = {{"rope", 6}};
  return plan;
}

class PlanFile : public testing::Test {
 protected:
  /// The scene with a plan made for it as it is.
  void plan() {
    scenes::Plan plan = a_plan();
    plan.stamp = scenes::plan_stamp(file_);
    folder_.write("scene.toml", scenes::with_plan(read_file(file_), plan));
  }

  Folder folder_;
  std::filesystem::path file_ = folder_.write("scene.toml", kPlanned);
};

TEST_F(PlanFile, IsReadAsItWasWritten) {
  plan();
  const scenes::Scene scene = scenes::load_scene(file_, false);
  ASSERT_TRUE(scene.plan.has_value());
  EXPECT_EQ(scene.plan->tolerance, "1px");
  EXPECT_EQ(scene.plan->until, 4.1);
  ASSERT_TRUE(scene.plan->afterwards.has_value());
  EXPECT_EQ(scene.plan->afterwards->work, scenes::Plan::Afterwards::Work::none);
  EXPECT_EQ(scene.plan->afterwards->energy, 0.001);
  EXPECT_EQ(scene.plan->afterwards->stretch, 1e-4);
  EXPECT_EQ(scene.plan->afterwards->speeds, 0.04);
  EXPECT_EQ(scene.plan->method.settings, a_plan().method.settings);
  EXPECT_EQ(scene.world.connectors[0].particles(), 21u) << "the scene itself stays";
  const scenes::Scene planned = scenes::load_planned(file_, false);
  EXPECT_EQ(planned.method.name, "xpbd");
  EXPECT_EQ(planned.world.connectors[0].particles(), 6u);
}

TEST_F(PlanFile, MayTakeAConnectorForAMasslessSpan) {
  scenes::Plan plan = a_plan();
  plan.method = {"direct", {{"tolerance", 1e-3}}};
  plan.program = scenes::method_stamp(plan.method);
  plan.particles = {{"rope", 0}};
  plan.stamp = scenes::plan_stamp(file_);
  folder_.write("scene.toml", scenes::with_plan(read_file(file_), plan));
  const Connector rope = scenes::load_planned(file_, false).world.connectors[0];
  EXPECT_EQ(rope.model, ConnectorModel::span);
  EXPECT_EQ(rope.particles(), 21u);
  EXPECT_EQ(scenes::load_scene(file_, false).world.connectors[0].model, ConnectorModel::links);
}

TEST_F(PlanFile, ReplacesAnOlderOne) {
  plan();
  const std::string once = read_file(file_);
  plan();
  EXPECT_EQ(read_file(file_), once);
  EXPECT_EQ(scenes::load_planned(file_, false).method.name, "xpbd");
}

/// TOML writes one table in many ways, and what looks like its heading may be text.
TEST_F(PlanFile, ReplacesAnOlderOneHoweverThatIsWritten) {
  const std::string scene = kPlanned, title = "title = \"\"\"\n[plan]\nstamp\"\"\"\n";
  plan();
  const std::string once = read_file(file_);
  // Texts that have an older plan, or seem to, and texts that the same plan makes equal.
  const std::pair<std::string, std::string> ways[] = {
      {scene + "  [plan]\nuntil = 1\n", once},
      {scene + "[ plan ]\nmethod = { name = \"xpbd\", step = [1,\n 2] }\n", once},
      {scene + "[\"plan\"]  # older\n# a remark\nuntil = 1\n[plan.method]\nname = 2\n", once},
      {"plan.until = 1\nplan.method.name = 2\n" + scene, once},
      {"plan = { until = 1 }\n" + scene, once},
      {scene + "[plan]\nstamp = \"\"\"\n[x]\n\"\"\"\n", once},
      {title + once, title + scene},
  };
  for (const auto& [before, after] : ways) {
    scenes::Plan plan = a_plan();
    plan.stamp = 7;
    EXPECT_EQ(scenes::with_plan(before, plan), scenes::with_plan(after, plan)) << before;
  }
}

TEST_F(PlanFile, LeavesTheRemarksBehindThePlanItReplaces) {
  const std::string behind = "# The second.\n[connectors.other]\nlength = 1\n";
  const std::string text =
      scenes::with_plan(std::string(kPlanned) + "[plan]\nuntil = 1\n\n" + behind, a_plan());
  EXPECT_EQ(text.find(behind), std::string_view(kPlanned).size());
}

TEST_F(PlanFile, OfASceneThatChangedIsRefused) {
  EXPECT_THROW(scenes::load_planned(file_, false), scenes::BadScene);
  plan();
  std::string text = read_file(file_);
  text.replace(text.find("mass = 0.05"), 11, "mass = 0.06");
  folder_.write("scene.toml", text);
  EXPECT_NO_THROW(scenes::load_scene(file_, false)) << "only the plan is of no use any more";
  try {
    scenes::load_planned(file_, false);
    FAIL() << "taken";
  } catch (const scenes::BadScene& error) {
    EXPECT_NE(std::string(error.what()).find("plan.stamp: changed since its plan was made"),
              std::string::npos);
  }
}

TEST_F(PlanFile, OfAnotherProgramIsRefused) {
  scenes::Plan older = a_plan();
  older.stamp = scenes::plan_stamp(file_);
  older.program ^= 1;
  folder_.write("scene.toml", scenes::with_plan(read_file(file_), older));
  try {
    scenes::load_planned(file_, false);
    FAIL() << "taken";
  } catch (const scenes::BadScene& error) {
    EXPECT_NE(std::string(error.what()).find("this program's method moves otherwise"),
              std::string::npos)
        << error.what();
  }
}

/// The scene itself is as good as ever.
TEST_F(PlanFile, OfAnotherFormatIsRefusedAlone) {
  const std::pair<const char*, const char*> faults[] = {
      {"program = ", "version = "},  // a key that was another once
      {"tolerance = \"1px\"", "tolerance = \"1 parsec\""},
      {"tolerance = \"1px\"", "tolerance = 1"},
      {"name = \"xpbd\"", "name = \"shake\""},       // a method that is no more
      {"rope = { particles", "cord = { particles"},  // a connector that has another name now
  };
  for (const auto& [is, was] : faults) {
    folder_.write("scene.toml", kPlanned);
    plan();
    std::string text = read_file(file_);
    text.replace(text.find(is), std::string_view(is).size(), was);
    folder_.write("scene.toml", text);
    EXPECT_NO_THROW(scenes::load_scene(file_, false)) << was;
    try {
      scenes::load_planned(file_, false);
      ADD_FAILURE() << "taken: " << was;
    } catch (const scenes::BadScene& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find("its plan is of another version of taut"), std::string::npos) << what;
      EXPECT_NE(what.find("scene.toml:"), std::string::npos) << "names the place: " << what;
      EXPECT_NE(what.find("--write makes one"), std::string::npos) << what;
    }
    plan();
    EXPECT_NO_THROW(scenes::load_planned(file_, false)) << "planned anew after " << was;
  }
}

TEST(MethodStamp, TellsMethodsAndSettingsApart) {
  const MethodChoice direct{"direct", {{"tolerance", 1e-4}}};
  EXPECT_EQ(scenes::method_stamp(direct), scenes::method_stamp(direct));
  EXPECT_NE(scenes::method_stamp(direct), scenes::method_stamp({"direct", {{"tolerance", 1e-2}}}));
  EXPECT_NE(scenes::method_stamp(direct), scenes::method_stamp({"impulse", {}}));
}

TEST_F(PlanFile, MayTakeABodyForALinkAndExposuresForTheShutter) {
  folder_.write("scene.toml", R"(duration = 1.0
[bodies.stick]
mass = 0.1
shape = { cylinder = { length = 0.2, diameter = 0.02 } }
hangs = [0, -1, 0]
[connectors.rope]
length = 0.2
mass = 0.05
particles = 6
from = { fixed = [0, 0, 0] }
to = { body = "stick", point = [0, 0.1, 0] }
start = { direction = [1, 0, 0] }
[stage]
shutter = 0.5
)");
  scenes::Plan plan = a_plan();
  plan.tolerance = "1.5px";
  plan.links = {"stick"};
  plan.exposures = 32;
  plan.stamp = scenes::plan_stamp(file_);
  folder_.write("scene.toml", scenes::with_plan(read_file(file_), plan));
  const scenes::Scene planned = scenes::load_planned(file_, true);
  EXPECT_EQ(planned.world.bodies[0].model, BodyModel::link);
  EXPECT_EQ(planned.stage->exposures, 32);
  EXPECT_EQ(planned.stage->exposures_apart, 3);
  const scenes::Scene written = scenes::load_scene(file_, true);
  EXPECT_EQ(written.world.bodies[0].model, BodyModel::rigid);
  EXPECT_EQ(written.stage->exposures, scenes::Stage().exposures);
}

TEST_F(PlanFile, TablesAfterItStay) {
  plan();
  folder_.write("scene.toml",
                read_file(file_) + "[paths.hand]\nkeys = [{ t = 0, position = [0, 0, 0] }]\n");
  plan();
  const std::string text = read_file(file_);
  EXPECT_NE(text.find("[paths.hand]"), std::string::npos);
  EXPECT_EQ(text.find("[plan]"), text.rfind("[plan]"));
  EXPECT_NO_THROW(scenes::load_planned(file_, false));
}

TEST(Certificate, SaysHowFarAndHowLong) {
  EXPECT_EQ(
      scenes::certificate(a_plan()),
      "within 0.4 px of the reference solution until 4.1 s; afterwards energy within 0.1%, stretch "
      "within 0.01%, speeds within 4%");
  scenes::Plan to_its_end = a_plan();
  to_its_end.afterwards.reset();
  to_its_end.tolerance = "0.5mm";
  EXPECT_EQ(scenes::certificate(to_its_end), "within 0.4 mm of the reference solution until 4.1 s");
  scenes::Plan chaos = a_plan();
  chaos.until = 0;
  EXPECT_EQ(scenes::certificate(chaos),
            "of an unpredictable motion; energy within 0.1%, stretch within 0.01%, "
            "speeds within 4%");
}

TEST(Certificate, SaysWhatIsDoneToIt) {
  scenes::Plan plan = a_plan();
  plan.end = "a pin comes";
  plan.afterwards->work = scenes::Plan::Afterwards::Work::known;
  EXPECT_EQ(
      scenes::certificate(plan),
      "within 0.4 px of the reference solution until 4.1 s, when a pin comes; afterwards energy, "
      "less the work of what drives it, within 0.1%, stretch within 0.01%, speeds within 4%");
  plan.afterwards->work = scenes::Plan::Afterwards::Work::unknown;
  EXPECT_NE(scenes::certificate(plan).find("afterwards mean energy within 0.1%"),
            std::string::npos);
}

TEST(Certificate, NeverClaimsMoreThanWasFound) {
  scenes::Plan plan = a_plan();
  plan.error = 0.401;
  plan.until = 4.19;
  plan.afterwards->energy = 0.001001;
  EXPECT_EQ(scenes::certificate(plan),
            "within 0.41 px of the reference solution until 4.1 s; afterwards energy within 0.11%, "
            "stretch within 0.01%, speeds within 4%");
}

}  // namespace
}  // namespace taut::plan_file_test
