// SPDX-License-Identifier: Apache-2.0
// Parses the values of multum-view's options. The values have the same form on command lines and in scene plans. Each
// function throws Error(kUsage) that names `option`, the value found and the value expected.
#pragma once

#include <CLI/CLI.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/foundation/base/choices.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/render/reference_sampling.h"
#include "runtime_gl/render/scene.h"

namespace multum {

struct CameraPlace {
  glm::vec3 eye, target;
  std::optional<float> fov_y_degrees;  // 1..170; unchanged if not set
};

struct PictureSize {
  int width = 640;
  int height = 480;
};

extern const Choices<gl::MomentShading> kMomentShadings;
extern const Choices<gl::EnvironmentMode> kEnvironmentModes;
extern const Choices<gl::LobeFormula> kLobeFormulas;
extern const Choices<gl::PixelFilter> kPixelFilters;
extern const Choices<gl::NormalMaterial::Sampling> kReferenceTexels;

/// Throws Error(kUsage), as in "--size '640x': expected ...".
[[noreturn]] void refuse_value(const std::string& option, const std::string& found, const std::string& expected);

glm::vec3 parse_colour(const std::string& option, const std::string& text);
gl::Light parse_light(const std::string& option, const std::string& text);
gl::PointLight parse_point_light(const std::string& option, const std::string& text);
CameraPlace parse_camera(const std::string& option, const std::string& text);
/// Returns a unit vector.
glm::vec3 parse_up(const std::string& option, const std::string& text);
PictureSize parse_size(const std::string& option, const std::string& text);
/// Parses factors of a camera's distance. Each factor may occur only once, because files are named after the factors.
std::vector<float> parse_distances(const std::string& option, const std::string& text);
/// Parses the pictures that --compare draws. Each picture may occur only once, because two pictures with the same name
/// would be written to the same file.
std::vector<std::string> parse_compared(const std::string& option, const std::string& text);
/// Parses lookups of a pyramid. Each may occur only once. Puts the reference first, because the others are compared
/// with it.
std::vector<std::string> parse_lookups(const std::string& option, const std::string& text);

/// Returns a range check that refuses "nan", which CLI11's own check accepts.
CLI::Validator number_in(float low, float high);

}  // namespace multum
