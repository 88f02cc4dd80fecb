// The pattern that a material gets by its name.
#include <gtest/gtest.h>

#include "render/draw/shading/drawable.h"

namespace taut::draw {
namespace {

TEST(Surface, IsThatOfAWordOfTheName) {
  for (const char* name : {"dark wood", "DarkWood_02", "hardwood", "Planks", "FLOOR.001"})
    EXPECT_EQ(surface_named(name), Surface::wood) << name;
  for (const char* name : {"Gi", "GiDark", "tablecloth", "belt-2", "TabiSole"})
    EXPECT_EQ(surface_named(name), Surface::cloth) << name;
  EXPECT_EQ(surface_named("Oak"), Surface::turned);
  for (const char* name : {"", "cloak", "magic", "Ginger", "Bandit", "_", "\xff\xfe", "woodpecker"})
    EXPECT_EQ(surface_named(name), Surface::plain) << name;
}

}  // namespace
}  // namespace taut::draw
