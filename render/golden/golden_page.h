// The page on which a person looks at golden pictures that no longer match.
#pragma once

#include <span>
#include <string>

namespace taut::golden {

/// One picture that differs. NAME/actual.png, NAME/golden.png and NAME/difference.png lie beside
/// the page.
struct GoldenFailure {
  std::string name;     // letters, digits, _ and -
  std::string verdict;  // one sentence
  bool pictures = true;
};

/// One HTML file without scripts from elsewhere: each picture with a slider between golden and
/// actual, a blink view, and the amplified difference.
std::string golden_page(std::span<const GoldenFailure> failures);

}  // namespace taut::golden
