#include "sim/run/method.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/run/simulation.h"

namespace taut::method_test {
namespace {

TEST(Methods, EveryRowMakesItsMethodFromItsDefaults) {
  ASSERT_FALSE(all_methods().empty());
  for (const MethodInfo& method : all_methods()) {
    EXPECT_EQ(find_method(method.name), &method);
    EXPECT_FALSE(method.summary.empty());
    Settings all;
    for (const SettingInfo& setting : method.settings) {
      all.emplace(setting.name, setting.fallback);
      EXPECT_FALSE(setting.meaning.empty()) << setting.name;
    }
    EXPECT_EQ(complaint(method, all), "") << method.name;
  }
  EXPECT_EQ(find_method("magic"), nullptr);
  EXPECT_NE(make_method("impulse", {}), nullptr);
}

TEST(Methods, WrongSettingsAreNamed) {
  const MethodInfo& impulse = *find_method("impulse");
  const auto say = [&](const char* name, Setting value) {
    return complaint(impulse, {{name, std::move(value)}});
  };
  EXPECT_NE(say("stepp", 0.1).find("no setting stepp"), std::string::npos);
  EXPECT_NE(say("step", true).find("is true or false, expected a number"), std::string::npos);
  EXPECT_NE(say("step", 0.0).find("more than 0"), std::string::npos);
  EXPECT_NE(say("step", std::nan("")).find("finite"), std::string::npos);
  EXPECT_NE(say("h", -1.0).find("at least 0"), std::string::npos);
  EXPECT_NE(say("passes", 1.5).find("whole"), std::string::npos);
  EXPECT_EQ(say("passes", 2.0), "");
  EXPECT_THROW(make_method("magic", {}), std::invalid_argument);
  EXPECT_THROW(make_method("impulse", {{"step", -1.0}}), std::invalid_argument);
}

TEST(Methods, SayWhatTheyDoNotFollow) {
  World world;
  EXPECT_EQ(refusal(*find_method("dynamic-constraints"), world), "");
  world.obstacles.emplace_back().name = "floor";
  EXPECT_EQ(refusal(*find_method("dynamic-constraints"), world),
            "does not follow obstacles (obstacle floor)");
  EXPECT_EQ(refusal(*find_method("direct"), world), "");
}

TEST(Methods, ValuesOfSettingsArePrintedExactlyOrRounded) {
  EXPECT_EQ(setting_text(1.0 / 60), "0.016666666666666666");
  EXPECT_EQ(setting_text(1.0 / 60, 6), "0.0166667");
  EXPECT_EQ(setting_text(1e5), "100000");
  EXPECT_EQ(setting_text(1e5 + 0.5, 3), "1e+05");
  EXPECT_EQ(setting_text(1e-5), "1e-05");
  EXPECT_EQ(setting_text(true), "true");
  EXPECT_EQ(setting_text(std::string("rk4")), "rk4");
}

TEST(Methods, StepCountIsExactWhereTheStepDivides) {
  EXPECT_EQ(step_count(0, 0.1), 0u);
  EXPECT_EQ(step_count(1, 0.1), 10u);
  EXPECT_EQ(step_count(1.01, 0.1), 11u);
  EXPECT_EQ(step_count(1e-9, 0.1), 1u);
  EXPECT_EQ(step_count(1 / 60.0, 1 / 960.0), 16u);
  EXPECT_EQ(step_count(1 / 60.0, 0.001), 17u);
  for (int k = 0; k < 600; ++k) {
    EXPECT_EQ(step_count((k + 1) / 50.0 - k / 50.0, 0.001), 20u) << k;
  }
}

TEST(Methods, StepTimesAreTheSameHoweverFramesDivideThem) {
  for (const int fps : {10, 25, 50, 100}) {
    int step = 0;
    for (int frame = 0; frame < 12 * fps; ++frame) {
      const StepTimes times(frame / double(fps), (frame + 1) / double(fps), 0.001);
      ASSERT_EQ(times.count, std::uint64_t(1000 / fps));
      EXPECT_EQ(times.dt, 0.001);
      for (std::uint64_t i = 0; i < times.count; ++i) ASSERT_EQ(times.at(i + 1), ++step * 0.001);
    }
  }
  const StepTimes odd(1 / 60.0, 2 / 60.0, 0.001);  // does not divide: equal steps, exact end
  EXPECT_EQ(odd.count, 17u);
  EXPECT_EQ(odd.at(0), 1 / 60.0);
  EXPECT_EQ(odd.at(17), 2 / 60.0);
}

TEST(Simulation, HasTheEventsOfItsLastAdvanceAlone) {
  World world;
  Connector cord = straight_connector("cord", 1, 0, 5, Vec3::Zero(), -Vec3::UnitY());
  for (Vec3& position : cord.position) position *= 0.5;  // slack at first
  cord.model = ConnectorModel::span;
  cord.restitution = 0.9;
  cord.particle_mass.back() = 0.5;
  cord.holds = {{0, {}}};
  world.connectors = {cord};
  finish(world);
  for (const char* name : {"impulse", "direct"}) {
    constexpr int kFrames = 120;
    World same = world;
    const auto method = make_method(name, {});
    Simulation simulation(world, make_method(name, {}));
    std::size_t all = 0, most = 0;
    for (int k = 1; k <= kFrames; ++k) {
      simulation.advance_to(k / 60.0);
      method->advance(same, k / 60.0);
      const std::size_t now = simulation.method().events().size();
      all += now;
      most = std::max(most, now);
    }
    EXPECT_EQ(all, method->events().size()) << name;
    EXPECT_GT(all, 2 * most) << name << ": not all in one frame";
    EXPECT_EQ(method->take_events().size(), all);
    EXPECT_TRUE(method->events().empty());
  }
}

/// The motion until `time` of a world built anew from the state of `simulation`.
Snapshot built_anew(const Simulation& simulation, std::unique_ptr<Method> method, double time) {
  World anew = simulation.world();
  for (Body& body : anew.bodies) {
    if (!body.driven()) reweigh(body, body.bare);
  }
  anew.topology = 0;  // not finished
  Simulation other(std::move(anew), std::move(method));
  other.advance_to(time);
  return other.state();
}

TEST(Simulation, NoticesWhatIsChangedByHand) {
  World world;
  Body body;
  body.mass_properties = solid_sphere(0.5, 0.1);
  body.position = Vec3(1, 0, 0);
  Connector rope = straight_connector("rope", 1, 0.1, 11, Vec3::Zero(), Vec3::UnitX());
  rope.holds = {{0, {}}, {10, {}}};
  rope.holds[1].to.kind = Attachment::Kind::body;
  world.bodies = {body};
  world.connectors = {rope};
  const Settings fine = {{"tolerance", 1e-8}};
  for (const auto& [name, settings] :
       {std::pair("direct", fine), {"xpbd", Settings{{"step", 1e-3}}}, {"impulse", Settings()}}) {
    Simulation simulation(world, make_method(name, settings));
    World& kept = simulation.world();
    simulation.advance_to(0.2);
    const std::uint64_t before = kept.topology;
    kept.connectors[0].particle_mass[5] += 0.3;   // a bead on the rope
    kept.connectors[0].particle_mass[10] += 0.2;  // and one that the body has to carry
    kept.bodies[0].bare.mass += 0.1;
    const Snapshot anew = built_anew(simulation, make_method(name, settings), 0.5);
    simulation.advance_to(0.5);
    EXPECT_NE(kept.topology, before) << name;
    EXPECT_DOUBLE_EQ(kept.bodies[0].mass_properties.mass, 0.5 + 0.1 / 11 + 0.2 + 0.1) << name;
    const Snapshot changed = simulation.state();
    for (std::size_t i = 0; i < changed.connectors[0].size(); ++i) {
      EXPECT_LT((changed.connectors[0][i] - anew.connectors[0][i]).norm(), 1e-7) << name << i;
    }
    kept.connectors[0].holds.pop_back();  // the body falls off, without what it carried
    simulation.advance_to(0.6);
    EXPECT_DOUBLE_EQ(kept.bodies[0].mass_properties.mass, 0.6) << name;
  }
}

TEST(Simulation, GoesForwardOnly) {
  Simulation simulation(World{}, make_method("impulse", {}));
  simulation.advance_to(0.1);
  EXPECT_EQ(simulation.world().time, 0.1);
  simulation.advance_to(0.1);
  EXPECT_THROW(simulation.advance_to(0.05), std::invalid_argument);
  EXPECT_EQ(simulation.method().counters().steps, 100u);
}

}  // namespace
}  // namespace taut::method_test
