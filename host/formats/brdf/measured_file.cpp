// SPDX-License-Identifier: Apache-2.0
#include "host/formats/brdf/measured_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <numbers>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "host/formats/brdf/measured_factors.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/regular_file.h"
#include "host/foundation/base/leading_number.h"

namespace multum {
namespace {

constexpr std::uintmax_t kTextBytesMax = std::uintmax_t{256} << 20;

// ---- text files ----

// The CIE 1931 colour matching functions as sums of lobes (Wyman, Sloan and Shirley 2013).
double lobe(double x, double mean, double below, double above) {
  const double t = (x - mean) * (x < mean ? below : above);
  return std::exp(-0.5 * t * t);
}
glm::dvec3 colour_matching(double nm) {
  return {1.056 * lobe(nm, 599.8, 0.0264, 0.0323) + 0.362 * lobe(nm, 442.0, 0.0624, 0.0374) -
              0.065 * lobe(nm, 501.1, 0.0490, 0.0382),
          0.821 * lobe(nm, 568.8, 0.0213, 0.0247) + 0.286 * lobe(nm, 530.9, 0.0613, 0.0322),
          1.217 * lobe(nm, 437.0, 0.0845, 0.0278) + 0.681 * lobe(nm, 459.0, 0.0385, 0.0725)};
}

glm::dvec3 linear_srgb(const glm::dvec3& xyz) {
  return {3.2406 * xyz.x - 1.5372 * xyz.y - 0.4986 * xyz.z, -0.9689 * xyz.x + 1.8758 * xyz.y + 0.0415 * xyz.z,
          0.0557 * xyz.x - 0.2040 * xyz.y + 1.0570 * xyz.z};
}

// Converts spectra to colours. A flat spectrum of 1 gives white, (1, 1, 1).
class SpectrumColour {
 public:
  explicit SpectrumColour(const std::vector<double>& wavelengths) {
    for (const double nm : wavelengths) matching_.push_back(colour_matching(nm));
    glm::dvec3 sum(0.0);
    for (const glm::dvec3& m : matching_) sum += m;
    white_ = linear_srgb(sum);
  }
  bool is_usable() const { return white_.x > 0.0 && white_.y > 0.0 && white_.z > 0.0; }
  glm::dvec3 operator()(const std::vector<double>& values) const {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < values.size(); ++i) sum += values[i] * matching_[i];
    return glm::max(linear_srgb(sum) / white_, glm::dvec3(0.0));
  }

 private:
  std::vector<glm::dvec3> matching_;
  glm::dvec3 white_;
};

glm::dvec3 direction(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

// Returns every number in the text, without comments.
std::vector<double> numbers_of(const std::string& path, const std::string& text) {
  std::vector<double> numbers;
  std::istringstream lines(text);
  int row = 0;
  for (std::string line; std::getline(lines, line);) {
    ++row;
    std::istringstream words(line.substr(0, line.find('#')));
    for (std::string word; words >> word;) {
      std::string_view rest;
      const std::optional<double> value = leading_number(word, &rest);
      if (!value || !rest.empty() || !std::isfinite(*value))
        refuse_file(
            path,
            fmt::format("line {}: expected numbers, or comments that begin with #; this is not a measured BRDF", row));
      numbers.push_back(*value);
    }
  }
  return numbers;
}

void read_text(const std::string& path, const std::string& text, BrdfCells& cells) {
  const std::vector<double> numbers = numbers_of(path, text);
  const double first = numbers.empty() ? 0.0 : numbers[0];
  if (first < 3.0 || first > 1000.0 || first != std::floor(first))
    refuse_file(path, fmt::format("found {} wavelengths, expected 3 to 1000", first));
  const auto count = static_cast<std::size_t>(first);
  const std::size_t width = 4 + count;
  if (numbers.size() < 1 + count + width || (numbers.size() - 1 - count) % width != 0)
    refuse_file(path, fmt::format("found {} numbers after {} wavelengths, expected rows of {}",
                                  numbers.size() - std::min(numbers.size(), 1 + count), count, width));
  const std::vector<double> wavelengths(numbers.begin() + 1, numbers.begin() + 1 + static_cast<std::ptrdiff_t>(count));
  const SpectrumColour colour(wavelengths);
  if (!colour.is_usable())
    refuse_file(path, "the wavelengths do not cover red, green and blue, expected 400 to 700 nm");
  std::vector<double> values(count);
  for (std::size_t i = 1 + count; i < numbers.size(); i += width) {
    double theta_h = 0.0, theta_d = 0.0;
    half_angles(direction(numbers[i], numbers[i + 1]), direction(numbers[i + 2], numbers[i + 3]), &theta_h, &theta_d);
    for (std::size_t k = 0; k < count; ++k) values[k] = numbers[i + 4 + k];
    cells.add(theta_h, theta_d, colour(values));
  }
}

// ---- formats in half and difference angles ----

constexpr int kThetaCount = 90, kPhiCount = 180;

// Returns whether both directions are above the horizon.
bool is_above(double theta_h, double theta_d, double phi_d) {
  const glm::dvec3 d = direction(theta_d, phi_d), h = direction(theta_h, 0.0);
  // Rotating d by theta_h about y gives the light's direction.
  const glm::dvec3 l(std::cos(theta_h) * d.x + std::sin(theta_h) * d.z, d.y,
                     -std::sin(theta_h) * d.x + std::cos(theta_h) * d.z);
  return l.z > 0.0 && 2.0 * glm::dot(h, l) * h.z - l.z > 0.0;
}

double merl_theta_h(int i) {
  const double x = (i + 0.5) / kThetaCount;
  return 0.5 * std::numbers::pi * x * x;
}

constexpr std::size_t kMerlCount = std::size_t{kThetaCount} * kThetaCount * kPhiCount;
constexpr std::uintmax_t kMerlBytes = 12 + 3 * sizeof(double) * kMerlCount;

void read_merl(const std::string& path, std::istream& in, BrdfCells& cells) {
  std::vector<double> values(3 * kMerlCount);
  in.seekg(12);
  if (!in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(double))))
    refuse_file(path, "cannot be read");
  const glm::dvec3 scale(1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0);
  for (int h = 0; h < kThetaCount; ++h)
    for (int d = 0; d < kThetaCount; ++d)
      for (int p = 0; p < kPhiCount; ++p) {
        const std::size_t i = static_cast<std::size_t>(p + kPhiCount * (d + kThetaCount * h));
        const glm::dvec3 rho(values[i], values[i + kMerlCount], values[i + 2 * kMerlCount]);
        const double theta_d = 0.5 * std::numbers::pi * (d + 0.5) / kThetaCount,
                     phi = std::numbers::pi * (p + 0.5) / kPhiCount;
        if (!(rho.x >= 0.0 && rho.y >= 0.0 && rho.z >= 0.0) || !std::isfinite(rho.x + rho.y + rho.z)) continue;
        if (is_above(merl_theta_h(h), theta_d, phi)) cells.add(merl_theta_h(h), theta_d, rho * scale);
      }
}

using Layer = std::vector<std::vector<double>>;  // rows of the kernel, followed by the bias

std::vector<Layer> network_layers(const std::string& path, const nlohmann::json& file) {
  std::vector<Layer> layers;
  std::size_t width = 6;
  for (const nlohmann::json& json : file.at("layers")) {
    Layer layer = json.at("kernel").get<Layer>();
    layer.push_back(json.at("bias").get<std::vector<double>>());
    const std::size_t next = layer.back().size();
    bool good = layer.size() == width + 1 && next >= 1 && next <= 1024;
    for (const std::vector<double>& row : layer) good = good && row.size() == next;
    if (!good)
      refuse_file(
          path, fmt::format("layer {}: expected a kernel of {} rows, each as long as the bias", layers.size(), width));
    layers.push_back(std::move(layer));
    width = next;
  }
  if (layers.empty() || width != 3)
    refuse_file(path, fmt::format("found {} outputs, expected red, green and blue", width));
  return layers;
}

glm::dvec3 evaluate(const std::vector<Layer>& layers, std::vector<double> x) {
  for (std::size_t k = 0; k < layers.size(); ++k) {
    const Layer& layer = layers[k];
    std::vector<double> y = layer.back();
    for (std::size_t i = 0; i < x.size(); ++i)
      for (std::size_t j = 0; j < y.size(); ++j) y[j] += x[i] * layer[i][j];
    for (double& value : y) value = k + 1 < layers.size() ? std::max(value, 0.0) : std::max(std::expm1(value), 0.0);
    x = std::move(y);
  }
  return {x[0], x[1], x[2]};
}

void read_network(const std::string& path, const std::string& text, BrdfCells& cells) {
  std::vector<Layer> layers;
  try {
    refuse_nul(text, path);
    layers = network_layers(path, nlohmann::json::parse(text));
  } catch (const nlohmann::json::exception& error) {
    refuse_file(path, std::string("expected JSON with layers, each with a kernel and a bias: ") + error.what());
  }
  constexpr int kAzimuths = 12;
  for (int row = 0; row < kFacetTableSize; ++row)
    for (int column = 0; column < kDifferenceTableSize; ++column)
      for (int p = 0; p < kAzimuths; ++p) {
        const double x = static_cast<double>(row) / (kFacetTableSize - 1),
                     phi = std::numbers::pi * (p + 0.5) / kAzimuths;
        const double theta_h = 0.5 * std::numbers::pi * x * x,
                     theta_d = 0.5 * std::numbers::pi * column / (kDifferenceTableSize - 1);
        if (!is_above(theta_h, theta_d, phi)) continue;
        const glm::dvec3 h = direction(theta_h, 0.0), d = direction(theta_d, phi);
        const glm::dvec3 rho = evaluate(layers, {h.x, h.y, h.z, d.x, d.y, d.z});
        if (!std::isfinite(rho.x + rho.y + rho.z)) refuse_file(path, "the network's output is not finite");
        cells.add(theta_h, theta_d, rho);
      }
}

}  // namespace

MeasuredBrdf read_measured_brdf(const std::string& path) {
  RegularFileStream in(path);
  const auto size = in.seekg(0, std::ios::end) ? static_cast<std::uintmax_t>(std::streamoff(in.tellg())) : 0;
  if (size < 12) refuse_file(path, "no such file, or not a measured BRDF");
  in.seekg(0);
  std::array<std::int32_t, 3> sizes{};
  in.read(reinterpret_cast<char*>(sizes.data()), sizeof(sizes));
  BrdfCells cells;
  if (sizes == std::array<std::int32_t, 3>{kThetaCount, kThetaCount, kPhiCount}) {
    if (size != kMerlBytes)
      refuse_file(path,
                  fmt::format("is incomplete: it has {} bytes, expected {} for the MERL format", size, kMerlBytes));
    read_merl(path, in, cells);
    return cells.factor(path);
  }
  if (size > kTextBytesMax) refuse_file(path, "is larger than 256 MiB, expected a text file of samples or a network");
  in.seekg(0);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin != std::string::npos && text[begin] == '{') read_network(path, text, cells);
  else read_text(path, text, cells);
  return cells.factor(path);
}

}  // namespace multum
