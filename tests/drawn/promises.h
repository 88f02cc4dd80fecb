// What every scene may expect of every method that takes it, whoever drew it.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace taut::drawn {

struct Broken {
  std::string method, promise, what;
};

struct Verdict {
  std::string refusal;  // by the reader; empty: it took the scene
  std::vector<Broken> broken;
  int runs = 0;      // of methods
  int diverged = 0;  // of them, that ended with a message
  int compared = 0;  // with the truth
};

/// Each run has a process of its own, so that one that crashes or does not end is told of as well.
/// The promises, with their names:
/// ends: within 5 s of CPU time and 1 GB, with no fault and by no error but Diverged.
/// finite: every place and velocity of every frame.
/// continuous: between two frames nothing goes farther than three times the greatest speed.
/// same: a second run has the same bits.
/// And of `direct` and `truth`:
/// follows: to the end, unless places that are held leave the links between them no motion.
/// stretch: links keep their length to 1e-6 of it.
/// energy: a closed scene without pins and cuts gains no more than the error that is claimed lets
/// in. error (direct): up to where the motion can be foretold, within 3 tolerances of the truth. Of
/// one method alone where it is named.
Verdict check_promises(const std::string& scene, const std::string& only = {});

}  // namespace taut::drawn
