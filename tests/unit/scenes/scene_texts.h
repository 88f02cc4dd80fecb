// Scenes that are written as text, and what is said against them.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "scenes/files/error.h"
#include "scenes/load/load_scene.h"
#include "tests/support/folder.h"

namespace taut {

class SceneTexts : public testing::Test {
 protected:
  scenes::Scene read(const std::string& text, bool staged = false) const {
    return scenes::load_scene(folder_.write("scene.toml", text), staged);
  }
  std::string said(const std::string& text) const {
    try {
      read(text);
    } catch (const scenes::BadScene& error) {
      return error.what();
    }
    return "nothing";
  }
  void expect(const std::string& text, const std::string& words) const {
    const std::string message = said(text);
    EXPECT_NE(message.find("scene.toml:"), std::string::npos) << message;
    EXPECT_NE(message.find(words), std::string::npos) << message;
  }

  Folder folder_;
};

}  // namespace taut
