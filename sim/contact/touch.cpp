#include "sim/contact/touch.h"

#include <Eigen/LU>
#include <array>
#include <optional>

namespace taut::contact {
namespace {

constexpr double kParallelNormals = 1e-6;  // of the sine of the angle between two normals
constexpr double kRoundingSlack =
    1e-12;  // of the speeds: by how much a touch may be broken by rounding

struct Found {
  Response response;
  std::array<Touch, 3> touches;
};

/// The bead's velocity without the impulse that the touch has given.
Vec3 without(const Vec3& free, const Touch& touch) {
  return free - touch.pushed - touch.friction_before;
}

void open(Touch& touch) {
  touch.state = Touch::State::open;
  touch.push = 0;
  touch.friction.setZero();
}

/// The one touch closes; none where it would have to pull.
std::optional<Response> close_one(const Vec3& free, Touch& touch, double creep) {
  const Vec3& n = touch.normal;
  const Vec3 frictionless = free - touch.friction_before;
  const double push = n.dot(touch.pushed) + touch.least - n.dot(frictionless);
  if (!(push > 0)) return std::nullopt;
  touch.push = push;
  const Mat3 across = Mat3::Identity() - n * n.transpose();
  const Vec3 slip = across * (frictionless - touch.surface);
  const double speed = slip.norm();
  const Vec3 carried = touch.least * n + across * touch.surface;
  if (speed <= (1 + creep) * friction_of(touch, slip) * push) {
    touch.state = Touch::State::sticks;
    touch.friction = -slip / (1 + creep);
    const double left = creep / (1 + creep);
    return Response{carried + left * slip, left * across};
  }
  touch.state = Touch::State::slides;
  const Vec3 ahead = slip / speed;
  const double kept = 1 - std::min(1.0, touch.slide * push / speed);
  touch.friction = (kept - 1) * slip;
  Response found{carried + kept * slip, kept * across};
  if (kept > 0) {
    found.derivative += (1 - kept) * ahead * ahead.transpose();
    found.derivative += touch.slide * ahead * n.transpose();
  } else {
    found.derivative.setZero();
  }
  return found;
}

/// Two touches close: the bead can only slide along the line that both surfaces share.
std::optional<Response> close_two(const Vec3& free, Touch& a, Touch& b, double creep) {
  const Vec3 line = a.normal.cross(b.normal);
  const double sine = line.norm();
  if (!(sine > kParallelNormals)) return std::nullopt;
  const Vec3 along = line / sine;
  const Vec3 frictionless = free - a.friction_before - b.friction_before;
  Eigen::Matrix<double, 2, 3> normals;
  normals << a.normal.transpose(), b.normal.transpose();
  const Eigen::Matrix2d inverse = (normals * normals.transpose()).inverse();
  const Eigen::Vector2d wanted(a.least, b.least);
  const Vec3 bare = frictionless - a.pushed - b.pushed;
  const Eigen::Vector2d push = inverse * (wanted - normals * bare);
  if (!(push.minCoeff() > 0)) return std::nullopt;
  a.push = push[0];
  b.push = push[1];
  const Vec3 held = normals.transpose() * (inverse * wanted);
  const double carried = along.dot(a.surface + b.surface) / 2;
  const double slip = along.dot(frictionless) - carried;
  const double hold_a = friction_of(a, slip * along) * a.push;
  const double most = hold_a + friction_of(b, slip * along) * b.push;
  if (std::abs(slip) <= (1 + creep) * most) {
    for (Touch* touch : {&a, &b}) {
      touch->state = Touch::State::sticks;
      const double own = touch == &a ? hold_a : most - hold_a;
      const double share = most > 0 ? own / most : 0;
      touch->friction = -share * slip / (1 + creep) * along;
    }
    const double left = creep / (1 + creep);
    return Response{held + (carried + left * slip) * along, left * along * along.transpose()};
  }
  const double way = slip > 0 ? 1 : -1;
  const Eigen::Vector2d slide(a.slide, b.slide);
  const double friction = std::min(std::abs(slip), slide.dot(push));
  for (Touch* touch : {&a, &b}) {
    touch->state = Touch::State::slides;
    touch->friction = -way * touch->slide * touch->push * along;
  }
  Response found{held + (carried + slip - way * friction) * along, Mat3::Zero()};
  if (friction < std::abs(slip)) {
    found.derivative = along * (along.transpose() + way * slide.transpose() * inverse * normals);
  }
  return found;
}

/// A touch that closes, whose friction takes the bead into another surface. Without friction across
/// their common line that surface would have to pull: as much acts as keeps the bead just there.
std::optional<Response> graze(const Vec3& free, Touch& touch, Touch& grazed, double creep) {
  const Vec3& n = touch.normal;
  const Vec3 line = n.cross(grazed.normal);
  const double sine = line.norm();
  if (!(sine > kParallelNormals)) return std::nullopt;
  const Vec3 along = line / sine, across = along.cross(n);
  const Vec3 bare = without(free, touch);
  touch.push = touch.least - n.dot(bare);
  if (!(touch.push > 0)) return std::nullopt;
  const Vec3 pressed = bare + touch.push * n;
  const double aside = (grazed.least - grazed.normal.dot(pressed)) / grazed.normal.dot(across);
  const double slip = along.dot(bare - touch.surface);
  const double way = slip > 0 ? 1 : -1;
  const auto left = [&](double coefficient) {  // of it, along the line
    const double most = coefficient * touch.push;
    return most * most - aside * aside;
  };
  if (!(left(touch.stick) >= 0)) return std::nullopt;
  grazed.state = Touch::State::slides;
  Response found{pressed + aside * across, Mat3::Zero()};
  if (const double most = std::sqrt(left(friction_of(touch, slip * along)));
      std::abs(slip) <= (1 + creep) * most) {
    touch.state = Touch::State::sticks;
    touch.friction = aside * across - slip / (1 + creep) * along;
    found.velocity -= slip / (1 + creep) * along;
    found.derivative = creep / (1 + creep) * along * along.transpose();
    return found;
  }
  touch.state = Touch::State::slides;
  const double friction = std::sqrt(std::max(0.0, left(touch.slide)));
  touch.friction = aside * across - way * friction * along;
  found.velocity -= way * friction * along;
  Vec3 gives = along;
  if (friction > kParallelNormals * touch.push) {
    gives += way / friction * (touch.slide * touch.slide * touch.push * n - aside * across);
  }
  found.derivative = along * gives.transpose();
  return found;
}

/// Three touches close: the bead goes where they do.
std::optional<Response> close_three(const Vec3& free, std::span<Touch> touches) {
  Mat3 normals;
  Vec3 wanted, bare = free;
  for (int i = 0; i < 3; ++i) {
    const Touch& touch = touches[static_cast<std::size_t>(i)];
    normals.row(i) = touch.normal.transpose();
    wanted[i] = touch.least;
    bare = without(bare, touch);
  }
  if (!(std::abs(normals.determinant()) > kParallelNormals)) return std::nullopt;
  const Vec3 velocity = normals.inverse() * wanted;
  const Vec3 push = normals.transpose().inverse() * (velocity - bare);
  if (!(push.minCoeff() > 0)) return std::nullopt;
  for (int i = 0; i < 3; ++i) {
    Touch& touch = touches[static_cast<std::size_t>(i)];
    touch.state = Touch::State::sticks;
    touch.push = push[i];
    touch.friction.setZero();
  }
  return Response{velocity, Mat3::Zero()};
}

/// By how much (m/s) a velocity breaks what the touches ask for.
double broken(const Vec3& velocity, std::span<const Touch> touches) {
  double most = 0;
  for (const Touch& touch : touches) {
    most = std::max(most, touch.least - touch.normal.dot(velocity));
  }
  return most;
}

/// With only the touches closed whose bit is set.
std::optional<Found> closed(const Vec3& free, std::span<const Touch> touches, unsigned which,
                            double creep) {
  Found found;
  Vec3 velocity = free;
  std::array<std::size_t, 3> shut{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    found.touches[i] = touches[i];
    open(found.touches[i]);
    if (which & (1u << i)) {
      shut[count++] = i;
    } else {
      velocity = without(velocity, touches[i]);
    }
  }
  std::optional<Response> response;
  if (count == 0) {
    response = Response{velocity, Mat3::Identity()};
  } else if (count == 1) {
    response = close_one(velocity, found.touches[shut[0]], creep);
  } else if (count == 2) {
    response = close_two(velocity, found.touches[shut[0]], found.touches[shut[1]], creep);
  } else {
    response = close_three(velocity, std::span(found.touches));
  }
  if (!response) return std::nullopt;
  found.response = *response;
  return found;
}

/// With one touch closed and one grazed.
std::optional<Found> grazing(const Vec3& free, std::span<const Touch> touches, std::size_t shut,
                             std::size_t grazed, double creep) {
  Found found;
  Vec3 velocity = free;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    found.touches[i] = touches[i];
    open(found.touches[i]);
    if (i != shut) velocity = without(velocity, touches[i]);
  }
  const auto response = graze(velocity, found.touches[shut], found.touches[grazed], creep);
  if (!response) return std::nullopt;
  found.response = *response;
  return found;
}

}  // namespace

Response respond(const Vec3& free, std::span<Touch> touches, double creep) {
  if (touches.size() == 1) {
    Touch& touch = touches[0];
    const Vec3 away = without(free, touch);
    if (touch.least - touch.normal.dot(away) > kRoundingSlack * (1 + free.norm())) {
      if (const auto closes = close_one(free, touch, creep)) return *closes;
    }
    open(touch);
    return {away, Mat3::Identity()};
  }
  // From few that are closed to many, then with one that is grazed: the first that breaks no touch
  // is it.
  static constexpr std::array<unsigned, 8> kOrder{0, 1, 2, 4, 3, 5, 6, 7};
  double least = std::numeric_limits<double>::infinity();
  Found best;
  best.response.velocity = free;
  const auto fits = [&](const std::optional<Found>& found) {
    if (!found) return false;
    const double wrong = broken(found->response.velocity, touches);
    if (wrong < least) {
      least = wrong;
      best = *found;
    }
    return wrong <= kRoundingSlack * (1 + free.norm());
  };
  const auto search = [&] {
    for (const unsigned which : kOrder) {
      if (!(which >> touches.size()) && fits(closed(free, touches, which, creep))) return;
    }
    for (std::size_t i = 0; i < touches.size(); ++i) {
      for (std::size_t k = 0; k < touches.size(); ++k) {
        if (i != k && fits(grazing(free, touches, i, k, creep))) return;
      }
    }
  };
  search();
  for (std::size_t i = 0; i < touches.size(); ++i) touches[i] = best.touches[i];
  return best.response;
}

}  // namespace taut::contact
