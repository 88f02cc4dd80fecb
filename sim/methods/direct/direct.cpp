#include "sim/methods/direct/direct.h"

#include <algorithm>
#include <cstring>

#include "sim/methods/direct/contacts.h"
#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/elastic.h"
#include "sim/methods/direct/followed_parts.h"
#include "sim/methods/direct/implicit.h"
#include "sim/methods/direct/joined.h"
#include "sim/methods/direct/spans.h"
#include "sim/run/error_estimate.h"
#include "sim/topology/components.h"

namespace taut::direct {
namespace {

using direct::Integrator;

/// Features that only the implicit step follows together.
const Abilities& abilities_without_implicit_step() {
  static const Abilities abilities{
      Features::all() -
          Features{Feature::clamp_on_body, Feature::joint_in_flow, Feature::applied_force},
      {
          {kMaterialFeatures -
               Features{Feature::bending_damping, Feature::taper, Feature::material_on_body},
           kContactFeatures},
          {kMaterialFeatures | kJointFeatures, Feature::strings},
          {kJointFeatures | kReelFeatures, kContactFeatures},
          {kReelFeatures, Features{Feature::strings, Feature::span, Feature::stretch}},
          {kReelFeatures, kJointFeatures, {}, Apart::Within::connector},
          {kJointFeatures | Features{Feature::material_on_body, Feature::hinge} | kContactFeatures |
               Feature::strings,
           Feature::span},
      }};
  return abilities;
}

/// Whether rigid links with a material are at their full length between two places of a connector
/// that are held: they cannot move, and tensions there are not determined.
bool has_locked_materials(const World& world) {
  constexpr double kSlack = 1e-9;
  for (const Connector& connector : world.connectors) {
    if (connector.sections.empty() || connector.stretches()) continue;
    std::vector<char> held(connector.particles(), 0);
    for (const Hold& hold : connector.holds) held[hold.particle] = 1;
    std::size_t last = connector.particles();
    double length = 0;
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      if (i > 0) length += connector.rest[i - 1];
      if (held[i] == 0) continue;
      if (last < i) {
        const double apart = (connector.position[i] - connector.position[last]).norm();
        if (apart >= (1 - kSlack) * length) return true;
      }
      last = i;
      length = 0;
    }
  }
  return false;
}

/// The state that advance() leaves in the world is where the next call goes on; a change of the
/// world between two calls starts the method afresh.
class Direct : public LinkMethod {
 public:
  explicit Direct(const direct::StepOptions& options) : options_(options) {}

  void advance(World& world, double until) override {
    if (!built_ || topology_ != world.topology) {
      require("direct", world);
      is_combined_ = find_refusal(abilities_without_implicit_step(), world).has_value() ||
                     has_locked_materials(world);
    }
    if (options_.step > 0) step_count(until - world.time, options_.step);  // throws
    if (!left_behind_) {  // else nothing of these is there, and no intervention adds it
      if (is_combined_) return advance_implicit(world, until);
      if (has_contact(world)) return advance_contacts(world, until);
      if (!world.joints.empty() || has_winches(world) || has_laden_materials(world) ||
          (has_hinges(world) && !has_strings(world) && !has_spans(world))) {
        return advance_joined(world, until);
      }
      if (has_strings(world)) return advance_contacts(world, until);
      if (has_spans(world)) return advance_spans(world, until);
    }
    prepare(world);
    counting_ = nullptr;
    advance_all_parts(world, until);
  }

  bool advance_near(World& world, double until, std::span<const Parts::Place> places) override {
    const bool in_parts =
        left_behind_ ||
        (world.joints.empty() && !has_winches(world) && !has_materials(world) &&
         !has_contact(world) && !has_spans(world) && !has_strings(world) && !has_hinges(world));
    if (!in_parts) {
      advance(world, until);
      return false;
    }
    counting_ = nullptr;
    prepare(world);
    if (!parts_.mark(world, places)) {
      advance_all_parts(world, until);
      return false;
    }
    for (const std::size_t part : parts_.near()) advance_part(world, part, until);
    place_driven(world, until);
    for (const std::size_t part : parts_.near()) {
      for (const SpanRange& span : parts_.all()[part]->component().spans) {
        Connector& connector = world.connectors[span.connector];
        for (const std::size_t end : {span.first, span.last}) {
          if (const Hold* hold = find_hold(connector, end)) place_hold(world, connector, *hold);
        }
      }
      store_part(world, part);
    }
    left_behind_ = true;
    return true;
  }

  void find_tensions(World& world, std::size_t first, std::vector<double>& tension) override {
    prepare(world);
    tension.assign(world.connectors.size(), 0);
    for (std::size_t k = 0; k < parts_.all().size(); ++k) {
      for (const SpanRange& span : parts_.all()[k]->component().spans) {
        if (span.connector < first) continue;
        with_part(world, k, [&](Integrator& part) {
          tension[span.connector] = part.tension(world.time, span.connector, counters_);
        });
      }
    }
  }

  /// Tries those schemes alone in each component of which `run` has taken steps since this was
  /// called last.
  void keep_to_schemes_of(const Direct& run) {
    if (spans_ && run.spans_) {
      return static_cast<Direct&>(spans_->links())
          .keep_to_schemes_of(static_cast<const Direct&>(run.spans_->links()));
    }
    const auto own = parts_.made(), others = run.parts_.made();
    for (std::size_t k = 0; k < std::min(own.size(), others.size()); ++k) {
      own[k]->keep_to_schemes_of(*others[k]);
    }
  }

 private:
  /// Whether the world's topology is new, which is known from then on.
  bool is_new(const World& world) {
    const bool fresh = !built_ || topology_ != world.topology;
    built_ = true;
    topology_ = world.topology;
    return fresh;
  }

  /// Makes the integrators go on from the world's state where that is not what they left there.
  void prepare(World& world) {
    if (left_behind_) {
      left_behind_ = false;
      topology_ = world.topology;
      return parts_.renew(world);
    }
    if (!built_) noted_.reserve(15 * world.bodies.size() + 6 * room(world).particles + 1);
    if (is_new(world)) {
      parts_.rebuild(world);
      rebuild_materials(world);
      noted_.clear();
    }
    if (!same(world)) parts_.load(world);
  }

  /// Nothing couples connectors that stretch, bend or meet the air with the rest.
  void rebuild_materials(const World& world) {
    std::size_t count = 0;
    for (std::size_t c = 0; c < world.connectors.size(); ++c) {
      if (world.connectors[c].sections.empty()) continue;
      if (count == elastic_.size()) {
        elastic_.push_back(std::make_unique<direct::Elastic>(options_));
      }
      elastic_[count++]->rebuild(world, c);
    }
    elastic_.resize(count);
  }

  void advance_materials(World& world, double until) {
    for (const auto& part : elastic_) part->advance(world, until, counters_);
  }

  void advance_all_parts(World& world, double until) {
    advance_materials(world, until);
    for (std::size_t part = 0; part < parts_.all().size(); ++part) {
      advance_part(world, part, until);
    }
    place_prescribed(world, until);
    for (std::size_t part = 0; part < parts_.all().size(); ++part) store_part(world, part);
    place_carried(world);
    refuse_led_away(world);
    note(world);
  }

  void advance_part(World& world, std::size_t index, double until) {
    with_part(world, index, [&](Integrator& part) { part.advance(world, until, counters_); });
  }

  /// Loops may not close at a time within a step.
  void store_part(World& world, std::size_t index) {
    with_part(world, index, [&](Integrator& part) { part.store(world); });
  }

  /// Throws Diverged with the cause where no step of the part is small enough.
  template <class Work>
  void with_part(const World& world, std::size_t index, Work work) {
    Integrator& part = *parts_.all()[index];
    try {
      work(part);
    } catch (const Integrator::StepTooSmall& stop) {
      throw stopped(world, part.component(), stop.time);
    }
  }

  Diverged stopped(const World& world, const Component& part, double time) const {
    const std::string why = direct::full_length(world, part, time);
    return Diverged("direct", time, counters_.steps,
                    part.spans.empty() ? world.bodies[part.bodies[0]].name
                                       : world.connectors[part.spans[0].connector].name,
                    part.spans.empty() ? 0 : part.spans[0].first,
                    why.empty() ? "no step is small enough for the tolerance" : why);
  }

  void advance_contacts(World& world, double until) {
    if (!contacts_) {
      contacts_ = std::make_unique<direct::Contacts>(
          options_, [options = options_] { return std::make_unique<Direct>(options); });
    }
    if (is_new(world)) contacts_->prepare(world);
    count_on(*contacts_, [&] { contacts_->advance(world, until, events_); });
  }

  void advance_joined(World& world, double until) {
    if (!joined_) joined_ = std::make_unique<direct::Joined>(options_);
    is_new(world);
    if (joined_->is_stiff(world)) {
      is_combined_ = true;
      return advance_implicit(world, until);
    }
    try {
      count_on(*joined_, [&] { joined_->advance(world, until); });
    } catch (const Diverged& stop) {
      // Links that fold through their full length may have no explicit step.
      if (stop.reason == kRunThrough || stop.reason == material::kPressedTogether) throw;
      const std::exception_ptr first = std::current_exception();
      try {
        advance_implicit(world, until);
      } catch (const Diverged&) {
        std::rethrow_exception(first);
      }
      is_combined_ = true;
    }
  }

  void advance_implicit(World& world, double until) {
    if (!implicit_) implicit_ = std::make_unique<direct::Implicit>(options_);
    is_new(world);
    count_on(*implicit_, [&] { implicit_->advance(world, until, events_); });
  }

  void advance_spans(World& world, double until) {
    if (!spans_) spans_ = std::make_unique<direct::Spans>(std::make_unique<Direct>(options_));
    if (is_new(world)) {
      spans_->prepare(world);
      rebuild_materials(world);
    }
    if (!elastic_.empty()) {
      advance_materials(world, until);
      counting_ = nullptr;
    }
    count_on(*spans_, [&] { spans_->advance(world, until, events_); });
    refuse_led_away(world);
  }

  /// Lets an integrator work, which counts from its own start, and counts on from what others did.
  template <typename Own, typename Work>
  void count_on(const Own& own, const Work& work) {
    if (counting_ != &own) {
      counted_ = counters_;
      counted_ -= own.counters();
      counting_ = &own;
    }
    const auto sum = [&] {
      counters_ = counted_;
      counters_ += own.counters();
    };
    try {
      work();
    } catch (const Diverged& error) {
      sum();
      if (counted_.steps == 0) throw;
      throw Diverged(error.method, error.time, error.step + counted_.steps, error.connector,
                     error.link, error.reason);
    }
    sum();
  }

  void refuse_led_away(const World& world) const {
    const auto found = direct::led_away(world);
    if (!found) return;
    throw Diverged("direct", world.time, counters_.steps, world.connectors[found->connector].name,
                   found->link, found->what);
  }

  /// Visits the world's state as blocks of doubles.
  template <typename Visit>
  static void each_block(const World& world, Visit visit) {
    static_assert(sizeof(Vec3) == 3 * sizeof(double));
    visit(&world.time, 1);
    for (const Body& body : world.bodies) {
      if (body.driven()) continue;
      visit(body.position.data(), 3);
      visit(body.velocity.data(), 3);
      visit(body.rotation.coeffs().data(), 4);
      visit(body.spin.data(), 3);
    }
    for (const Connector& connector : world.connectors) {
      if (connector.position.empty()) continue;
      visit(connector.position.data()->data(), 3 * connector.position.size());
      visit(connector.velocity.data()->data(), 3 * connector.velocity.size());
    }
  }

  bool same(const World& world) const {
    if (noted_.empty()) return false;
    const double* noted = noted_.data();
    bool equal = true;
    each_block(world, [&](const double* block, std::size_t size) {
      equal = equal && std::memcmp(noted, block, size * sizeof(double)) == 0;
      noted += size;
    });
    return equal;
  }

  void note(const World& world) {
    noted_.clear();
    each_block(world, [&](const double* block, std::size_t size) {
      noted_.insert(noted_.end(), block, block + size);
    });
  }

  direct::StepOptions options_;
  bool built_ = false;
  std::uint64_t topology_ = 0;
  bool is_combined_ = false;  // the world has features that only implicit steps follow together
  bool left_behind_ = false;  // parts of the world, by advance_near()
  direct::FollowedParts parts_{options_};
  std::vector<std::unique_ptr<direct::Elastic>> elastic_;  // of each connector with a material
  std::unique_ptr<direct::Spans> spans_;                   // where the world has massless ones
  std::unique_ptr<direct::Contacts> contacts_;  // where something touches, or strings are
  std::unique_ptr<direct::Implicit> implicit_;  // where features of these stand together
  std::unique_ptr<direct::Joined> joined_;      // where connectors are joined, and at hinges
  const void* counting_ = nullptr;              // of these, the one that was at work last
  Counters counted_;                            // by others than that one
  std::vector<double> noted_;                   // the world as advance() left it
};

/// A companion whose steps are shorter by a fifth. The errors of the three schemes fall by 1.25^8,
/// 1.25^4 and 1.25^3, so that the difference is 0.83, 0.59 and 0.49 of the error; two thirds are
/// near to each. Where it took another scheme than the run, its own error could be the larger one.
Companion with_finer_steps(double tolerance) {
  constexpr int kFrames = 4;
  direct::StepOptions options;
  options.tolerance = tolerance;
  options.finer = (kFrames + 1.0) / kFrames;
  return {.method = std::make_unique<Direct>(options),
          .ratio = 1.0 / 3,
          .frames = kFrames,
          .heed =
              [](Method& companion, const Method& run) {
                static_cast<Direct&>(companion).keep_to_schemes_of(static_cast<const Direct&>(run));
              },
          .asked = tolerance};
}

std::vector<bool> stepped_as_links(const World& world) {
  std::vector<bool> as_links(world.bodies.size());
  Division division;
  direct::PlaneFinder planes;
  for (const Component& part : division.divide(world)) {
    if (!planes.find(world, part, world.time, Vec3::Zero())) continue;
    for (const std::size_t body : part.bodies) as_links[body] = true;
  }
  return as_links;
}

}  // namespace

MethodInfo direct_method() {
  return {
      .name = "direct",
      .summary =
          "all links at once, exactly, in linear time; order and step follow from the error asked "
          "for",
      .settings = {{.name = "tolerance",
                    .meaning = "Largest RMS position error of all particles since the start. "
                               "Raising it costs less and errs more.",
                    .unit = "m",
                    .fallback = 1e-4,
                    .maximum = 1e3,
                    .above = true,
                    .sweep = {1.0, 3e-1, 1e-1, 3e-2, 1e-2, 5e-3, 3e-3, 2e-3, 1e-3, 5e-4, 3e-4, 2e-4,
                              1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9}},
                   {.name = "step",
                    .meaning = "Fixed time step instead of error control; 0: the steps follow from "
                               "the tolerance. Raising it costs less and errs more.",
                    .unit = "s",
                    .fallback = 0.0,
                    .maximum = 1.0}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        direct::StepOptions options;
        options.tolerance = number(settings, "tolerance");
        options.step = number(settings, "step");
        return std::make_unique<Direct>(options);
      },
      .abilities = {Features::all() - Feature::joint_in_flow,
                    {
                        {Feature::clamp_on_body, Feature::twist, {}, Apart::Within::connector},
                        {kReelFeatures, Feature::span, {}, Apart::Within::connector},
                        {kReelFeatures, kUnlikeReels, {}, Apart::Within::connector},
                    }},
      .parts_go_on = true,
      .companion =
          [](const MethodInfo& direct, const Settings& settings) {
            return number(settings, "step") > 0 ? with_step_doubled(direct, settings, 8)
                                                : with_finer_steps(number(settings, "tolerance"));
          },
      .particle_memory = 1000,
      .steps_as_links = stepped_as_links};
}

}  // namespace taut::direct
