#include "sim/batch/batch.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>
#include <thread>

#include "sim/run/method.h"

namespace taut::batch {
namespace {

constexpr std::align_val_t kAlignment{64};

void check_kind(const World& world) {
  const auto need = [](bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(what);
  };
  need(!world.connectors.empty(), "a batch needs a connector");
  for (const Connector& connector : world.connectors) {
    need(connector.particles() == world.connectors.front().particles(),
         "the connectors of a batch have as many particles each");
    need(connector.holds.size() == 1 && connector.holds.front().particle == 0 &&
             is_prescribed(world, connector.holds.front().to),
         "the connectors of a batch hang by their first particle from a fixed or driven point");
    need(connector.sections.empty() && !connector.pulls,
         "the links of a batch are rigid and bend freely");
    need(std::ranges::all_of(connector.rest, [](double rest) { return rest > 0; }),
         "the links of a batch have a length");
  }
}

/// The hold of a connector without its world: a driven body's point as a point of its path.
Attachment end_of(const World& world, const Connector& connector) {
  Attachment to = connector.holds.front().to;
  if (to.kind == Attachment::Kind::body) {
    const Body& body = world.bodies[to.body];
    to.kind = Attachment::Kind::path;
    to.path = body.path;
    to.point -= body.grip;
  }
  return to;
}

PointMotion motion_of(const Attachment& end, double time) {
  if (end.kind == Attachment::Kind::fixed) return {.position = end.point};
  return end.path->at(time).point(end.point);
}

}  // namespace

template <typename Scalar>
void Batch<Scalar>::Free::operator()(Scalar* data) const {
  ::operator delete[](data, kAlignment);
}

template <typename Scalar>
Batch<Scalar>::Batch(const World& world, double step, batch::Width width)
    : kernel_(batch::kernel<Scalar>(width)),
      step_(step),
      time_(world.time),
      gravity_(world.gravity) {
  check_kind(world);
  const std::size_t count = world.connectors.size();
  links_ = world.connectors.front().links();
  groups_ = (count + kernel_.lanes - 1) / kernel_.lanes;
  group_size_ = batch::group_size(links_, kernel_.lanes);
  data_.reset(new (kAlignment) Scalar[groups_ * group_size_]());
  driven_.resize(groups_);
  for (std::size_t i = 0; i < count; ++i) {
    ends_.push_back(end_of(world, world.connectors[i]));
    if (ends_.back().kind != Attachment::Kind::fixed) driven_[i / kernel_.lanes] = true;
    load(world.connectors[i], i);
  }
  // The last group's spare lanes repeat the last connector: any other motion would do as well.
  for (std::size_t i = count; i < groups_ * kernel_.lanes; ++i) load(world.connectors.back(), i);
}

template <typename Scalar>
void Batch<Scalar>::load(const Connector& connector, std::size_t index) {
  const auto put = [&](std::size_t array, std::size_t link, double value) {
    number(index, array, link) = static_cast<Scalar>(value);
  };
  for (std::size_t i = 0; i < links_; ++i) {
    const Vec3 along = connector.position[i + 1] - connector.position[i];
    const Vec3 unit = along.normalized();
    const Vec3 apart = (connector.velocity[i + 1] - connector.velocity[i]) / connector.rest[i];
    const Vec3 rate = apart - apart.dot(unit) * unit;
    for (int c = 0; c < 3; ++c) {
      const auto row = static_cast<std::size_t>(c);
      put(batch::kDirection + row, i, unit[c]);
      put(batch::kChord + row, i, rate[c]);
      put(batch::kRate + row, i, rate[c]);
    }
    put(batch::kInverseRest, i, 1 / connector.rest[i]);
  }
  // The constants of a row of links that a single end holds, as direct::Links has them.
  const auto inverse_mass = [&](std::size_t k) {
    return k > 0 ? 1 / connector.particle_mass[k] : 0;
  };
  const auto inverse_mass_sum = [&](std::size_t i) {
    return inverse_mass(i) + inverse_mass(i + 1);
  };
  const auto scale = [&](std::size_t i) { return std::sqrt(2 / inverse_mass_sum(i)); };
  for (std::size_t i = 0; i < links_; ++i) {
    const double own = scale(i), rest = connector.rest[i];
    put(batch::kScale, i, own);
    put(batch::kWeight, i, rest * own);
    put(batch::kOwnGain, i, inverse_mass_sum(i) * own / rest);
    put(batch::kDiagonalFirst, i, inverse_mass(i) * own * own);
    put(batch::kDiagonalSecond, i, inverse_mass(i + 1) * own * own);
    if (i > 0) put(batch::kLastGain, i, inverse_mass(i) * scale(i - 1) / rest);
    if (i + 1 == links_) continue;
    put(batch::kCoupling, i, inverse_mass(i + 1) * own * scale(i + 1));
    put(batch::kNextGain, i, inverse_mass(i + 1) * scale(i + 1) / rest);
  }
}

/// x y z of gravity less the upper ends' accelerations, for the lanes of a group.
template <typename Scalar>
void Batch<Scalar>::pull(std::size_t group, double time, Scalar* out) const {
  for (std::size_t lane = 0; lane < kernel_.lanes; ++lane) {
    const std::size_t i = std::min(group * kernel_.lanes + lane, ends_.size() - 1);
    const Vec3 felt = gravity_ - motion_of(ends_[i], time).acceleration;
    for (std::size_t c = 0; c < 3; ++c) {
      out[c * kernel_.lanes + lane] = static_cast<Scalar>(felt[static_cast<int>(c)]);
    }
  }
}

template <typename Scalar>
void Batch<Scalar>::advance(double until, int threads) {
  const StepTimes times(time_, until, step_);
  const std::size_t row = 3 * kernel_.lanes;
  const auto advance_groups = [&](std::size_t from, std::size_t to) {
    const std::unique_ptr<Scalar[], Free> pulls(new (kAlignment) Scalar[times.count * row]);
    for (std::size_t g = from; g < to; ++g) {
      const std::size_t instants = driven_[g] ? times.count : 1;
      for (std::size_t k = 0; k < instants; ++k) pull(g, times.at(k), pulls.get() + k * row);
      kernel_.advance(links_, group(g),
                      {times.count, static_cast<Scalar>(times.dt), !started_, pulls.get(),
                       driven_[g] ? row : 0});
    }
  };
  const std::size_t workers =
      std::clamp<std::size_t>(static_cast<std::size_t>(threads), 1, groups_);
  {
    std::vector<std::jthread> others;
    for (std::size_t k = 1; k < workers; ++k) {
      others.emplace_back(advance_groups, groups_ * k / workers, groups_ * (k + 1) / workers);
    }
    advance_groups(0, groups_ / workers);
  }
  started_ = started_ || times.count > 0;
  time_ = until;
  check();
}

template <typename Scalar>
void Batch<Scalar>::check() const {
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    for (std::size_t k = 0; k < links_; ++k) {
      bool finite = true;
      for (std::size_t c = 0; c < 3; ++c) {
        finite = finite && std::isfinite(number(i, batch::kDirection + c, k)) &&
                 std::isfinite(number(i, batch::kRate + c, k));
      }
      if (finite) continue;
      throw Diverged("batch", time_, 0, "connector " + std::to_string(i), k, "not finite");
    }
  }
}

template <typename Scalar>
void Batch<Scalar>::store(World& world) const {
  world.time = time_;
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    Connector& connector = world.connectors[i];
    const PointMotion end = motion_of(ends_[i], time_);
    connector.position[0] = end.position;
    connector.velocity[0] = end.velocity;
    for (std::size_t k = 0; k < links_; ++k) {
      Vec3 unit, rate;
      for (int c = 0; c < 3; ++c) {
        const auto row = static_cast<std::size_t>(c);
        unit[c] = number(i, batch::kDirection + row, k);
        rate[c] = number(i, batch::kRate + row, k);
      }
      unit.normalize();  // a float's rounding
      rate -= rate.dot(unit) * unit;
      connector.position[k + 1] = connector.position[k] + connector.rest[k] * unit;
      connector.velocity[k + 1] = connector.velocity[k] + connector.rest[k] * rate;
    }
  }
  place_held(world, time_);
}

template class Batch<float>;
template class Batch<double>;

}  // namespace taut::batch
