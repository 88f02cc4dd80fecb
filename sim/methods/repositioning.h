// The repositioning of particles between the ends of spans: section IV.B of the paper.
#pragma once

#include <vector>

#include "sim/methods/bead_touches.h"
#include "sim/methods/span_impulse.h"
#include "sim/topology/span.h"

namespace taut::methods {

class Repositioning {
 public:
  Repositioning(LinkLimits limits, double threshold, bool as_printed)
      : limits_(limits), threshold_(threshold), as_printed_(as_printed) {}

  /// Reads lengths and masses; call whenever the topology changes.
  void prepare(const World& world, const std::vector<Span>& spans);
  /// m, rest length from the first particle of a connector.
  const std::vector<double>& along(std::size_t connector) const { return along_[connector]; }

  /// Notes where the particles are after free flight and impulses.
  void begin(const World& world);
  /// Neighbours nearer than l_c or farther than l_t, by more than h, are moved to that distance,
  /// each by the other's part of their mass; what touches something, as far as that lets it.
  void pass(World& world, const Span& span, const BeadTouches& touches, double dt) const;
  /// A particle farther from an end than the rest length between them is moved to that distance;
  /// from both ends, and the ends themselves last. Corners divide the span into parts.
  void stay_in_reach(World& world, const Span& span, BeadTouches& touches, double dt);
  /// Velocities from positions: flight gave dx/dt + g dt/2, repositioning adds what it moved.
  void set_velocities(World& world, double dt) const;
  const std::vector<std::vector<Vec3>>& flown() const { return flown_; }

 private:
  /// A connector in a step.
  struct Strand {
    std::vector<Vec3>& position;
    const std::vector<double>&along, &weight;
    std::size_t connector;
    const BeadTouches* touches;  // null: nothing touches
    double dt;                   // s
  };
  Strand strand(World& world, const Span& span, const BeadTouches& touches, double dt) const;
  void make_room(const World& world);
  void weigh(const Connector& connector, std::size_t index);
  void reach(const Strand& strand, std::size_t first, std::size_t last, std::size_t end) const;
  void meet(const Strand& strand, std::size_t i, std::size_t end) const;
  static void draw(const Strand& strand, std::size_t i, std::size_t j, double squared,
                   double wanted);
  static void draw_at_surfaces(const Strand& strand, std::size_t i, std::size_t j, const Vec3& move,
                               double wanted);

  LinkLimits limits_;
  double threshold_;  // m: h
  bool as_printed_;
  // Per connector and particle:
  std::vector<std::vector<double>> along_;   // m, rest length from the first particle
  std::vector<std::vector<double>> weight_;  // how easily it is moved; zero: held
  std::vector<std::vector<Vec3>> flown_;     // m, after free flight and impulses
  std::vector<std::size_t> dividers_;        // particles: a span's ends, and its corners
};

}  // namespace taut::methods
