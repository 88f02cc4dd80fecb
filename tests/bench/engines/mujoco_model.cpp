#include "tests/bench/engines/mujoco_model.h"

#include <cstring>

namespace taut::engines {

SettingInfo mujoco_integrator() {
  return {.name = "integrator",
          .meaning = "Semi-implicit Euler, implicit in velocity, or Runge-Kutta.",
          .unit = "",
          .fallback = std::string("Euler"),
          .choices = {"Euler", "implicit", "RK4"},
          .sweep = {std::string("Euler"), std::string("implicit"), std::string("RK4")}};
}

MuJoCoModel compile_model(const std::string& xml) {
  mju_user_warning = [](const char*) {};  // it would keep a log in the working directory
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  constexpr const char* kName = "model.xml";
  mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(xml.size()));
  std::memcpy(files->filedata[mj_findFileVFS(files.get(), kName)], xml.data(), xml.size());
  char error[500] = "";
  MuJoCoModel model(mj_loadXML(kName, files.get(), error, sizeof error));
  mj_deleteVFS(files.get());
  if (!model) throw Diverged("mujoco", 0, 0, "", 0, std::string(error, std::strcspn(error, "\n")));
  return model;
}

void check_finite(const mjData& data, double time, std::uint64_t step) {
  // MuJoCo goes on from the start where it became unstable.
  for (const int trouble : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC}) {
    if (data.warning[trouble].number == 0) continue;
    throw Diverged("mujoco", time, step, "", 0, "not finite");
  }
}

}  // namespace taut::engines
