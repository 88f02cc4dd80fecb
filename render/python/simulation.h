// Simulations as Python steps them.
#pragma once

#include <filesystem>
#include <memory>

#include "render/python/convert.h"
#include "render/python/errors.h"
#include "sim/run/simulation.h"

namespace taut::python {

class SimulationObject : public std::enable_shared_from_this<SimulationObject> {
 public:
  /// Throws std::invalid_argument where the method or a setting is wrong. `fps`: of the frames at
  /// which a method that chooses its steps stops on its way.
  SimulationObject(const World& world, MethodChoice method, Timeline timeline, double fps);

  /// Goes to `until` (s) without Python's lock. A method with a step goes in as many of them as
  /// without stops between; another one stops at every frame. Both look for signals there.
  void advance(double until);

  std::uint64_t pin(const std::string& connector, double along, const std::optional<Attachment>& to,
                    double over);
  void move(std::uint64_t pin, const Attachment& to, double over);
  void release(std::uint64_t pin);
  /// The name of the part that is new.
  std::string cut(const std::string& connector, double along);

  /// The state, into and from a file.
  void save(const std::filesystem::path& file) const;
  void load(const std::filesystem::path& file);

  py::array positions(const std::string& connector);
  py::array velocities(const std::string& connector);
  /// The body's own frame: x, y, z (m), qw, qx, qy, qz.
  py::array pose(const std::string& body) const;
  double passed(const std::string& pulley) const;
  /// Of the last advance().
  const std::vector<Event>& events() const { return events_; }

  /// The simulation, which no other thread may be changing: throws std::runtime_error where one is.
  const Simulation& simulation() const {
    refuse_if_taken(taken_);
    return simulation_;
  }
  const World& world() const { return simulation().world(); }
  const MethodChoice& method() const { return method_; }

 private:
  double next_stop(double until);
  /// Leaves their memory to windows if anything happens up to `until`.
  void detach_before(double until);
  std::vector<Vec3>& particles(const std::string& connector, std::vector<Vec3> Connector::*which);
  void refuse_unless_done(const char* what, Outcome outcome) const;

  MethodChoice method_;
  double fps_, step_ = 0;        // s; 0: the method's own
  double stride_ = 1;            // steps from one look for signals to the next
  bool timed_ = false;           // it has pins or cuts that were known beforehand
  bool may_break_ = false;       // some connector
  std::vector<double> happens_;  // s, rising, of these
  std::size_t happened_ = 0;
  Simulation simulation_;
  std::vector<Event> events_;
  Windows windows_;
  mutable bool taken_ = false;
};

void add_simulation(py::module_& module);

}  // namespace taut::python
