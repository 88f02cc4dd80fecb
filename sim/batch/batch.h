// Many connectors of one kind, stepped together.
#pragma once

#include <memory>
#include <vector>

#include "sim/batch/width.h"
#include "sim/world/world.h"

namespace taut::batch {

/// The connectors of a world, all of as many particles, each hanging by its first particle from a
/// fixed or driven point of its own, with its own lengths, masses and motion; their last particles
/// are free, point masses included. They do not touch.
///
/// Links are exactly rigid, and all tensions of a connector are solved together, as the method
/// `direct` does; the step is fixed and the order two. A lane of a vector is a connector, so that
/// the same operations in the same order make the same bits at any width and number of threads.
/// Scalar is double, or float where an error of some 1e-5 of the length is small enough.
template <typename Scalar>
class Batch {
 public:
  /// Throws std::invalid_argument with the reason where the world is another. `step` in s.
  Batch(const World& world, double step, batch::Width width = batch::widest());

  /// To `until` (s) in equal steps of at most the step, on `threads` threads. Throws Diverged where
  /// a connector is not finite any more: the step is too long for its tension's waves.
  void advance(double until, int threads = 1);

  double time() const { return time_; }
  /// Writes positions, velocities and the time.
  void store(World& world) const;

 private:
  Scalar* group(std::size_t index) const { return data_.get() + index * group_size_; }
  Scalar& number(std::size_t connector, std::size_t array, std::size_t link) const {
    const std::size_t row = array * links_ + link + 1;  // one lies before them
    return group(connector / kernel_.lanes)[row * kernel_.lanes + connector % kernel_.lanes];
  }
  void load(const Connector& connector, std::size_t index);
  void pull(std::size_t group, double time, Scalar* out) const;
  void check() const;

  struct Free {
    void operator()(Scalar* data) const;
  };
  batch::Kernel<Scalar> kernel_;
  double step_;
  double time_;  // s
  Vec3 gravity_;
  std::size_t links_ = 0, groups_ = 0, group_size_ = 0;
  bool started_ = false;
  std::vector<Attachment> ends_;          // one per connector
  std::vector<bool> driven_;              // [group] some end of it moves
  std::unique_ptr<Scalar[], Free> data_;  // [group][array][link][lane]
};

extern template class Batch<float>;
extern template class Batch<double>;

}  // namespace taut::batch
