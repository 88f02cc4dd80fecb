// Pages of one file: no other file, no network; light or dark as the reader has it, from the width
// of a phone on.
#pragma once

#include <string>
#include <string_view>

#include "render/chart/chart.h"

namespace taut::chart {

/// A page of that title, which is its first heading too, and `body`.
std::string html_page(const std::string& title, const std::string& body);

/// The chart as an element of a page, drawn there: its values on hover and by keyboard, series that
/// hide, axes of either kind, zoom, and the commands of points to copy.
std::string html_chart(const Chart& chart);

/// A command of a page, with a button that copies it.
std::string html_command(const std::string& command);

// The script of a page, in the order in which the page has its parts.

extern const std::string_view kPageHelpers;
extern const std::string_view kPanelScript;
extern const std::string_view kPageScript;

}  // namespace taut::chart
