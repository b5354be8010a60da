// SPDX-License-Identifier: Apache-2.0
// traced_folder FOLDER VIEWS LIGHTS: writes the ray-traced pictures of tests/cli/traced_scene.h for Python tests.
#include <cstdio>
#include <cstdlib>

#include "tests/cli/traced_scene.h"

int main(int count, char** words) {
  if (count != 4) {
    std::fputs("traced_folder: expected FOLDER VIEWS LIGHTS\n", stderr);
    return 2;
  }
  multum::testing::TracedScene scene;
  scene.views = std::atoi(words[2]);
  scene.lights = std::atoi(words[3]);
  multum::testing::write_traced_folder(words[1], scene);
}
