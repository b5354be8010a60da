// SPDX-License-Identifier: Apache-2.0
// Gives access to the files that `multum shaders` writes. The build embeds these files in the program.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace multum {

/// Returns the shading of lobes in every language, by file name. tools/shading_languages.py makes the files.
const std::map<std::string, std::string_view>& shading_files();

/// Returns the GLSL that fetches lobes from textures of `multum export --lobes`, by path in runtime_gl/shaders.
const std::map<std::string, std::string_view>& lobe_texture_shaders();

/// Returns the files of the npm package @multum/three except multum_lobes.js, by file name.
const std::map<std::string, std::string_view>& three_package_files();

}  // namespace multum
