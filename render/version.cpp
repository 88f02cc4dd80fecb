#include "render/version.h"

namespace taut {

const char* version() {
  return TAUT_VERSION;
}

}  // namespace taut
