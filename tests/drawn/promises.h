// The promises of every method to every scene that it takes, whoever drew it.
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
  int ended = 0;     // of them, that came to the end of the scene
  int diverged = 0;  // of them, that ended with a message
  int compared = 0;  // with the truth
  int told = 0;      // of them, where the error is of more than three, as its estimate tells
  int missed = 0;    // of them, where no estimate tells that
};

/// Runs are apart from this process, so that one that crashes or does not end is told of as well.
/// Each has 0.05 s of CPU time; what it has reached by then is judged. The promises, with their
/// names:
/// ends: within its time or else with no slice of 1 ms of the scene that takes more than 5 s;
/// within 1 GB, with no fault and by no error but Diverged. Simbody's steps (`multibody`), which
/// may be as short as they like where links between holds are, have no such end. finite: every
/// place and velocity of every frame. continuous: between two frames nothing goes farther than at
/// three times its greatest speed, unless a pin takes a place at once between them or is released,
/// which lays links straight, or a connector is cut that the method stretches. same: a second run
/// has the same bits. And of `direct` and `truth`: follows: to the end, unless what holds an end, a
/// body for instance, gets into an obstacle, or joined links that are rigid have no room to move,
/// as a net that is flat. stretch: links keep their length to 1e-6 of it. energy: a closed scene
/// without pins and cuts gains no more than the error that is claimed lets in. error (direct,
/// without obstacles): up to where the motion can be foretold, within 10 tolerances of the truth,
/// or of a tolerance grown as the motion has nudges grow where the estimate of the error tells a
/// third of it. Verdict::told counts such errors of more than 3 tolerances, Verdict::missed all
/// others. Where places that are held leave the links between them no motion, at full length or
/// folded, none of follows, stretch and continuous is promised. Of one method alone where it is
/// named.
Verdict check_promises(const std::string& scene, const std::string& only = {});

}  // namespace taut::drawn
