// What both of MuJoCo's methods have: models in its own language, and where they become unstable.
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <memory>
#include <string>

#include "sim/run/method.h"

namespace taut::engines {

struct DeleteMuJoCo {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using MuJoCoModel = std::unique_ptr<mjModel, DeleteMuJoCo>;
using MuJoCoData = std::unique_ptr<mjData, DeleteMuJoCo>;

/// A constraint as stiff as MuJoCo lets a step be (two of them).
inline constexpr const char* kStiffContact = "solref='1e-9 1' solimp='0.99 0.9999 1e-6'";

/// The same of a tendon's limit.
inline constexpr const char* kStiffLimit = "solreflimit='1e-9 1' solimplimit='0.99 0.9999 1e-6'";

SettingInfo mujoco_integrator();

/// Throws Diverged with MuJoCo's complaint.
MuJoCoModel compile_model(const std::string& xml);

/// Throws Diverged where the step at `time` (s) became unstable.
void check_finite(const mjData& data, double time, std::uint64_t step);

}  // namespace taut::engines
