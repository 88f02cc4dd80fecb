#include "render/export/gltf/curve_fit.h"

namespace taut::exporting {

HermiteWeights hermite_weights(double u, double span) {
  const double v = 1 - u;
  return {v * v * (1 + 2 * u), span * u * v * v, -span * u * u * v, u * u * (3 - 2 * u)};
}

}  // namespace taut::exporting
