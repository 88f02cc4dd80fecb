// Massless spans by the direct method: free while slack, one rigid link while taut; strings of
// one link for implicit steps.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

#include "sim/run/method.h"
#include "sim/topology/components.h"
#include "sim/world/hanging.h"
#include "sim/world/world.h"

namespace taut::direct {

/// Lays the particles of a massless span between its ends: straight where it is taut, else as they
/// would hang there.
void lay_span(HangingChain& hanging, Connector& connector, const Span& span, const Vec3& gravity);

/// A method that follows links, and knows what they pull.
class LinkMethod : public Method {
 public:
  /// The tension (N) of the first link of each connector from `first` on, in the world as advance()
  /// left it or as something else has changed it since; zero where nothing can move the link.
  virtual void find_tensions(World& world, std::size_t first, std::vector<double>& tension) = 0;
};

/// Follows a world some of whose connectors are massless spans, by a method that follows links.
/// Connectors that stretch, bend or meet the air are left to others.
/// The method sees a world of its own, in which a taut span is a link without mass between its two
/// ends and a slack one is absent; a point mass at an end is a body that nothing turns. Changes are
/// found between two checks and located in time: a slack span whose ends part beyond its length
/// goes taut, a taut one whose tension turns negative goes slack. Going taut, the ends are thrown
/// back with the connector's restitution; where that is none, or they were thrown back just before,
/// the link takes their speed of separation away, which keeps all momenta.
class Spans {
 public:
  /// `links` follows everything but spans.
  explicit Spans(std::unique_ptr<LinkMethod> links) : links_(std::move(links)) {}

  /// Call before the first advance() and whenever the topology is new.
  void prepare(const World& world);
  void advance(World& world, double until, std::vector<Event>& events);

  /// The method that follows everything but spans.
  Method& links() { return *links_; }
  const Method& links() const { return *links_; }

  const Counters& counters() const { return links_->counters(); }

 private:
  struct Tie {
    std::size_t span = 0;  // index into spans_
    Attachment a, b;       // in the inner world
    double restitution = 0;
    double longest = 0;    // m: a slack one goes taut beyond it
    std::size_t link = 0;  // connector of the inner world, while it is taut
    double thrown_back = -std::numeric_limits<double>::infinity();  // s, when its ends last were
    double watched = thrown_back;  // s, from which on its changes are counted
    int changes = 0;
  };
  struct PointMass {
    std::size_t connector = 0, particle = 0;
  };

  Attachment attachment(const World& world, const Span& span, const SpanEnd& end);
  void read(const World& world);
  void write(World& world);
  void connect();
  void update();
  bool breaks(const Tie& tie) const;
  bool breaks();
  void advance_to_break(double until);
  bool rebounds(Tie& tie, std::vector<Event>& events);
  void watch_changes(const World& world, Tie& tie) const;

  std::unique_ptr<LinkMethod> links_;
  World inner_, before_;
  std::vector<Span> spans_;
  std::vector<Tie> ties_;
  std::vector<PointMass> point_masses_;  // bodies of the inner world, behind those of the outer
  std::vector<std::size_t> copied_;      // connectors of the outer world that are links
  std::vector<double> tension_;          // N, of the inner world's connectors
  HangingChain hanging_;
};

// Massless spans as strings of one link, for steps that know no spans.

/// A copy of a world in which each massless span is a connector of its own: a string of one link
/// between the same ends, with the same restitution. The first span of a connector has the
/// connector's index, the others follow behind all. Ends that nothing holds and that have no mass
/// get a millionth of what the lightest particle or body has.
class SpansAsStrings {
 public:
  /// Call first, and whenever the topology is new.
  void rebuild(const World& world);
  /// Takes the state of the world that the copy was made of, and gives it the copy's.
  void read(const World& world);
  void write(World& world);
  World& world() { return strings_; }
  struct Place {
    Span span;
    std::size_t string = 0;  // index of a connector of world()
  };
  const std::vector<Place>& places() const { return places_; }

 private:
  std::vector<Place> places_;
  World strings_;
  HangingChain hanging_;
};

}  // namespace taut::direct
