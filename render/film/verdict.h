// What a comparison says of a method.
#pragma once

#include <cstddef>
#include <string>

namespace taut::film {

/// What is said of a method, in words, and how bad it is.
struct Verdict {
  enum class Grade { kept, off, broken, none };  // none: there is nothing to judge by
  Grade grade = Grade::none;
  std::string text = {};
  std::size_t worst = 0;  // the frame at which it is the farthest off
};

/// The largest error of a method that is right, as a share of what it is measured by: of the energy
/// scale, of the length, of the momentum scale.
inline constexpr double kKept = 0.01;

}  // namespace taut::film
