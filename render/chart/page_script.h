// The script of a page, in the order in which the page has its parts.
#pragma once

#include <string_view>

namespace taut::chart {

extern const std::string_view kPageHelpers;
extern const std::string_view kPanelScript;
extern const std::string_view kPageScript;

}  // namespace taut::chart
