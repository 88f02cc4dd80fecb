// The methods that stand on other libraries join the list when the program starts.
#include "sim/reference/methods.h"
#include "sim/run/method.h"

/// Programs that link this library ask for this name, which takes this file out of the archive.
extern "C" const bool taut_reference_methods = [] {
  using namespace taut::reference;
  taut::add_method(sdfast_method(), "springs");
  taut::add_method(multibody_method(), "springs");
  taut::add_method(truth_method());
  return true;
}();
