#include "render/base/version.h"

namespace taut::render {

const char* version() {
  return TAUT_VERSION;
}

}  // namespace taut::render
