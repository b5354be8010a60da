// SPDX-License-Identifier: Apache-2.0
// Compares shading and sampling by multum.h with quadrature over the sphere of normals and over the sphere of light
// directions.
#include <array>
#include <functional>

#include "tests/api/api_fixture.h"

namespace multum::testing {
namespace {

using Vector = std::array<double, 3>;

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector unit(double x, double y, double z) {
  const double length = std::sqrt(x * x + y * y + z * z);
  return {x / length, y / length, z / length};
}

// Returns two lobes with different directions and a kappa of about 20 and 200.
multum_lobes two_lobes() {
  multum_lobes lobes = {};
  lobes.count = 2;
  const auto set = [&](int j, float a, double kappa, const Vector& mean) {
    const double r = 1.0 / std::tanh(kappa) - 1.0 / kappa;
    for (std::size_t c = 0; c < 3; ++c) lobes.lobes[j][c] = a * static_cast<float>(r * mean[c]);
    lobes.lobes[j][3] = a;
  };
  set(0, 0.7f, 20.0, unit(0.3, 0.1, 1.0));
  set(1, 0.3f, 200.0, unit(-0.4, 0.2, 1.0));
  return lobes;
}

// Integrates over the sphere with the midpoint rule in z and phi.
double over_sphere(const std::function<double(const Vector&)>& f, int steps = 400) {
  double sum = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double z = -1.0 + (i + 0.5) * 2.0 / steps, side = std::sqrt(1.0 - z * z);
    for (int k = 0; k < 2 * steps; ++k) {
      const double phi = (k + 0.5) * M_PI / steps;
      sum += f({side * std::cos(phi), side * std::sin(phi), z});
    }
  }
  return sum * 2.0 * M_PI / steps / steps;
}

Owned<multum_brdf> brdf_of(const char* text) {
  multum_brdf* brdf = nullptr;
  MadeError error;
  EXPECT_EQ(multum_brdf_new(text, &brdf, error.place()), MULTUM_OK) << error.message();
  return Owned<multum_brdf>(brdf);
}

TEST(ApiShadingTest, DensityIntegratesToTheAmplitudes) {
  const multum_lobes lobes = two_lobes();
  EXPECT_NEAR(over_sphere([&](const Vector& n) { return multum_density(&lobes, n.data()); }), 1.0, 1e-3);
}

// The reference averages the BRDF over the density of normals. The formulas are approximations; the documents state
// 0.27 % for the convolution and 0.25 % for the cosine at s = 100.
TEST(ApiShadingTest, BlinnPhongAgreesWithQuadrature) {
  const multum_lobes lobes = two_lobes();
  const Owned<multum_brdf> brdf = brdf_of("blinn-phong:100");
  for (const Vector& light : {unit(0.2, 0.3, 1.0), unit(-0.5, 0.1, 0.8), unit(0.9, 0.0, 0.5)}) {
    const Vector view = unit(0.1, -0.2, 1.0);
    const Vector h = unit(light[0] + view[0], light[1] + view[1], light[2] + view[2]);
    const double expected = over_sphere([&](const Vector& n) {
      const double cosine = std::max(dot(n, light), 0.0),
                   facets = std::pow(std::max(dot(n, h), 0.0), 100.0) * 101.0 / (2.0 * M_PI);
      return multum_density(&lobes, n.data()) * cosine * (0.5 / M_PI + 0.1 * facets);
    });
    double rgb[3];
    multum_shade(&lobes, brdf.get(), light.data(), view.data(), rgb);
    EXPECT_NEAR(rgb[0] / expected, 1.0, 0.02);
    EXPECT_EQ(rgb[0], rgb[2]);
  }
}

TEST(ApiShadingTest, NothingComesFromBelowTheHorizon) {
  const multum_lobes lobes = two_lobes();
  const Owned<multum_brdf> brdf = brdf_of("ggx:0.4");
  const double below[3] = {0.6, 0.0, -0.8}, above[3] = {0.0, 0.0, 1.0};
  double rgb[3] = {9.0, 9.0, 9.0};
  multum_shade(&lobes, brdf.get(), below, above, rgb);
  EXPECT_EQ(rgb[0], 0.0);
  multum_shade(&lobes, brdf.get(), above, below, rgb);
  EXPECT_EQ(rgb[1], 0.0);
}

TEST(ApiShadingTest, ColoursMultiplyTheDiffusePart) {
  multum_lobes lobes = two_lobes();
  lobes.has_colours = 1;
  for (int j = 0; j < 2; ++j)
    for (int c = 0; c < 3; ++c) lobes.colours[j][c] = lobes.lobes[j][3] * (c == 0 ? 1.0f : 0.5f);
  const Owned<multum_brdf> brdf = brdf_of("lambert");
  const double up[3] = {0.0, 0.0, 1.0};
  double rgb[3];
  multum_shade(&lobes, brdf.get(), up, up, rgb);
  EXPECT_NEAR(rgb[0], 2.0 * rgb[1], 1e-6);
  EXPECT_NEAR(rgb[0], 0.93 / M_PI, 0.03);
}

TEST(ApiShadingTest, PdfIntegratesToOneAndSamplesFollowIt) {
  const multum_lobes lobes = two_lobes();
  for (const char* text : {"lambert", "blinn-phong:50", "ggx:0.5,0.04", "cook-torrance:0.3,0.04"}) {
    const Owned<multum_brdf> brdf = brdf_of(text);
    const Vector view = unit(0.4, 0.1, 0.9);
    EXPECT_NEAR(
        over_sphere([&](const Vector& l) { return multum_pdf(&lobes, brdf.get(), view.data(), l.data()); }, 800), 1.0,
        5e-3)
        << text;
    // The mean of a function over the samples must equal the integral of the function times the density.
    const auto function = [](const Vector& l) { return 1.0 + l[0] + 2.0 * l[1] * l[2]; };
    const double expected = over_sphere(
        [&](const Vector& l) { return function(l) * multum_pdf(&lobes, brdf.get(), view.data(), l.data()); }, 800);
    double sum = 0.0;
    constexpr int kCount = 40000;
    std::uint32_t state = 1;
    const auto uniform = [&] { return (state = state * 1664525u + 1013904223u) / 4294967296.0; };
    for (int i = 0; i < kCount; ++i) {
      const double random[3] = {uniform(), (i + 0.5) / kCount, uniform()};
      Vector l;
      const double pdf = multum_sample(&lobes, brdf.get(), view.data(), random, l.data());
      EXPECT_NEAR(pdf / multum_pdf(&lobes, brdf.get(), view.data(), l.data()), 1.0, 1e-6);
      sum += function(l);
    }
    EXPECT_NEAR(sum / kCount, expected, 0.02) << text;
  }
}

TEST(ApiShadingTest, SamplingGivesTheReflectedLight) {
  const multum_lobes lobes = two_lobes();
  const Owned<multum_brdf> brdf = brdf_of("ggx:0.4,0.04");
  const Vector view = unit(0.3, 0.2, 0.9);
  const auto shade = [&](const Vector& l) {
    double rgb[3];
    multum_shade(&lobes, brdf.get(), l.data(), view.data(), rgb);
    return rgb[1];
  };
  const double expected = over_sphere(shade, 800);
  double sum = 0.0;
  constexpr int kCount = 40000;
  std::uint32_t state = 7;
  const auto uniform = [&] { return (state = state * 1664525u + 1013904223u) / 4294967296.0; };
  for (int i = 0; i < kCount; ++i) {
    const double random[3] = {uniform(), (i + 0.5) / kCount, uniform()};
    Vector l;
    const double pdf = multum_sample(&lobes, brdf.get(), view.data(), random, l.data());
    sum += pdf > 0.0 ? shade(l) / pdf : 0.0;
  }
  EXPECT_NEAR(sum / kCount / expected, 1.0, 0.01);
}

// A map that was baked with roughness has lobes that are convolved with the facets. Such a lobe must reflect the same
// light as the lobe of the normals does with facets of this width.
TEST(ApiShadingTest, LobesWithRoughnessReflectLikeFacetsOfThatRoughness) {
  constexpr double kSigma = 0.25, kKappa = 0.5 / (kSigma * kSigma);  // Torrance-Sparrow's facets are this vMF
  const double facets = 1.0 / std::tanh(kKappa) - 1.0 / kKappa;
  const multum_lobes normals = two_lobes();
  multum_lobes rough = normals;
  rough.mean_cosine = static_cast<float>(facets);
  for (int j = 0; j < rough.count; ++j)
    for (int c = 0; c < 3; ++c) rough.lobes[j][c] *= static_cast<float>(facets);
  const Owned<multum_brdf> same = brdf_of("torrance-sparrow:0.25"), other = brdf_of("torrance-sparrow:0.05");
  const Vector view = unit(0.1, -0.2, 1.0);
  for (const Vector& light : {unit(0.2, 0.3, 1.0), unit(-0.5, 0.1, 0.8), unit(0.9, 0.0, 0.5)}) {
    double expected[3], rgb[3], rgb_of_other[3];
    multum_shade(&normals, same.get(), light.data(), view.data(), expected);
    multum_shade(&rough, same.get(), light.data(), view.data(), rgb);
    multum_shade(&rough, other.get(), light.data(), view.data(), rgb_of_other);
    EXPECT_NEAR(rgb[0] / expected[0], 1.0, 1e-3);
    EXPECT_EQ(rgb[0], rgb_of_other[0]);  // the width of the BRDF is not used
  }
  EXPECT_NEAR(over_sphere([&](const Vector& l) { return multum_pdf(&rough, same.get(), view.data(), l.data()); }), 1.0,
              0.01);
}

TEST(ApiShadingTest, UnknownBrdfIsAnError) {
  multum_brdf* brdf = nullptr;
  MadeError error;
  EXPECT_NE(multum_brdf_new("ggx:9", &brdf, error.place()), MULTUM_OK);
  EXPECT_EQ(error.message().find("--"), std::string::npos) << error.message();
  EXPECT_EQ(brdf, nullptr);
}

TEST(ApiShadingTest, EmptyMixtureHasNoLight) {
  multum_lobes lobes = {};
  lobes.count = 2;
  const Owned<multum_brdf> brdf = brdf_of("ggx:0.4");
  const double up[3] = {0.0, 0.0, 1.0}, random[3] = {0.5, 0.5, 0.5};
  double light[3], rgb[3];
  EXPECT_EQ(multum_sample(&lobes, brdf.get(), up, random, light), 0.0);
  EXPECT_EQ(multum_density(&lobes, up), 0.0);
  multum_shade(&lobes, brdf.get(), up, up, rgb);
  EXPECT_EQ(rgb[0], 0.0);
}

}  // namespace
}  // namespace multum::testing
