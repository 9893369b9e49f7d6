// A wall that faces the camera, +z, left of the middle; nothing right of it.
#pragma once

#include "tests/support/test_scenes.h"

namespace qray::test {

struct Wall {
  std::shared_ptr<const PreparedScene> scene;
  RenderSettings settings;

  Wall() {
    Scene wall;
    wall.name = "wall";
    add_quad(wall, add_material(wall, Rgb{0.7f}, Rgb{1.0f}), {-2, -2, 0}, {2, 0, 0}, {0, 4, 0});
    wall.camera.position = {0, 0, 3};
    wall.camera.target = {0, 0, 0};
    scene = prepare(wall);
    settings.width = 40;
    settings.height = 30;
  }
};

}  // namespace qray::test
