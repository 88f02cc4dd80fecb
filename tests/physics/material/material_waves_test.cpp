// Frequencies, wave speeds and decays of what stretches and bends, against the continuous rope.
#include <gtest/gtest.h>

#include "material_worlds.h"

namespace taut::material_waves_test {
namespace {

using namespace material_worlds;
using std::numbers::pi;

// The value of cos(w t) a quarter of a period after ten periods of the theory tells the error of w:
// the phase there is 20.5 pi times the relative difference.
constexpr double kPeriods = 10.25;

TEST(Beam, FirstFrequencyOfACantilever) {
  const double mass = 0.2, bending = 0.05;
  const double frequency = std::pow(first_beam_number(), 2) * std::sqrt(bending / mass);
  const World start = bent_beam(50, mass, section(kRigid, bending), 1e-4);
  const World end = after(start, kPeriods * 2 * pi / frequency, 1e-9);
  EXPECT_LT(std::abs(beam_share(end, start)) / (2 * pi * kPeriods), 1e-3);
}

// M x'' + D x' + K x = 0 with D = (damping / stiffness) K: the amplitude falls at half of
// (damping / stiffness) w^2, and the frequency is that of the undamped times sqrt(1 - ratio^2), so
// that damping leaves the stiffness as it is.
TEST(Beam, DampingDecaysAtTheStatedRate) {
  const double mass = 0.2, bending = 0.05, time = 0.004;
  Section made = section(kRigid, bending);
  made.bending_damping = time * bending;
  const double frequency = std::pow(first_beam_number(), 2) * std::sqrt(bending / mass);
  const double decay = time * frequency * frequency / 2;
  const double damped = std::sqrt(frequency * frequency - decay * decay);
  const World start = bent_beam(50, mass, made, 1e-4);
  const double cycle = 2 * pi / damped;
  EXPECT_NEAR(beam_share(after(start, 10 * cycle, 1e-9), start) / std::exp(-10 * cycle * decay), 1,
              5e-3);
}

/// A rope with one end free, stretched in its slowest way, weightless.
World stretched(std::size_t links, const Section& made, double amplitude) {
  World world = rope(links, 0.2, made, false);
  world.gravity.setZero();
  for (Vec3& position : world.connectors[0].position) {
    position.x() += amplitude * std::sin(pi / 2 * position.x());
  }
  return world;
}

double share(const World& world, double amplitude) {
  return (world.connectors[0].position.back().x() - 1) / amplitude;
}

// A quarter of a wave stands on the rope: w = (pi/2) sqrt(EA / (mass per length)).
TEST(Wave, LongitudinalSpeed) {
  const double axial = 80, speed = std::sqrt(axial / 0.2), amplitude = 1e-3;
  const World start = stretched(50, section(axial, 0), amplitude);
  const World end = after(start, kPeriods * 4 / speed, 1e-8);
  EXPECT_LT(std::abs(share(end, amplitude)) / (2 * pi * kPeriods), 1e-3);
}

TEST(Wave, DampingDecaysAtTheStatedRate) {
  const double axial = 80, time = 0.001, amplitude = 1e-3;
  Section made = section(axial, 0);
  made.axial_damping = time * axial;
  const double frequency = pi / 2 * std::sqrt(axial / 0.2);
  const double decay = time * frequency * frequency / 2;
  const double cycle = 2 * pi / std::sqrt(frequency * frequency - decay * decay);
  const World end = after(stretched(50, made, amplitude), 5 * cycle, 1e-8);
  EXPECT_NEAR(share(end, amplitude) / std::exp(-5 * cycle * decay), 1, 5e-3);
}

}  // namespace
}  // namespace taut::material_waves_test
