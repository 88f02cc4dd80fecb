// The pages that studies write: one file each, with the charts drawn into it.
#pragma once

#include <string>

#include "render/chart.h"

namespace taut::cli {

/// The chart as an element of a page.
std::string inline_svg(const Chart& chart);

/// A page of that title, which is its first heading too, and `body`. It needs no other file.
std::string html_page(const std::string& title, const std::string& body);

}  // namespace taut::cli
