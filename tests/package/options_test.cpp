// Settings with types are the generic ones: the header is written from the list of methods.
#include "sim/options.h"

#include <gtest/gtest.h>

#include "sim/run/simulation.h"

namespace taut {
namespace {

template <class Options>
class OptionsOf : public testing::Test {};
using All = testing::Types<impulse::Options, dynamic_constraints::Options, sdfast::Options,
                           multibody::Options, springs::Options, xpbd::Options, direct::Options,
                           truth::Options>;
TYPED_TEST_SUITE(OptionsOf, All);

TYPED_TEST(OptionsOf, AMethodAreItsOwnChoiceUnlessGiven) {
  const MethodInfo* method = find_method(TypeParam::method);
  ASSERT_TRUE(method);
  EXPECT_EQ(settings(TypeParam{}), with_defaults(*method, {}));
}

TEST(Options, EveryMethodWithSettingsHasThem) {
  std::size_t count = 0;
  for (const MethodInfo& method : all_methods()) count += !method.settings.empty();
  EXPECT_EQ(count, 8u);
}

TEST(Options, AreGivenByName) {
  EXPECT_EQ(direct::settings({.tolerance = 1e-3}), (Settings{{"tolerance", 1e-3}, {"step", 0.0}}));
  EXPECT_EQ(multibody::settings({.integrator = multibody::Options::Integrator::runge_kutta_3})
                .at("integrator"),
            Setting(std::string("runge-kutta-3")));
  EXPECT_THROW(make_method(direct::Options{.tolerance = -1}), std::invalid_argument);
}

TEST(Options, MakeTheMethodThatTheGenericOnesMake) {
  World world;
  world.connectors = {straight_connector("rope", 1, 0.2, 11, Vec3::Zero(), Vec3::UnitX())};
  world.connectors[0].holds = {{0, {}, {}}};
  Simulation typed(world, make_method(springs::Options{.step = 1e-4}));
  Simulation generic(world, make_method("springs", {{"step", 1e-4}}));
  typed.advance_to(0.1);
  generic.advance_to(0.1);
  EXPECT_EQ(state_hash(typed.world()), state_hash(generic.world()));
}

}  // namespace
}  // namespace taut
