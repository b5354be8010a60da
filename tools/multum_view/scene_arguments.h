// SPDX-License-Identifier: Apache-2.0
// `--scene plan.json --object NAME`: the options that draw an object of a scene as `multum bake scene.toml` left it.
#pragma once

#include <string>
#include <vector>

namespace multum {

/// A command line, the program's name first, with the plan's options in the place of --scene and --object; what is
/// given besides comes last, so that it is taken where an option may be given once, and other lights are added. Without
/// --scene, unchanged. Throws Error(kInput) for a file that is no plan, Error(kUsage) for an object that it has not.
std::vector<std::string> with_scene(const std::vector<std::string>& arguments);

}  // namespace multum
