#include "sim/interventions/outcome.h"

namespace taut {

std::string_view words(Outcome outcome) {
  switch (outcome) {
    case Outcome::done:
      return "done";
    case Outcome::no_connector:
      return "there is no such connector";
    case Outcome::outside:
      return "the place is not on the connector";
    case Outcome::no_target:
      return "what should hold it does not exist";
    case Outcome::held_there:
      return "the connector is held there already";
    case Outcome::joined_there:
      return "the connector is joined there, expected a place beside the joint";
    case Outcome::out_of_reach:
      return "it is farther from another hold than the connector is long between them";
    case Outcome::too_near:
      return "it is nearer to another hold than the links between them can fold";
    case Outcome::no_pin:
      return "there is no such pin, or it is released already";
    case Outcome::has_winch:
      return "the connector has a winch or passes a pulley, expected one that keeps its length";
  }
  return "";
}

}  // namespace taut
