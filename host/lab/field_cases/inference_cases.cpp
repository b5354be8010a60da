// SPDX-License-Identifier: Apache-2.0
// Tests the parts of texture inference: the products and sums of the conjugate gradient method, the interpolation of
// the pyramid, and whole solutions. The systems are singular, empty or weakly regularised, or have a high contrast
// (Hakura et al. 2000, section 3.2). docs/contributing/ALGORITHMS.md lists the rows of the system.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/fields/inference/solver/pyramid_tables.h"
#include "host/fields/inference/solver/texture_inference.h"
#include "host/fields/inference/solver/texture_system.h"
#include "host/formats/opencl/launch_shape.h"
#include "host/foundation/base/split_mix.h"
#include "host/lab/field_cases/field_case_lists.h"
#include "host/lab/field_cases/texture_inference.h"
#include "host/lab/selftest/buffers.h"

namespace multum {
namespace {

// Returns a number with a magnitude from 10^-6 to 1 and a random sign.
float of_great_contrast(SplitMix64& random) {
  const double value = std::pow(10.0, -6.0 * random.uniform());
  return static_cast<float>(random.uniform() < 0.5 ? -value : value);
}

std::vector<Colour4> colours_of_great_contrast(std::size_t count, std::uint64_t seed) {
  SplitMix64 random(seed);
  std::vector<Colour4> list(count);
  for (Colour4& value : list)
    value = {of_great_contrast(random), of_great_contrast(random), of_great_contrast(random), 0.0f};
  return list;
}

// Makes rows with 0 to 21 entries. The first and the last row are empty. Each weight is denormal, or has a magnitude
// from 1e-6 to 1.
SparseRows uneven_rows(std::uint32_t column_count) {
  SplitMix64 random(8);
  SparseRows rows;
  for (const int entries : {0, 8, 0, 1, 21, 8, 0, 0, 3, 16, 0}) {
    for (int i = 0; i < entries; ++i) {
      rows.columns.push_back(static_cast<std::uint32_t>(random.next() % column_count));
      rows.weights.push_back(i % 7 == 6 ? 1e-40f : of_great_contrast(random));
    }
    rows.begin.push_back(static_cast<std::uint32_t>(rows.columns.size()));
  }
  return rows;
}

void empty_and_uneven_rows(Device& device, WorstError& worst) {
  const std::vector<Colour4> x = colours_of_great_contrast(50, 9);
  const SparseRows rows = uneven_rows(50);
  const DeviceRows on_device(device, rows, "rows");
  const DeviceBuffer in = uploaded(device, x, "x");
  DeviceBuffer out =
      uploaded(device, std::vector<Colour4>(rows.row_count(), {kPoison, kPoison, kPoison, kPoison}), "y");
  Kernel kernel = device.kernel("filter_matrix_spmv", "filter_matrix_spmv", {1, 1, false});
  on_device.multiply(kernel, in, out);
  const std::vector<Colour4> found = downloaded<Colour4>(device, out);
  for (std::size_t r = 0; r < rows.row_count(); ++r)
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = 0.0, magnitude = 0.0;
      for (std::uint32_t i = rows.begin[r]; i < rows.begin[r + 1]; ++i) {
        const double product = static_cast<double>(rows.weights[i]) * static_cast<double>(x[rows.columns[i]][c]);
        sum += product;
        magnitude += std::abs(product);
      }
      // Devices are allowed to treat denormal numbers as 0.
      worst.add(static_cast<double>(found[r][c]), sum, magnitude + 1e-30, fmt::format("row {}", r));
    }
}

// Contains `R x` and `R^T R x` for the pyramid of a texture.
struct PyramidProducts {
  std::vector<Colour4> residual, gradient;
};

PyramidProducts pyramid_products(Device& device, const FilterMatrix& texture, const std::vector<Colour4>& x) {
  const MipLayout layout = texture.layout();
  const PyramidTables tables = make_pyramid_tables(layout, texture.wrap_s == WrapMode::kPeriodic,
                                                   texture.wrap_t == WrapMode::kPeriodic, device.shape().strip_texels);
  const DeviceBuffer levels = uploaded(device, tables.levels, "levels"), taps = uploaded(device, tables.taps, "taps"),
                     gathers = uploaded(device, tables.gathers, "gathers"),
                     entries = uploaded(device, tables.entries, "entries"),
                     strips = uploaded(device, tables.strips, "strips"), in = uploaded(device, x, "x");
  const DeviceBuffer residual = uploaded(device, std::vector<Colour4>(x.size(), {kPoison, kPoison, kPoison, kPoison}),
                                         "residual"),
                     gradient = uploaded(device, std::vector<Colour4>(x.size(), {0, 0, 0, 0}), "gradient");
  const auto strip_count = static_cast<int>(tables.strips.size());
  device.kernel("pyramidal_regularization", "pyramid_residual", {1, 1, false})
      .launch({tables.strips.size()}, levels, taps, strips, in, residual, strip_count, layout.level_count());
  device.kernel("pyramidal_regularization", "pyramid_gradient", {1, 1, false})
      .launch({tables.strips.size()}, levels, gathers, entries, strips, residual, gradient, strip_count, 1.0f);
  return {downloaded<Colour4>(device, residual), downloaded<Colour4>(device, gradient)};
}

std::vector<FilterMatrix> odd_textures() {
  std::vector<FilterMatrix> textures;
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 37}, {7, 1}, {13, 9}, {64, 3}, {32, 32}})
    for (const WrapMode wrap : {WrapMode::kClamp, WrapMode::kPeriodic}) {
      textures.emplace_back();
      textures.back().texture_width = width;
      textures.back().texture_height = height;
      textures.back().wrap_s = textures.back().wrap_t = wrap;
    }
  return textures;
}

std::string texture_text(const FilterMatrix& texture) {
  return fmt::format("{} x {}, {}", texture.texture_width, texture.texture_height,
                     texture.wrap_s == WrapMode::kPeriodic ? "periodic" : "clamped");
}

void constant_textures(Device& device, WorstError& worst) {
  for (const FilterMatrix& texture : odd_textures())
    for (const float value : {0.1f, 1e6f, 1e-30f, -0.0f}) {
      const std::vector<Colour4> x(static_cast<std::size_t>(texture.layout().texel_count), {value, value, value, 0.0f});
      for (const Colour4& found : pyramid_products(device, texture, x).residual)
        worst.add(static_cast<double>(found[0]), 0.0, std::max(std::abs(static_cast<double>(value)), 1e-30),
                  fmt::format("{}, value {}", texture_text(texture), value));
    }
}

void odd_pyramids(Device& device, WorstError& worst) {
  for (const FilterMatrix& texture : odd_textures()) {
    const MipLayout layout = texture.layout();
    const auto count = static_cast<std::size_t>(layout.texel_count);
    const std::vector<Colour4> x = colours_of_great_contrast(count, 10);
    std::vector<double> residual(count), gradient(count);
    for (std::size_t t = 0; t < count; ++t) residual[t] = static_cast<double>(x[t][0]);
    const auto entries = reference::interpolation(texture);
    for (const reference::InterpolationEntry& e : entries)
      residual[static_cast<std::size_t>(e.fine)] -=
          e.weight * static_cast<double>(x[static_cast<std::size_t>(e.coarse)][0]);
    residual.back() = 0.0;
    gradient = residual;
    for (const reference::InterpolationEntry& e : entries)
      gradient[static_cast<std::size_t>(e.coarse)] -= e.weight * residual[static_cast<std::size_t>(e.fine)];
    const PyramidProducts found = pyramid_products(device, texture, x);
    for (std::size_t t = 0; t < count; ++t) {
      const std::string input = fmt::format("{}, texel {}", texture_text(texture), t);
      worst.add(static_cast<double>(found.residual[t][0]), residual[t], 1.0, input);
      worst.add(static_cast<double>(found.gradient[t][0]), gradient[t], 1.0, input);
    }
  }
}

// Tests a number of texels and a number of parts whose product exceeds 2^31.
void products_of_many_parts(Device& device, WorstError& worst) {
  constexpr std::size_t kTexels = 1 << 18, kParts = 1 << 14;
  const std::vector<Colour4> p = colours_of_great_contrast(kTexels, 11), q = colours_of_great_contrast(kTexels, 12);
  const DeviceBuffer pb = uploaded(device, p, "p"), qb = uploaded(device, q, "q"),
                     unused = uploaded(device, std::vector<Colour4>(1), "unused"),
                     parts =
                         uploaded(device, std::vector<Colour4>(kParts, {kPoison, kPoison, kPoison, kPoison}), "parts");
  device.kernel("conjugate_gradient", "curvature_product", {1, 1, false})
      .launch({kParts, 16}, pb, qb, unused, unused, parts, 0, static_cast<int>(kTexels), static_cast<int>(kParts));
  std::array<double, 3> found = {0.0, 0.0, 0.0}, exact = {0.0, 0.0, 0.0}, magnitude = {0.0, 0.0, 0.0};
  for (const Colour4& part : downloaded<Colour4>(device, parts))
    for (std::size_t c = 0; c < 3; ++c) found[c] += static_cast<double>(part[c]);
  for (std::size_t t = 0; t < kTexels; ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const double product = static_cast<double>(p[t][c]) * static_cast<double>(q[t][c]);
      exact[c] += product;
      magnitude[c] += std::abs(product);
    }
  for (std::size_t c = 0; c < 3; ++c) worst.add(found[c], exact[c], magnitude[c], fmt::format("colour {}", c));
}

// Tests a launch with more parts than texels. The result of a part without texels must be 0.
void parts_without_texels(Device& device, WorstError& worst) {
  constexpr std::size_t kParts = 64;
  for (const std::size_t texels : {1u, 3u, 63u}) {
    const std::vector<Colour4> r = colours_of_great_contrast(texels, 13), q = colours_of_great_contrast(texels, 14);
    const std::vector<Colour4> inverse(texels, {1e6f, 0.0f, 1e-6f, 0.0f});
    const DeviceBuffer rb = uploaded(device, r, "r"), qb = uploaded(device, q, "q"),
                       inverses = uploaded(device, inverse, "inverse"),
                       parts = uploaded(device, std::vector<Colour4>(2 * kParts, {kPoison, kPoison, kPoison, kPoison}),
                                        "parts");
    const Colour4 alpha = {0.5f, 1e-6f, 1e3f, 0.0f};
    device.kernel("conjugate_gradient", "advance_residual", {1, 1, false})
        .launch({kParts, 1}, rb, qb, inverses, parts, alpha, static_cast<int>(texels), static_cast<int>(kParts));
    const std::vector<Colour4> found = downloaded<Colour4>(device, parts);
    for (std::size_t c = 0; c < 3; ++c) {
      double product = 0.0, norm = 0.0, product_found = 0.0, norm_found = 0.0;
      for (std::size_t t = 0; t < texels; ++t) {
        const double residual =
            static_cast<double>(r[t][c]) - static_cast<double>(alpha[c]) * static_cast<double>(q[t][c]);
        product += static_cast<double>(inverse[t][c]) * residual * residual;
        norm += residual * residual;
      }
      for (std::size_t part = 0; part < kParts; ++part) {
        product_found += static_cast<double>(found[part][c]);
        norm_found += static_cast<double>(found[kParts + part][c]);
      }
      worst.add(product_found, product, std::max(product, 1e-30), fmt::format("{} texels, colour {}", texels, c));
      worst.add(norm_found, norm, std::max(norm, 1e-30), fmt::format("{} texels, colour {}", texels, c));
    }
  }
}

// Tests steps of high contrast next to fixed texels, for which inverse and beta are 0. Also tests denormal numbers and
// signed zeros.
void steps_along_the_old_direction(Device& device, WorstError& worst) {
  for (const std::size_t texels : {1u, 7u, 1001u}) {
    const std::vector<Colour4> step = colours_of_great_contrast(texels, 16), p = colours_of_great_contrast(texels, 17),
                               r = colours_of_great_contrast(texels, 18);
    std::vector<Colour4> inverse(texels);
    for (std::size_t t = 0; t < texels; ++t) inverse[t] = {1e6f, t % 3 == 0 ? 0.0f : 1e-3f, 1e-40f, -0.0f};
    const Colour4 alpha = {0.5f, 1e-6f, 1e3f, 0.0f}, beta = {1e6f, 0.0f, -0.0f, 1.0f};
    const DeviceBuffer steps = uploaded(device, step, "step"), directions = uploaded(device, p, "p"),
                       residuals = uploaded(device, r, "r"), inverses = uploaded(device, inverse, "inverse");
    device.kernel("conjugate_gradient", "advance_direction", {1, 1, false})
        .launch({texels, 64}, steps, directions, residuals, inverses, alpha, beta, static_cast<int>(texels));
    const std::vector<Colour4> found_step = downloaded<Colour4>(device, steps),
                               found_p = downloaded<Colour4>(device, directions);
    for (std::size_t t = 0; t < texels; ++t)
      for (std::size_t c = 0; c < 4; ++c) {
        const auto wide = [](float value) { return static_cast<double>(value); };
        const double from = wide(step[t][c]), along = wide(alpha[c]) * wide(p[t][c]);
        const double down = wide(inverse[t][c]) * wide(r[t][c]), kept = wide(beta[c]) * wide(p[t][c]);
        const std::string input = fmt::format("{} texels, texel {}, colour {}", texels, t, c);
        // Allows devices to treat denormal values as 0.
        worst.add(wide(found_step[t][c]), from + along, std::max(std::abs(from) + std::abs(along), 0x1p-100), input);
        worst.add(wide(found_p[t][c]), down + kept, std::max(std::abs(down) + std::abs(kept), 0x1p-100), input);
      }
  }
}

InferenceSettings exact_settings(double pyramid_weight) {
  InferenceSettings settings;
  settings.pyramid_weight = pyramid_weight;
  settings.gradient_tolerance = 1e-6;
  settings.iteration_max = 3000;
  return settings;
}

// Compares the picture of the solution with the requested picture. The texture is random, and the starting values are
// far from the solution. Texels that no pixel reads can have any finite value.
void add_picture_errors(Device& device, const FilterMatrix& matrix, const std::vector<float>& weights,
                        const InferenceSettings& settings, const std::string& input, WorstError& worst) {
  SplitMix64 random(15);
  std::vector<float> texels(3 * static_cast<std::size_t>(matrix.layout().texel_count));
  for (float& value : texels) value = static_cast<float>(0.1 + 0.8 * random.uniform());
  TextureInference inference(device, {{&matrix, weights}}, settings, 1);
  const std::vector<float> asked = inference.picture(texels);
  const InferenceResult result = inference.solve(asked, std::vector<float>(texels.size(), 0.9f));
  for (std::size_t t = 0; t < result.texels.size(); ++t)
    worst.add(0.0 * static_cast<double>(result.texels[t]), fmt::format("{}, texel {}", input, t / 3));
  const std::vector<float> picture = inference.picture(result.texels);
  for (std::size_t i = 0; i < picture.size(); ++i)
    if (weights[i / 3] > 0.0f)
      worst.add(static_cast<double>(picture[i]), static_cast<double>(asked[i]), 1.0,
                fmt::format("{}, pixel {}", input, i / 3));
}

void singular_systems(Device& device, WorstError& worst) {
  for (const InferenceForm form : {InferenceForm::kMatrix, InferenceForm::kNormal}) {
    const FilterMatrix matrix = reference::random_matrix(64, 64, WrapMode::kClamp, 40, 3);
    std::vector<float> weights(matrix.row_count(), 1.0f);
    weights[7] = 0.0f;
    InferenceSettings settings = exact_settings(0.0);
    settings.form = form;
    add_picture_errors(device, matrix, weights, settings, form == InferenceForm::kNormal ? "A^T A" : "A", worst);
  }
}

// Tests a very weak regularisation, in which texels that no pixel reads have a denormal diagonal entry. The inverse of
// such an entry is infinite.
void denormal_diagonals(Device& device, WorstError& worst) {
  const FilterMatrix matrix = reference::random_matrix(32, 32, WrapMode::kClamp, 40, 3);
  for (const double weight : {1e-36, 1e-38, 1e-39, 1e-41, 1e-44})
    add_picture_errors(device, matrix, std::vector<float>(matrix.row_count(), 1.0f), exact_settings(weight),
                       fmt::format("eps {}", weight), worst);
}

// Tests a picture of one colour that shows only the left half of a texture. The right half must also get this colour.
void unseen_texels(Device& device, WorstError& worst) {
  const FilterMatrix matrix = reference::random_matrix(32, 16, WrapMode::kClamp, 3000, 7);
  const MipLayout layout = matrix.layout();
  std::vector<float> weights;
  for (std::size_t r = 0; r < matrix.row_count(); ++r) {
    bool is_left = true;
    for (std::uint32_t i = matrix.row_begin[r]; i < matrix.row_begin[r + 1]; ++i) {
      const MipLevelPlace& level =
          layout.levels[static_cast<std::size_t>(layout.level_of(static_cast<int>(matrix.columns[i])))];
      is_left = is_left && (static_cast<int>(matrix.columns[i]) - level.offset) % level.width < level.width / 2;
    }
    weights.push_back(is_left ? 1.0f : 0.0f);
  }
  TextureInference inference(device, {{&matrix, weights}}, exact_settings(0.1), 1);
  const InferenceResult result =
      inference.solve(std::vector<float>(3 * matrix.row_count(), 0.6f),
                      std::vector<float>(3 * static_cast<std::size_t>(layout.texel_count), 0.1f));
  for (std::size_t t = 0; t < result.texels.size(); ++t)
    worst.add(static_cast<double>(result.texels[t]), static_cast<double>(0.6f), 1.0, fmt::format("texel {}", t / 3));
}

// Infers a texture from pictures of a known texture with nearly no regularisation, and expects the known texture.
void vanishing_regularisation(Device& device, WorstError& worst) {
  const FilterMatrix matrix = reference::random_matrix(8, 8, WrapMode::kClamp, 4000, 3);
  SplitMix64 random(9);
  std::vector<float> texels;
  for (int i = 0; i < 3 * matrix.layout().texel_count; ++i) texels.push_back(static_cast<float>(random.uniform()));
  for (const double weight : {1e-6, 1e-9, 1e-30, 0.0}) {
    InferenceSettings settings = exact_settings(weight);
    settings.range_weight = weight;
    TextureInference inference(device, {{&matrix, std::vector<float>(matrix.row_count(), 1.0f)}}, settings, 1);
    const std::vector<float> found = inference.solve(inference.picture(texels), {}).texels;
    for (std::size_t i = 0; i < 3 * 64; ++i)
      worst.add(static_cast<double>(found[i]), static_cast<double>(texels[i]), 1.0,
                fmt::format("eps {}, texel {}", weight, i / 3));
  }
}

// Tests adjacent texels of 1e-6 and 1, with row weights from 1e-6 to 1. Errors must not exceed the rounding of the
// brightest pixel.
void contrast_in_pixels(Device& device, WorstError& worst) {
  const FilterMatrix matrix = reference::random_matrix(8, 8, WrapMode::kClamp, 4000, 5);
  std::vector<float> texels;
  for (int t = 0; t < matrix.layout().texel_count; ++t)
    for (int c = 0; c < 3; ++c) texels.push_back((t + c) % 2 == 0 ? 1.0f : 1e-6f);
  SplitMix64 random(6);
  std::vector<float> weights;
  for (std::size_t r = 0; r < matrix.row_count(); ++r)
    weights.push_back(static_cast<float>(std::pow(10.0, -6.0 * std::pow(random.uniform(), 4.0))));
  TextureInference inference(device, {{&matrix, weights}}, exact_settings(0.0), 1);
  const std::vector<float> found = inference.solve(inference.picture(texels), {}).texels;
  for (std::size_t i = 0; i < 3 * 64; ++i)
    worst.add(static_cast<double>(found[i]), static_cast<double>(texels[i]), 1.0, fmt::format("texel {}", i / 3));
}

std::vector<NumericalCase> product_cases() {
  return {
      {{"empty-and-uneven-rows", "filter_matrix_spmv", "for a row without entries, the output keeps its old value",
        "each sum begins at 0, and incomplete blocks of 8 entries are padded with entries of weight 0", 1e-6,
        "of the sum of magnitudes",
        "the kernel adds 21 products in pairs, so each product is rounded only a few times"},
       empty_and_uneven_rows,
       {},
       {},
       {{"filter_matrix_spmv", "float4 sum = (float4)(0.0f);", "float4 sum = y[row];"}}},
      {{"constant-textures", "pyramid_residual",
        "rounding changes (1 - t) a + t b even if the texels a and b are equal, so a constant texture gets a slope",
        "the kernel computes a + t (b - a), which is exact if a and b are equal", kNothingWrong, "relative error",
        "the result must be exactly 0"},
       constant_textures,
       {{"pyramidal_regularization", "typedef struct MultumGather {",
         "#define mix(a, b, t) ((1.0f - (t)) * (a) + (t) * (b))\ntypedef struct MultumGather {"}}},
      {{"odd-pyramids-of-great-contrast", "pyramid_residual, pyramid_gradient",
        "weights of one quarter are correct only for sizes that are powers of two",
        "the kernel reads the weights of each column and each row from tables", 2e-6,
        "absolute error of values up to 1", "each result is a sum of up to 9 x 9 rounded products"},
       odd_pyramids,
       {{"pyramidal_regularization", "gathered -= entries[v].weight * of_row;", "gathered -= 0.25f * of_row;"}}},
      {{"parts-beyond-2-to-31", "curvature_product",
        "the product of texel count and part count overflows, so parts contain wrong texels or no texels",
        "integers have 64 bits", 1e-6, "of the sum of magnitudes",
        "each part contains only 16 rounded additions, and the parts are added in double precision"},
       products_of_many_parts,
       {{"conjugate_gradient", "(((long)texel_count * part) / part_count)", "((texel_count * part) / part_count)"}}},
      {{"parts-without-texels", "advance_residual", "for a part without texels, the output keeps its old value",
        "sums begin at 0", 1e-5, "relative error",
        "the rounding error of the residual r - 1000 q grows when the residual is squared"},
       parts_without_texels,
       {},
       {},
       {{"conjugate_gradient", "float4 product = (float4)(0.0f), norm = (float4)(0.0f);",
         "float4 product = parts[part], norm = (float4)(0.0f);"}}},
      {{"steps-along-the-old-direction", "advance_direction",
        "the step uses the direction of the next iteration instead of the current direction",
        "the kernel reads the old direction before it overwrites this direction", 2e-7, "of the sum of magnitudes",
        "only two products and their sum are rounded"},
       steps_along_the_old_direction,
       {},
       {},
       {{"conjugate_gradient", "step[i] += alpha * direction;", ""},
        {"conjugate_gradient", "p[i] = inverse_diagonal[i] * r[i] + beta * direction;",
         "p[i] = inverse_diagonal[i] * r[i] + beta * direction;\n  step[i] += alpha * p[i];"}}},
  };
}

}  // namespace

std::vector<NumericalCase> inference_cases() {
  std::vector<NumericalCase> cases = product_cases();
  const auto add = [&](const char* name, const char* without, const char* guard, double bound, const char* unit,
                       const char* reason, void (*run)(Device&, WorstError&), const std::vector<SourceEdit>& edits,
                       const std::vector<SourceEdit>& mutation) {
    cases.push_back({{name, "conjugate_gradient", without, guard, bound, unit, reason}, run, edits, {}, mutation});
  };
  // The host computes the inverses. This edit of the kernel therefore replaces each inverse of 0 by infinity, as if the
  // host had no guard.
  const std::string infinite = "select(inverse_diagonal[i], (float4)(INFINITY), inverse_diagonal[i] == 0.0f)";
  add("singular-systems", "texels that no pixel reads have a diagonal entry of 0, whose inverse is infinite",
      "the inverse is set to 0, so texels that no pixel reads keep their starting values", 1e-2,
      "absolute error of pixels", "the solver uses single precision and a gradient tolerance of 1e-6", singular_systems,
      {},
      {{"conjugate_gradient", "p[i] = inverse_diagonal[i] * r[i] + beta * direction;",
        "p[i] = " + infinite + " * r[i] + beta * direction;"}});
  add("denormal-diagonals", "the inverse of a denormal diagonal entry is infinite, and its product with 0 is NaN",
      "diagonal entries below the smallest normal number are treated as 0", 1e-2, "absolute error of pixels",
      "the solver uses single precision and a gradient tolerance of 1e-6", denormal_diagonals, {},
      {{"conjugate_gradient", "product += inverse_diagonal[i] * square;", "product += " + infinite + " * square;"}});
  add("unseen-texels", "texels that no pixel reads keep their starting values, or become infinite or NaN",
      "pyramidal regularisation fills these texels from the coarser level", 2e-3, "absolute error",
      "the systems of the coarse levels have a condition number of about 1e3, which multiplies the solver's error",
      unseen_texels, {{"pyramidal_regularization", "sum[texel] += weight * gathered;", ""}}, {});
  add("regularisation-to-0",
      "the smallest eigenvalues depend only on the tiny regularisation, so steps become too long and leave the allowed "
      "range",
      "the solver stops when the gradient is small, and limits each step to the allowed range", 2e-3, "absolute error",
      "the systems of the coarse levels have a condition number of about 1e3, which multiplies the solver's error",
      vanishing_regularisation,
      {{"conjugate_gradient", "is_free[i] * (q[i] + diagonal[i] * p[i])", "(q[i] + diagonal[i] * p[i])"}}, {});
  add("contrast-of-1e6", "rounding errors of bright texels exceed the values of dark texels",
      "the solver adds partial sums in double precision and keeps values within their bounds", 1e-2,
      "absolute error of values up to 1",
      "a pixel with weight 1e-6 hardly affects the result, so its texels are less accurate", contrast_in_pixels, {},
      {{"conjugate_gradient", "step[i] += alpha * direction;", "step[i] += rint(32.0f * alpha * direction) / 32.0f;"}});
  return cases;
}

}  // namespace multum
