// Faults of scenes: what is changed in the good scene, and what the message must say.
#pragma once

#include <string>
#include <vector>

namespace taut {

struct SceneFault {
  std::string name;        // in a few words
  std::string good;        // text of the good scene
  std::string bad;         // what stands there instead; ^ marks the place that the message names
  std::string says;        // a part of the message
  std::string place = {};  // line:column, where it is not in `bad`
};

inline std::vector<SceneFault> scene_faults() {
  const std::string keys =
      "keys = [\n  { t = 0.0, position = [0.0, 1.0, 0.0], rotation = [1, 0, 0, 0] },\n  { t = 0.5, "
      "position = [0.2, 1.0, 0.0], axis = [0, 1, 0], hold = 0.1 },\n]";
  return {
      {"misspelt key", "mass = 0.12", "^mas = 0.12", "did you mean \"mass\"?"},
      {"misspelt table", "[connectors.chain]", "[^connector.chain]",
       "did you mean \"connectors\"?"},
      {"key unlike any", "fps = 60", "^colour = 60", "expected one of: schema_version"},
      {"duplicate key", "fps = 60", "fps = 60\nfps = ^30", "fps"},
      {"duplicate table", "[bodies.free]", "^[bodies.held]", "held"},
      {"number as a string", "mass = 0.12", "mass = ^\"heavy\"",
       "found \"heavy\", expected a number above 0 (kg)"},
      {"string as a number", "name = \"impulse\"", "name = ^5", "found 5, expected one of"},
      {"table as a number", "shape = { cylinder = { length = 0.30, diameter = 0.028 } }",
       "shape = ^3", "found 3, expected a table"},
      {"list too short", "gravity = [0.0, -9.81, 0.0]", "gravity = ^[0.0, -9.81]",
       "found a list of 2, expected a list of 3 numbers"},
      {"date", "duration = 1.0", "duration = ^1979-05-27", "found a date"},
      {"nan", "mass = 0.12", "mass = ^nan", "found nan, expected a number above 0"},
      {"infinity", "length = 0.12", "length = ^inf", "found inf"},
      {"infinity in a list", "-9.81", "^-inf", "gravity[1]: found -inf"},
      {"negative mass", "mass = 0.12", "mass = ^-0.1",
       "bodies.held.mass: found -0.1, expected a number above 0"},
      {"zero mass", "mass = 0.12", "mass = ^0.0", "found 0, expected a number above 0"},
      {"massless links", "mass = 0.012", "mass = ^0", "unless model is span"},
      {"negative length", "length = 0.12", "length = ^-0.12",
       "expected a number of at least 0 (m)"},
      {"length zero with many particles", "length = 0.12", "length = ^0", "for 11 particles"},
      {"one particle", "particles = 11", "particles = ^1",
       "expected a whole number from 2 to 100000"},
      {"half a particle", "particles = 11", "particles = ^2.5", "whole number"},
      {"far too many particles", "particles = 11", "particles = ^9000000000", "found 9000000000"},
      {"duration zero", "duration = 1.0", "duration = ^0", "above 0"},
      {"duration missing", "duration = 1.0", "", "duration is missing", "1:1"},
      {"size zero", "size = [480, 270]", "size = [480, ^0]", "size[1]: found 0"},
      {"other version", "schema_version = 1", "schema_version = ^2", "found 2"},
      {"unknown method", "name = \"impulse\"", "name = ^\"impulsive\"",
       "did you mean \"impulse\"?"},
      {"step zero", "step = 0.001", "step = ^0", "found 0"},
      {"negative step", "step = 0.001", "step = ^-0.001", "found -0.001"},
      {"step that does not divide the frame", "step = 0.001", "step = ^0.005",
       "expected a step that divides the frame of 1/60 s, such as 0.00416666666667"},
      {"step longer than a frame", "step = 0.001", "step = ^0.1", "divides the frame"},
      {"setting of another method", "step = 0.001", "^stiffness = 1000.0",
       "is a setting of springs"},
      {"unknown setting", "step = 0.001", "^stepp = 0.001", "did you mean \"step\"?"},
      {"path: time going back", "{ t = 0.5,", "{ t = ^-0.5,", "a time after 0 s"},
      {"path: rotation of length zero", "rotation = [1, 0, 0, 0]", "rotation = ^[0, 0, 0, 0]",
       "quaternion of length 0"},
      {"path: rotation and axis", "axis = [0, 1, 0]", "axis = [0, 1, 0], ^rotation = [1, 0, 0, 0]",
       "only one of: rotation, axis"},
      {"path: no keys", keys, "keys = ^[]", "found a list of 0"},
      {"path: missing file", keys, "file = ^\"no.csv\"", "there is no file \"no.csv\""},
      {"path: circle that starts beside its plane", keys,
       "circle = { centre = [0, 1, 0], start = ^[0.2, 1, 0.1], axis = [0, 0, 1], frequency = 1, "
       "ramp "
       "= 1 }",
       "expected a point beside the centre"},
      {"unknown path", "driven_by = { path = \"hand\" }", "driven_by = { path = ^\"hnad\" }",
       "the name of a path, did you mean \"hand\"?"},
      {"unknown character", "driven_by = { path = \"hand\" }",
       "driven_by = { character = ^\"player\", hand = \"right\" }",
       "the name of a character, the scene has none"},
      {"unknown body", "body = \"free\"", "body = ^\"fre\"", "did you mean \"free\"?"},
      {"unknown connector", "connector = \"chain\"", "connector = ^\"rope\"",
       "the name of a connector of: chain"},
      {"body both driven and hanging", "driven_by = { path = \"hand\" }",
       "driven_by = { path = \"hand\" }\n^hangs = [0, -1, 0]", "stands beside driven_by"},
      {"body without shape", "inertia = [0.001, 0.0001, 0.001]", "",
       "expected one of: shape, inertia", "23:1"},
      {"inertia of no mass", "inertia = [0.001, 0.0001, 0.001]", "inertia = ^[1.0, 0.1, 0.1]",
       "none above the sum of the others"},
      {"hanging in no direction", "hangs = [0.0, -1.0, 0.0]", "hangs = ^[0, 0, 0]",
       "vector of length 0"},
      {"hanging from nothing", "to = { body = \"free\", point = [0.0, 0.15, 0.0] }",
       "to = { free = true }", "no connector holds the body", "26:9"},
      {"driven body thrown", "driven_by = { path = \"hand\" }",
       "driven_by = { path = \"hand\" }\n^velocity = [1, 0, 0]", "needs a free body"},
      {"end held twice", "to = { body = \"free\",", "to = { body = \"free\", ^fixed = [0, 0, 0],",
       "only one of: body, fixed, path, bone, point_mass, free"},
      {"bone of nobody", "to = { body = \"free\", point = [0.0, 0.15, 0.0] }",
       "to = { ^bone = \"Head\" }", "needs character"},
      {"bone of a character that is not there",
       "to = { body = \"free\", point = [0.0, 0.15, 0.0] }",
       "to = { bone = \"Head\", character = ^\"player\" }",
       "the name of a character, the scene has none"},
      {"end on a character at large", "to = { body = \"free\",",
       "to = { body = \"free\", ^character = \"player\",", "needs bone"},
      {"driven by a path's bone", "driven_by = { path = \"hand\" }",
       "driven_by = { path = \"hand\", ^bone = \"Head\" }", "only one of: path, hand, bone"},
      {"end held by nothing", "to = { body = \"free\", point = [0.0, 0.15, 0.0] }", "to = ^{}",
       "expected one of: body, fixed"},
      {"both ends adrift", "from = { body = \"held\", point = [0.0, 0.15, 0.0] }",
       "from = { free = true }", "neither end has a place", "28:1"},
      {"ends too far apart", "start = { direction = [0.0, -1.0, 0.0] }",
       "start = { hanging_to = ^[0.0, 0.0, 0.0] }", "expected at most the length"},
      {"line too short", "start = { direction = [0.0, -1.0, 0.0] }",
       "start = { points = ^[[0, 1.15, 0], [0, 1.1, 0]] }", "has room for 4 of 10 links"},
      {"line that starts elsewhere", "start = { direction = [0.0, -1.0, 0.0] }",
       "start = { points = [[0, 2, 0], [0, 1, 0]] }", "away from where", "32:8"},
      {"pin outside of the connector", "at = 0.06", "at = ^0.2", "at most the length"},
      {"pin after the end", "from = 0.2", "from = ^2.0", "before the end of the scene"},
      {"pin released before it is caught", "until = 0.4", "until = ^0.1", "a time after 0.2 s"},
      {"two pins at one place", "until = 0.4",
       "until = 0.4\n^[[pins]]\nconnector = \"chain\"\nat = 0.06\nfrom = 0.3",
       "held there already, by another pin at that time"},
      {"pin out of reach", "until = 0.4", "until = 0.4\npoint = [9.0, 1.0, 0.0]",
       "with 0.06 m of the connector between them", "36:1"},
      {"cut at an end", "until = 0.4",
       "until = 0.4\n^[[cuts]]\nconnector = \"chain\"\nat = 0.12\nt = 0.3", "at an end"},
      {"cut after the end of the scene", "until = 0.4",
       "until = 0.4\n[[cuts]]\nconnector = \"chain\"\nat = 0.05\nt = ^1.5",
       "before the end of the scene"},
      {"name with a comma", "[bodies.free]", "[bodies.^\"a,b\"]", "letters, digits, _ and -"},
      {"not TOML", "fps = 60", "fps ^60", "not a TOML file"},
      {"not UTF-8", "title = \"Good\"", "title = \"G^o\xff\xfe\"", "not a TOML file"},
      {"zero byte in a text", "title = \"Good\"", "title = ^\"Go\\u0000d\"", "zero byte"},
  };
}

}  // namespace taut
