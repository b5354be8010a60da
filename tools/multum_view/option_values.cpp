// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/option_values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <set>

#include "host/foundation/base/error.h"

namespace multum {

const Choices<gl::MomentShading> kMomentShadings = {{"toksvig", gl::MomentShading::kToksvig},
                                                    {"lean", gl::MomentShading::kLean},
                                                    {"lean-jacobian", gl::MomentShading::kLeanJacobian}};
const Choices<gl::EnvironmentMode> kEnvironmentModes = {{"sh", gl::EnvironmentMode::kHarmonics},
                                                        {"prefiltered", gl::EnvironmentMode::kPrefiltered}};
const Choices<gl::LobeFormula> kLobeFormulas = {{"product", gl::LobeFormula::kProduct},
                                                {"paper", gl::LobeFormula::kPaper}};
const Choices<gl::PixelFilter> kPixelFilters = {
    {"box", gl::PixelFilter::kBox}, {"tent", gl::PixelFilter::kTent}, {"gaussian", gl::PixelFilter::kGaussian}};
const Choices<gl::NormalMaterial::Sampling> kReferenceTexels = {
    {"nearest", gl::NormalMaterial::Sampling::kNearest},
    {"blended", gl::NormalMaterial::Sampling::kBlended},
    {"interpolated", gl::NormalMaterial::Sampling::kInterpolated}};

void refuse_value(const std::string& option, const std::string& found, const std::string& expected) {
  throw Error(ErrorCode::kUsage, option + " '" + found + "': expected " + expected);
}

namespace {

std::vector<float> parse_numbers(const std::string& option, const std::string& text, const std::string& expected) {
  std::vector<float> numbers;
  for (const std::string& word : CLI::detail::split(text, ',')) {
    float value = 0.0f;
    if (!CLI::detail::lexical_cast(word, value) || !std::isfinite(value)) refuse_value(option, text, expected);
    numbers.push_back(value);
  }
  return numbers;
}

bool is_negative(const glm::vec3& colour) { return colour.x < 0.0f || colour.y < 0.0f || colour.z < 0.0f; }

// Parses a list of words from `known`. Each word may occur only once.
std::vector<std::string> parse_words(const std::string& option, const std::string& text,
                                     const std::vector<std::string>& known) {
  std::vector<std::string> words;
  for (const std::string& word : CLI::detail::split(text, ',')) {
    if (std::find(known.begin(), known.end(), word) == known.end())
      refuse_value(option, text, fmt::format("a list of {}", fmt::join(known, ", ")));
    if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
  }
  return words;
}

}  // namespace

glm::vec3 parse_colour(const std::string& option, const std::string& text) {
  const char* const expected = "one or three numbers >= 0, e.g. 0.5 or 0.8,0.2,0.1";
  const std::vector<float> n = parse_numbers(option, text, expected);
  if (n.size() != 1 && n.size() != 3) refuse_value(option, text, expected);
  const glm::vec3 colour = n.size() == 1 ? glm::vec3(n[0]) : glm::vec3(n[0], n[1], n[2]);
  if (is_negative(colour)) refuse_value(option, text, expected);
  return colour;
}

gl::Light parse_light(const std::string& option, const std::string& text) {
  const char* const expected =
      "x,y,z towards the light, not all 0, then optionally its irradiance, such as 0.3,0.8,0.5,3.14";
  const std::vector<float> n = parse_numbers(option, text, expected);
  if (n.size() != 3 && n.size() != 4) refuse_value(option, text, expected);
  gl::Light light;
  light.direction = {n[0], n[1], n[2]};
  if (!(glm::length(light.direction) > 1e-12f)) refuse_value(option, text, expected);
  if (n.size() == 4) {
    if (n[3] < 0.0f) refuse_value(option, text, expected);
    light.irradiance = glm::vec3(n[3]);
  }
  return light;
}

gl::PointLight parse_point_light(const std::string& option, const std::string& text) {
  const char* const expected = "x,y,z of its position, then its intensity >= 0, grey or r,g,b, such as 0,2,1,3.14";
  const std::vector<float> n = parse_numbers(option, text, expected);
  if (n.size() != 4 && n.size() != 6) refuse_value(option, text, expected);
  gl::PointLight light{{n[0], n[1], n[2]}, n.size() == 4 ? glm::vec3(n[3]) : glm::vec3(n[3], n[4], n[5])};
  if (is_negative(light.intensity)) refuse_value(option, text, expected);
  return light;
}

CameraPlace parse_camera(const std::string& option, const std::string& text) {
  const char* const expected =
      "eye x,y,z, target x,y,z and optionally the vertical field of view in degrees (1..170), such as 0,0,0.3,0,1,0,40";
  const std::vector<float> n = parse_numbers(option, text, expected);
  if (n.size() != 6 && n.size() != 7) refuse_value(option, text, expected);
  CameraPlace place{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, std::nullopt};
  if (n.size() == 7) place.fov_y_degrees = n[6];
  const float fov = place.fov_y_degrees.value_or(gl::Camera{}.fov_y_degrees);
  if (!(glm::length(place.target - place.eye) > 1e-9f) || fov < 1.0f || fov > 170.0f)
    refuse_value(option, text, expected);
  return place;
}

glm::vec3 parse_up(const std::string& option, const std::string& text) {
  const char* const expected = "x,y,z, not all 0: 0,0,1";
  const std::vector<float> n = parse_numbers(option, text, expected);
  if (n.size() != 3) refuse_value(option, text, expected);
  const glm::vec3 up(n[0], n[1], n[2]);
  if (!(glm::length(up) > 1e-12f)) refuse_value(option, text, expected);
  return glm::normalize(up);
}

PictureSize parse_size(const std::string& option, const std::string& text) {
  PictureSize size;
  int used = 0;
  if (std::sscanf(text.c_str(), "%dx%d%n", &size.width, &size.height, &used) != 2 ||
      static_cast<std::size_t>(used) != text.size() || size.width < 1 || size.height < 1)
    refuse_value(option, text, "WIDTHxHEIGHT in pixels, e.g. 640x480");
  return size;
}

std::vector<float> parse_distances(const std::string& option, const std::string& text) {
  const char* const expected = "different factors of the distance of the camera, from 0.01 to 10000, such as 1,5,25";
  const std::vector<float> distances = parse_numbers(option, text, expected);
  std::set<std::string> names;
  for (const float factor : distances)
    if (factor < 0.01f || factor > 1e4f || !names.insert(fmt::format("{:g}", factor)).second)
      refuse_value(option, text, expected);
  return distances;
}

std::vector<std::string> parse_compared(const std::string& option, const std::string& text) {
  std::vector<std::string> names = parse_words(option, text,
                                               {"reference", "mip", "toksvig", "lean", "lean-jacobian", "points",
                                                "toksvig-points", "lean-points", "lean-jacobian-points"});
  std::vector<std::string> once;
  for (const std::string& name : names)
    if (std::find(once.begin(), once.end(), name) == once.end()) once.push_back(name);
  return once;
}

std::vector<std::string> parse_lookups(const std::string& option, const std::string& text) {
  std::vector<std::string> names = parse_words(option, text, {"reference", "nearest", "bilinear", "level", "driver"});
  std::stable_partition(names.begin(), names.end(), [](const std::string& name) { return name == "reference"; });
  return names;
}

CLI::Validator number_in(float low, float high) {
  const std::string range = fmt::format("in [{:g} - {:g}]", low, high);
  return CLI::Validator(
      [=](std::string& text) {
        float value = 0.0f;
        const bool fits = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
        return fits ? std::string() : fmt::format("'{}': expected a number {}", text, range);
      },
      "FLOAT " + range, "");
}

}  // namespace multum
