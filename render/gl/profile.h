// Where a frame's time goes.
#pragma once

#include <string>
#include <vector>

namespace taut::gl {

/// CPU and wall times of the stages that frames go through, one after another.
class Profile {
 public:
  /// Times of one frame, s. CPU time is that of all threads.
  struct Times {
    double cpu = 0, wall = 0;
  };
  struct Stage {
    std::string name;
    std::vector<Times> frames;
  };

  /// Begins to measure: the time since the last lap is nobody's.
  void start();
  /// Ends a stage: the time since `start` or the last lap is its time in one more frame.
  void lap(const char* stage);

  const std::vector<Stage>& stages() const { return stages_; }

 private:
  std::vector<Stage> stages_;
  Times last_;
};

/// The median over frames, of CPU and wall time each on its own.
Profile::Times median(const Profile::Stage& stage);

}  // namespace taut::gl
