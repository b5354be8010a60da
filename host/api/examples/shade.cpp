// SPDX-License-Identifier: Apache-2.0
// Samples the lobes of a baked file as a path tracer does, and compares the result with uniform sampling. Needs no
// OpenCL.
//   c++ -std=c++17 shade.cpp -o shade $(pkg-config --cflags --libs multum)
//   ./shade bricks.ndf.exr
#include <multum.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <random>

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "shade: expected one baked file\n"), 2;
  multum_error* error = nullptr;
  multum_map* opened = nullptr;
  multum_brdf* made = nullptr;
  multum_lobes lobes = {};
  const bool is_open = multum_map_open(argv[1], &opened, &error) == MULTUM_OK &&
                       multum_brdf_new("ggx:0.4,0.04", &made, &error) == MULTUM_OK &&
                       multum_map_lookup(opened, 0.5, 0.5, 4.0, &lobes, &error) == MULTUM_OK;
  const std::unique_ptr<multum_map, decltype(&multum_map_free)> map(opened, multum_map_free);
  const std::unique_ptr<multum_brdf, decltype(&multum_brdf_free)> brdf(made, multum_brdf_free);
  if (!is_open) {
    std::fprintf(stderr, "shade: %s\n", multum_error_message(error));
    const int code = multum_error_status(error);
    multum_error_free(error);
    return code;
  }
  // The light from a white sky that the texel reflects towards the eye.
  const double view[3] = {0.6, 0.0, 0.8};
  constexpr int kCount = 20000;
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  double by_lobes = 0.0, by_sphere = 0.0, lobes_squared = 0.0, sphere_squared = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double random[3] = {uniform(engine), uniform(engine), uniform(engine)};
    double light[3], rgb[3];
    const double pdf = multum_sample(&lobes, brdf.get(), view, random, light);
    multum_shade(&lobes, brdf.get(), light, view, rgb);
    const double value = pdf > 0.0 ? rgb[1] / pdf : 0.0;
    by_lobes += value, lobes_squared += value * value;

    const double sine = std::sqrt(1.0 - random[1] * random[1]), angle = 2.0 * M_PI * random[2];
    const double sky[3] = {sine * std::cos(angle), sine * std::sin(angle), random[1]};
    multum_shade(&lobes, brdf.get(), sky, view, rgb);
    const double other = rgb[1] * 2.0 * M_PI;
    by_sphere += other, sphere_squared += other * other;
  }
  const auto variance = [](double sum, double squares) { return squares / kCount - sum * sum / kCount / kCount; };
  std::printf("sampling lobes: %.4f, variance %.4f\nuniform sampling: %.4f, variance %.4f\n", by_lobes / kCount,
              variance(by_lobes, lobes_squared), by_sphere / kCount, variance(by_sphere, sphere_squared));
}
