// Worlds with contact or strings by the direct method: as without until something is near.
#pragma once

#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "sim/methods/direct/contact/contact_step.h"
#include "sim/methods/direct/implicit.h"
#include "sim/methods/direct/integrator.h"
#include "sim/run/method.h"

namespace taut::direct {

/// Follows a world in groups that move without each other: connectors with the free bodies that
/// they hold or may touch and those that these may touch. While nothing of a group can reach an
/// obstacle, or bodies each other, before the next check, a method that knows no contact follows
/// it, and leaves the same bits as in a world without. Else Implicit does for bodies
/// without connectors, where friction or other bodies stop them; and ContactStep the rest, and
/// where Implicit finds no step. The times that are asked for end no step of either: what is shown
/// at a time within one is followed from where that step began, and left behind.
class Contacts {
 public:
  /// `make` makes methods that follow links without obstacles.
  Contacts(const StepOptions& options, std::function<std::unique_ptr<Method>()> make);

  /// Call before the first advance() and whenever the topology is new.
  void prepare(const World& world);
  void advance(World& world, double until);

  Counters counters() const;

 private:
  static constexpr double kShortestJam = 1e-6;  // s
  struct Group {
    World part;                                   // as it is shown
    World before, now;                            // where links are followed, before and after
    std::vector<std::size_t> bodies, connectors;  // indices into the world's
    std::vector<BodyPair> pairs;                  // of the part's bodies
    std::vector<BeadPair> bead_pairs;             // of the part's connectors and bodies
    std::unique_ptr<Method> links, shown_links;
    std::unique_ptr<Implicit> implicit;  // where there is friction, or bodies touch each other
    World touching;                      // the part with all that it may touch, for `implicit`
    bool by_implicit = false;            // it follows the group as far as `end`
    ContactStep step;
    ContactStep::Past before_step, present;  // of ContactStep
    bool strings = false;       // some of its links are: ContactStep follows it throughout
    bool steps = false;         // ContactStep has its present state
    bool is_noted = false;      // `before_step` is where the last step of ContactStep began
    bool is_back = false;       // ContactStep is off to show something, and `present` its state
    double from = 0, time = 0;  // s, of the last step, beyond what is shown
    double end = 0;             // s, where its steps end next
    std::exception_ptr stop;    // by which `links` ended between both
    double h = 0;               // s, for the next step; 0: not known
    double first = 0;           // s, of the first
    /// s, of the next step: after one that failed it doubles from step to step.
    double limit = std::numeric_limits<double>::infinity();
    int located = 0, located_before = 0;  // hits in a row; before the last step
    /// s: where jammed beads have no solution with all of friction, steps so long go with less.
    double slippery = kShortestJam, slippery_before = 0;
    double unjammed = 0;  // s, since one did, or `slippery` was halved
  };

  static void begin(Group& group);
  bool read(const World& world, Group& group) const;
  static void write(const Group& group, World& world);
  bool is_near(const Group& group, const World& part, double within) const;
  static bool is_pair_near(const BodyPair& pair, const World& part, double within);
  static bool is_pair_near(const BeadPair& pair, const World& part, double within);
  bool is_body_near(const Body& body, const World& part, double within) const;
  static bool is_link_near(const Connector& connector, const Obstacle& obstacle, const World& part,
                           double within);
  [[noreturn]] void give_up(const World& part, const Group& group) const;

  void make_implicit(const World& world, Group& group) const;

  // Steps (contacts_steps.cpp).
  double next_end(double time) const;
  void follow(Group& group, double until);
  bool follow_links(Group& group, double until);
  static void begin_implicit(Group& group);
  static void follow_implicit(Group& group, double until);
  void begin_steps(Group& group);
  void take_step(Group& group, double until);
  double attempt(ContactStep& step, double time, double h, double slippery, int located);
  bool fails(const Group& group, double gone, double h) const;
  double adapted(const Group& group, double gone, double wish) const;
  static void watch_jam(Group& group, double gone);
  static void return_to_present(Group& group);
  void show(Group& group, double until);
  void show_within_step(Group& group, double until);

  StepOptions given_, options_;  // the second: of ContactStep, which is of second order
  std::function<std::unique_ptr<Method>()> make_;
  std::vector<Obstacle> obstacles_;
  std::vector<std::unique_ptr<Group>> groups_;
  Counters counters_;
};

}  // namespace taut::direct
