// Worlds with contact or strings by the direct method: as without until something is near.
#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <vector>

#include "sim/contact/capsule.h"
#include "sim/methods/direct/implicit.h"
#include "sim/methods/direct/integrator.h"
#include "sim/run/method.h"

namespace taut::direct {

/// Follows a world in groups that move without each other: connectors with the free bodies that
/// they hold or may touch and those that these may touch, and connectors that may touch each other.
/// Every sixtieth of a second it looks which of them can reach an obstacle, or each other, before
/// the next one. The others go by a
/// method that knows no contact, with the same bits as in a world without; these go by implicit
/// steps, and so does each group with strings. The times that are asked for change nothing.
class Contacts {
 public:
  /// `make` makes methods that follow links without obstacles.
  Contacts(const StepOptions& options, std::function<std::unique_ptr<Method>()> make);

  /// Call before the first advance() and whenever the topology is new.
  void prepare(const World& world);
  /// Adds the events until then.
  void advance(World& world, double until, std::vector<Event>& events);

  Counters counters() const;

 private:
  struct Group {
    World part;                                   // as it is shown, with all that it may touch
    World before, now;                            // by `links`, before and after; without
    std::vector<std::size_t> bodies, connectors;  // indices into the world's
    std::unique_ptr<Method> links, shown_links;
    std::unique_ptr<Implicit> implicit;
    contact::NearLinks near_links;
    std::vector<double> places;  // m, of all particles
    bool strings = false;        // some of its links are
    bool by_implicit = false;    // as far as `end`
    std::vector<Event> events;   // by `implicit`, of the part
    double time = 0;             // s, of `now`, beyond what is shown
    double end = 0;              // s, where one looks again at what is near
    std::exception_ptr stop;     // by which `links` ended between `before` and `now`
  };

  static void begin(Group& group);
  static bool read(const World& world, Group& group);
  static void write(const Group& group, World& world);
  static bool is_near(Group& group, double within);
  double next_end(double time) const;
  void follow(Group& group, double until) const;
  bool follow_links(Group& group, double until) const;
  void follow_implicit(Group& group, double until) const;
  void show(Group& group, double until) const;
  [[noreturn]] void give_up(const World& part, const Diverged& stop) const;

  StepOptions options_;
  std::function<std::unique_ptr<Method>()> make_;
  std::vector<std::unique_ptr<Group>> groups_;
  Counters counters_;  // of groups that are no more
};

}  // namespace taut::direct
