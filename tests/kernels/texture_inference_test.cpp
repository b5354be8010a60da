// SPDX-License-Identifier: Apache-2.0
// Compares texture inference with its objective in double precision and with Eigen's direct solution. Also tests the
// conditions at the bounds, and texels that no pixel sees.
#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "host/fields/inference/solver/texture_inference.h"
#include "host/fields/inference/solver/texture_system.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/split_mix.h"
#include "host/lab/field_cases/texture_inference.h"
#include "tests/kernels/em_harness.h"

namespace multum::testing {
namespace {

using reference::InferenceProblem;
using reference::interpolation;
using reference::InterpolationEntry;
using reference::objective;
using reference::random_matrix;

struct Case {
  int width, height;
  WrapMode wrap;
  int rows, views;
  double pyramid_weight;
  InferenceForm form;
};

// Holds a problem with several views of one texture, and with pixels that no texture can fit exactly.
struct Problem {
  std::vector<FilterMatrix> matrices;
  std::vector<InferenceView> views;
  std::vector<float> colours;  // three per row

  Problem(const Case& c, unsigned seed, double low = 0.2, double high = 0.8) {
    SplitMix64 random(seed);
    for (int v = 0; v < c.views; ++v)
      matrices.push_back(random_matrix(c.width, c.height, c.wrap, c.rows, seed + 17u * static_cast<unsigned>(v)));
    for (const FilterMatrix& matrix : matrices) {
      InferenceView view{&matrix, {}};
      for (std::size_t r = 0; r < matrix.row_count(); ++r)
        view.row_weights.push_back(r % 7 == 3 ? 0.0f : static_cast<float>(0.1 + 0.9 * random.uniform()));
      views.push_back(view);
    }
    for (std::size_t i = 0; i < 3u * static_cast<std::size_t>(c.rows * c.views); ++i)
      colours.push_back(static_cast<float>(low + (high - low) * random.uniform()));
  }

  InferenceProblem of_colour(std::size_t colour, double pyramid_weight, double range_weight) const {
    InferenceProblem problem{{}, {}, {}, pyramid_weight, range_weight};
    for (const InferenceView& view : views) {
      problem.matrices.push_back(view.matrix);
      problem.row_weights.push_back(view.row_weights);
    }
    for (std::size_t i = colour; i < colours.size(); i += 3) problem.pixels.push_back(static_cast<double>(colours[i]));
    return problem;
  }
};

std::vector<double> colour_of(const std::vector<float>& texels, std::size_t colour) {
  std::vector<double> values;
  for (std::size_t i = colour; i < texels.size(); i += 3) values.push_back(static_cast<double>(texels[i]));
  return values;
}

// Returns half of the gradient, computed by central differences, which are exact for the quadratic part.
double half_slope(const InferenceProblem& problem, std::vector<double> texels, std::size_t t, double h) {
  const double at = texels[t];
  texels[t] = at + h;
  const double above = objective(problem, texels);
  texels[t] = at - h;
  return (above - objective(problem, texels)) / (4.0 * h);
}

// Returns the minimum without bounds. Solves the normal equations in double precision by Cholesky factorisation.
Eigen::VectorXd direct_solution(const InferenceProblem& problem) {
  const FilterMatrix& first = *problem.matrices.front();
  const int n = first.layout().texel_count;
  std::vector<Eigen::Triplet<double>> a, b;
  std::vector<double> right;
  std::size_t pixel = 0;
  for (std::size_t v = 0; v < problem.matrices.size(); ++v)
    for (std::size_t r = 0; r < problem.matrices[v]->row_count(); ++r, ++pixel) {
      const double root = std::sqrt(static_cast<double>(problem.row_weights[v][r]));
      if (root == 0.0) continue;
      const FilterMatrix& m = *problem.matrices[v];
      for (std::uint32_t i = m.row_begin[r]; i < m.row_begin[r + 1]; ++i)
        a.emplace_back(static_cast<int>(right.size()), static_cast<int>(m.columns[i]),
                       root * static_cast<double>(m.weights[i]));
      right.push_back(root * problem.pixels[pixel]);
    }
  for (int t = 0; t < first.layout().levels.back().offset; ++t) b.emplace_back(t, t, 1.0);
  for (const InterpolationEntry& entry : interpolation(first)) b.emplace_back(entry.fine, entry.coarse, -entry.weight);
  Eigen::SparseMatrix<double> matrix(static_cast<int>(right.size()), n), pyramid(n, n);
  matrix.setFromTriplets(a.begin(), a.end());
  pyramid.setFromTriplets(b.begin(), b.end());
  const double weight = problem.pyramid_weight * static_cast<double>(right.size()) / n;
  const Eigen::SparseMatrix<double> normal = Eigen::SparseMatrix<double>(matrix.transpose()) * matrix +
                                             weight * (Eigen::SparseMatrix<double>(pyramid.transpose()) * pyramid);
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
  EXPECT_EQ(solver.info(), Eigen::Success);
  const Eigen::Map<const Eigen::VectorXd> b_vector(right.data(), static_cast<Eigen::Index>(right.size()));
  return solver.solve(matrix.transpose() * b_vector);
}

InferenceSettings exact_settings(const Case& c) {
  InferenceSettings settings;
  settings.pyramid_weight = c.pyramid_weight;
  settings.gradient_tolerance = 1e-6;
  settings.iteration_max = 4000;
  settings.newton_max = 40;
  settings.form = c.form;
  return settings;
}

class TextureInferenceTest : public ::testing::TestWithParam<Case> {};

TEST_P(TextureInferenceTest, FindsWhatEigenFinds) {
  const Case& c = GetParam();
  const Problem problem(c, 5);
  TextureInference inference(test_device(), problem.views, exact_settings(c), 2);
  EXPECT_EQ(inference.uses_normal_form(), c.form == InferenceForm::kNormal);
  const InferenceResult result = inference.solve(problem.colours, {});
  for (std::size_t colour = 0; colour < 3; ++colour) {
    const Eigen::VectorXd expected = direct_solution(problem.of_colour(colour, c.pyramid_weight, 0.0));
    ASSERT_GT(expected.minCoeff(), 0.0) << "the solution must be inside the bounds";
    ASSERT_LT(expected.maxCoeff(), 1.0);
    const std::vector<double> found = colour_of(result.texels, colour);
    double worst = 0.0;
    for (std::size_t t = 0; t < found.size(); ++t)
      worst = std::max(worst, std::abs(found[t] - expected[static_cast<Eigen::Index>(t)]));
    // The tolerance is the rounding error of single precision times the condition number of the coarse levels, which is
    // about 1e3.
    EXPECT_LE(worst, 5e-4) << "colour " << colour;
  }
}

// Tests the Kuhn-Tucker conditions: the slope is 0 inside the bounds and points outwards at them. Range regularisation
// keeps texels away from the bounds. A few texels may reach the bounds where the pixels demand it strongly, because the
// term g is finite there (d is not 0).
TEST_P(TextureInferenceTest, EndsWhereNothingLeadsDown) {
  const Case& c = GetParam();
  std::size_t at_bounds[2] = {0, 0};
  for (const bool has_range : {false, true}) {
    const double range_weight = has_range ? 1e-3 : 0.0;
    const Problem problem(c, 11, -1.5, 2.5);
    InferenceSettings settings = exact_settings(c);
    settings.range_weight = range_weight;
    TextureInference inference(test_device(), problem.views, settings, 1);
    const InferenceResult result = inference.solve(problem.colours, {});
    for (std::size_t colour = 0; colour < 3; ++colour) {
      const InferenceProblem reference = problem.of_colour(colour, c.pyramid_weight, range_weight);
      const std::vector<double> texels = colour_of(result.texels, colour);
      for (std::size_t t = 0; t < texels.size(); ++t) {
        ASSERT_GE(texels[t], 0.0);
        ASSERT_LE(texels[t], 1.0);
        const bool low = texels[t] == 0.0, high = texels[t] == 1.0;
        at_bounds[has_range ? 1 : 0] += low || high ? 1 : 0;
        // The third derivative of g is 6 / d^4 at the bounds, so differences over 1e-6 have an error of 1e-7 of the
        // range term.
        const double slope = half_slope(reference, texels, t, 1e-6);
        const double tolerance = 3e-3;  // the slopes at x = 0 are about 10
        EXPECT_TRUE(high || slope >= -tolerance) << "texel " << t << " slope " << slope;
        EXPECT_TRUE(low || slope <= tolerance) << "texel " << t << " slope " << slope;
      }
    }
  }
  EXPECT_GT(at_bounds[0], 0u) << "the solution must reach the bounds";
  EXPECT_LT(at_bounds[1], at_bounds[0]);
}

TEST_P(TextureInferenceTest, ThreadsAndRunsChangeNothing) {
  const Case& c = GetParam();
  const Problem problem(c, 23);
  TextureInference one(test_device(), problem.views, exact_settings(c), 1);
  TextureInference three(test_device(), problem.views, exact_settings(c), 3);
  const std::vector<float> texels = one.solve(problem.colours, {}).texels;
  EXPECT_EQ(texels, three.solve(problem.colours, {}).texels);
  EXPECT_EQ(texels, one.solve(problem.colours, {}).texels);
}

TEST_P(TextureInferenceTest, ANeighboursSolutionIsABetterStart) {
  const Case& c = GetParam();
  const Problem problem(c, 31);
  TextureInference inference(test_device(), problem.views, exact_settings(c), 1);
  const InferenceResult first = inference.solve(problem.colours, {});
  std::vector<float> nearby = problem.colours;
  for (std::size_t i = 0; i < nearby.size(); i += 5) nearby[i] += 0.002f;
  const InferenceResult cold = inference.solve(nearby, {}), warm = inference.solve(nearby, first.texels);
  EXPECT_LT(warm.iterations, cold.iterations);
  for (std::size_t i = 0; i < cold.texels.size(); ++i) ASSERT_NEAR(cold.texels[i], warm.texels[i], 1e-3);
}

constexpr WrapMode kClamp = WrapMode::kClamp, kPeriodic = WrapMode::kPeriodic;
INSTANTIATE_TEST_SUITE_P(Cases, TextureInferenceTest,
                         ::testing::Values(Case{16, 8, kClamp, 900, 1, 0.1, InferenceForm::kMatrix},
                                           Case{16, 8, kClamp, 900, 1, 0.1, InferenceForm::kNormal},
                                           Case{13, 9, kPeriodic, 500, 3, 0.5, InferenceForm::kMatrix},
                                           Case{13, 9, kPeriodic, 500, 3, 0.5, InferenceForm::kNormal},
                                           Case{7, 1, kClamp, 200, 2, 0.1, InferenceForm::kMatrix}));

TEST(TextureInference, ExactPicturesGiveTheirTextureBack) {
  const FilterMatrix matrix = random_matrix(8, 8, kClamp, 4000, 3);
  SplitMix64 random(9);
  std::vector<float> texels;
  for (int i = 0; i < 3 * matrix.layout().texel_count; ++i) texels.push_back(static_cast<float>(random.uniform()));
  InferenceSettings settings;
  settings.pyramid_weight = 0.0;
  settings.gradient_tolerance = 1e-7;
  settings.iteration_max = 4000;
  TextureInference inference(test_device(), {{&matrix, std::vector<float>(matrix.row_count(), 1.0f)}}, settings, 1);
  const std::vector<float> picture = inference.picture(texels);
  const InferenceResult result = inference.solve(picture, {});
  // Compares only the finest level, because pixels see all of its texels.
  for (std::size_t i = 0; i < 3 * 64; ++i) ASSERT_NEAR(result.texels[i], texels[i], 2e-3) << i;
}

TEST(TextureInference, PyramidalRegularisationDefinesEveryTexel) {
  // These footprints see only the left half, which has one colour.
  FilterMatrix matrix = random_matrix(32, 16, kClamp, 3000, 7);
  const MipLayout layout = matrix.layout();
  std::vector<float> weights;
  for (std::size_t r = 0; r < matrix.row_count(); ++r) {
    bool is_left = true;
    for (std::uint32_t i = matrix.row_begin[r]; i < matrix.row_begin[r + 1]; ++i) {
      const int texel = static_cast<int>(matrix.columns[i]), l = layout.level_of(texel);
      const MipLevelPlace& level = layout.levels[static_cast<std::size_t>(l)];
      is_left = is_left && (texel - level.offset) % level.width < level.width / 2;
    }
    weights.push_back(is_left ? 1.0f : 0.0f);
  }
  InferenceSettings settings;
  settings.gradient_tolerance = 1e-6;
  settings.iteration_max = 2000;
  TextureInference inference(test_device(), {{&matrix, weights}}, settings, 1);
  const InferenceResult result = inference.solve(std::vector<float>(3 * matrix.row_count(), 0.6f), {});
  EXPECT_TRUE(result.converged);
  for (const float value : result.texels) ASSERT_NEAR(value, 0.6f, 2e-3f);
}

TEST(TextureInference, OneTexelIsTheMeanOfItsPixels) {
  FilterMatrix matrix;
  matrix.width = matrix.height = 2;
  matrix.pixels = {0, 1, 2, 3};
  matrix.coverage = matrix.weights = {1.0f, 1.0f, 1.0f, 1.0f};
  matrix.row_begin = {0, 1, 2, 3, 4};
  matrix.columns = {0, 0, 0, 0};
  TextureInference inference(test_device(), {{&matrix, matrix.coverage}}, {}, 1);
  const InferenceResult result =
      inference.solve({0.1f, 0.2f, 0.3f, 0.3f, 0.4f, 0.5f, 0.1f, 0.2f, 0.3f, 0.3f, 0.4f, 0.5f}, {});
  EXPECT_TRUE(result.converged);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(result.texels[c], 0.2f + 0.1f * static_cast<float>(c), 1e-5f);
}

TEST(TextureInference, BlackPicturesAreBlackTextures) {
  const FilterMatrix matrix = random_matrix(8, 8, kClamp, 300, 3);
  TextureInference inference(test_device(), {{&matrix, std::vector<float>(matrix.row_count(), 1.0f)}}, {}, 1);
  const InferenceResult result = inference.solve(std::vector<float>(3 * matrix.row_count(), 0.0f), {});
  EXPECT_TRUE(result.converged);
  for (const float value : result.texels) ASSERT_EQ(value, 0.0f);
}

// Without regularisation, the system is singular for unseen texels. The solver still finds the seen texels, and the
// others stay finite.
TEST(TextureInference, SingularSystemsStayFinite) {
  const FilterMatrix matrix = random_matrix(64, 64, kClamp, 40, 3);
  InferenceSettings settings;
  settings.pyramid_weight = 0.0;
  TextureInference inference(test_device(), {{&matrix, std::vector<float>(matrix.row_count(), 1.0f)}}, settings, 1);
  const InferenceResult result = inference.solve(std::vector<float>(3 * matrix.row_count(), 0.5f), {});
  EXPECT_TRUE(result.converged);
  for (const float value : result.texels) ASSERT_TRUE(std::isfinite(value));
  for (const float value : inference.picture(result.texels)) ASSERT_NEAR(value, 0.5f, 1e-2f);
}

TEST(TextureInference, RefusesNothingAndMixtures) {
  const FilterMatrix matrix = random_matrix(8, 8, kClamp, 30, 3), other = random_matrix(8, 4, kClamp, 30, 3);
  const std::vector<float> none(30, 0.0f), all(30, 1.0f);
  const auto code_of = [&](const std::vector<InferenceView>& views) {
    try {
      const TextureInference inference(test_device(), views, {}, 1);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::kUsage;
  };
  EXPECT_EQ(code_of({{&matrix, none}}), ErrorCode::kInput);
  EXPECT_EQ(code_of({{&matrix, all}, {&other, all}}), ErrorCode::kInput);
}

TEST(TextureInference, EstimatesTheEntriesOfTheNormalForm) {
  const FilterMatrix matrix = random_matrix(40, 40, kClamp, 4000, 3);
  SparseRows rows;
  append_weighted_rows({&matrix, std::vector<float>(matrix.row_count(), 1.0f)}, rows);
  const SparseRows columns = transposed(rows, static_cast<std::size_t>(matrix.layout().texel_count));
  const std::size_t exact = normal_rows(rows, columns, 2).columns.size();
  EXPECT_NEAR(static_cast<double>(estimated_normal_entries(rows, columns)), static_cast<double>(exact),
              0.1 * static_cast<double>(exact));
}

}  // namespace
}  // namespace multum::testing
