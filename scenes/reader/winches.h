// Winches of a scene.
#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "scenes/format/document.h"
#include "scenes/scene/scene.h"

namespace taut::scenes {

/// Lengths (m) over time from keys of `key`, or of a speed (m/s); zero and at rest at the start.
std::shared_ptr<const Path> read_length_keys(const Document& document, const Value& list,
                                             std::string_view key);
/// Fails at `key` where winches whose lengths are all known take in more than the links have.
void check_least(const Document& document, const Value& key, const Winch& winch);
/// The paths of the winches at the first end of `first` and the last of `last`, once those have
/// their holds; null where there is none.
std::array<std::shared_ptr<const Path>, 2> read_winches(const Document& document,
                                                        const Value& value, const World& world,
                                                        const Connector& first,
                                                        const Connector& last);
/// The winches at a connector's ends, once it has its holds. Throws BadScene.
void read_winches(const Document& document, const Value& value, const World& world,
                  Connector& connector);
}  // namespace taut::scenes
