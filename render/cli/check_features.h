// The table of methods by features.
#pragma once

#include <string>

namespace taut::cli {

/// Two tables in Markdown: the features that each method follows, and those that it does not follow
/// together.
std::string features_as_markdown();

}  // namespace taut::cli
