// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/documents/formula_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/bakes/accuracy/highlight.h"
#include "host/formats/brdf/facet_distribution.h"
#include "host/formats/brdf/measured_file.h"
#include "host/formats/brdf/vmf_terms.h"
#include "host/lab/reference/shading.h"
#include "kernels/shared/moments.h"
#include "tools/lab/bench/documents/markdown_table.h"

namespace multum::bench {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::array kKappas = {1.0, 3.0, 12.0, 60.0, 400.0, 2000.0};
constexpr std::array kExponents = {5.0, 20.0, 100.0, 500.0};
constexpr std::array kTilts = {0.0, 30.0, 60.0, 75.0};  // in degrees

// A direction and its solid angle.
struct Direction {
  glm::dvec3 w;
  double angle;
};

// Directions on a meridian, which are enough for functions that are symmetric about z.
std::vector<Direction> meridian() {
  constexpr int kCount = 160;
  std::vector<Direction> all;
  for (int i = 0; i < kCount; ++i) {
    const double theta = 0.5 * kPi * (i + 0.5) / kCount;
    all.push_back({{std::sin(theta), 0.0, std::cos(theta)}, std::sin(theta)});
  }
  return all;
}

std::vector<Direction> hemisphere() {
  constexpr int kRings = 40, kSpokes = 48;
  std::vector<Direction> all;
  for (int i = 0; i < kRings; ++i)
    for (int k = 0; k < kSpokes; ++k) {
      const double theta = 0.5 * kPi * (i + 0.5) / kRings, phi = 2.0 * kPi * (k + 0.5) / kSpokes;
      all.push_back(
          {{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)}, std::sin(theta)});
    }
  return all;
}

using Values = std::vector<double>;  // has one value per direction

Values each(const std::vector<Direction>& directions, const std::function<double(double theta)>& value) {
  Values values;
  for (const Direction& d : directions) values.push_back(value(std::acos(std::clamp(d.w.z, -1.0, 1.0))));
  return values;
}

// Returns the relative L1 error in %, integrated over solid angle.
std::string relative_l1(const std::vector<Direction>& directions, const Values& model, const Values& reference) {
  double off = 0.0, total = 0.0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    off += std::abs(model[i] - reference[i]) * directions[i].angle;
    total += reference[i] * directions[i].angle;
  }
  return fmt::format("{:.2f}", 100.0 * off / total);
}

// Runs the shading kernels with which a bake measures its own error, for one lobe or one set of moments. The runtime's
// GLSL code computes the same values (tests/agreement).
class ShadingKernels {
 public:
  explicit ShadingKernels(Device& device) : device_(device) {}

  // Shades a stored lobe with Blinn-Phong, or with Lambert if the exponent is 0.
  Values lobe(const glm::vec4& lobe, bool is_gaussian, const std::vector<Direction>& directions, double exponent) {
    const DeviceBuffer in = device_.wrap_buffer(&lobe, sizeof(lobe), "lobe");
    return run(device_.kernel("movmf_shade", "movmf_shade", {1, 1, false, is_gaussian}), in, directions, exponent);
  }
  Values moments(const MultumFilteredMoments& moments, int shading, const std::vector<Direction>& directions,
                 double exponent) {
    const DeviceBuffer in = device_.wrap_buffer(&moments, sizeof(moments), "moments");
    return run(device_.kernel("moment_shade", "moment_shade", {}), in, directions, exponent, shading);
  }

 private:
  template <typename... More>
  Values run(Kernel kernel, const DeviceBuffer& in, const std::vector<Direction>& directions, double exponent,
             More... more) {
    std::vector<glm::vec4> vectors;
    for (const Direction& d : directions) vectors.emplace_back(glm::vec3(d.w), 0.0f);
    const MultumHighlight highlight = shaded_highlight(exponent);  // moments use only the exponent
    const int count = static_cast<int>(directions.size());
    std::vector<float> values(directions.size());
    const DeviceBuffer around = device_.wrap_buffer(vectors.data(), vectors.size() * sizeof(glm::vec4), "directions");
    const DeviceBuffer highlights = device_.wrap_buffer(&highlight, sizeof(highlight), "highlight");
    const DeviceBuffer out = device_.make_buffer(values.size() * sizeof(float), "values");
    const bool is_lambert = exponent == 0.0;
    kernel.launch({1}, in, around, around, highlights, out, 1, is_lambert ? 0 : count, is_lambert ? count : 0,
                  is_lambert ? 0 : 1, more...);
    device_.read(out, values.data(), values.size() * sizeof(float));
    return {values.begin(), values.end()};
  }

  Device& device_;
};

glm::vec4 upright_lobe(double kappa) {
  return {0.0f, 0.0f, static_cast<float>(1.0 - reference::vmf_spread(kappa)), 1.0f};
}

// Convolves each term of a BRDF with a lobe. The mean cosine of the result is the product of the mean cosines, A = |r|
// A(lambda).
Values product_of_terms(const std::vector<VmfTerm>& terms, double kappa, const std::vector<Direction>& directions) {
  const double spread = reference::vmf_spread(kappa);
  std::vector<double> kappas;
  for (const VmfTerm& term : terms) kappas.push_back(reference::vmf_kappa(spread + term.spread - spread * term.spread));
  return each(directions, [&](double theta) {
    double sum = 0.0;
    for (std::size_t i = 0; i < terms.size(); ++i) sum += terms[i].weight.x * reference::vmf_density(kappas[i], theta);
    return sum;
  });
}

Brdf ggx_of(double alpha, int terms) {
  Brdf brdf;
  brdf.kind = BrdfKind::kGgx;
  brdf.roughness = static_cast<float>(std::sqrt(alpha));
  brdf.term_count = terms;
  return brdf;
}

std::vector<std::string> kappa_head() {
  std::vector<std::string> head = {"von Mises-Fisher lobe with kappa"};
  for (const double kappa : kKappas) head.push_back(fmt::format("{:g}", kappa));
  return head;
}

// A row of a table: a function that returns the error at a given kappa.
using Row = std::function<std::string(double kappa)>;
void add_row(MarkdownTable& table, const std::string& name, const Row& error) {
  std::vector<std::string> cells = {name};
  for (const double kappa : kKappas) cells.push_back(error(kappa));
  table.add(cells);
}

void add_blinn_phong(MarkdownTable& table, ShadingKernels& kernels, const std::vector<Direction>& directions) {
  for (const double s : kExponents) {
    const auto reference = [&, s](double kappa) {
      return each(directions, [&](double theta) { return reference::convolved_blinn_phong(s, kappa, theta); });
    };
    add_row(table, fmt::format("Blinn-Phong {:g}, product of mean cosines", s), [&](double kappa) {
      return relative_l1(directions, kernels.lobe(upright_lobe(kappa), false, directions, s), reference(kappa));
    });
    add_row(table, fmt::format("Blinn-Phong {:g}, the paper's s' (eq. 20)", s), [&](double kappa) {
      const double widened = kappa * s / (kappa + s);
      return relative_l1(directions,
                         each(directions, [&](double theta) { return reference::blinn_phong(widened, theta); }),
                         reference(kappa));
    });
    add_row(table, fmt::format("Blinn-Phong {:g}, Toksvig's rule", s), [&](double kappa) {
      MultumFilteredMoments mean = {};
      mean.normal_z = upright_lobe(kappa).z;
      mean.share = 1.0f;
      return relative_l1(directions, kernels.moments(mean, MULTUM_SHADE_TOKSVIG, directions, s), reference(kappa));
    });
  }
}

void add_lambert(MarkdownTable& table, ShadingKernels& kernels, const std::vector<Direction>& directions) {
  const auto reference = [&](double kappa) {
    return each(directions, [&](double theta) { return reference::convolved_lambert(kappa, theta); });
  };
  add_row(table, "Lambert, mean of the folded normal", [&](double kappa) {
    return relative_l1(directions, kernels.lobe(upright_lobe(kappa), false, directions, 0.0), reference(kappa));
  });
  add_row(table, "Lambert, the paper's max(mu . l, 0)", [&](double kappa) {
    return relative_l1(directions, each(directions, [](double theta) { return std::max(std::cos(theta), 0.0); }),
                       reference(kappa));
  });
}

// Adds rows for f(1 - cosine) with 1 to 4 terms.
void add_terms(MarkdownTable& table, const std::string& name, const std::function<double(double e)>& f, double narrow,
               const std::function<std::vector<VmfTerm>(int)>& terms, const std::vector<Direction>& directions) {
  const auto reference = [&](double kappa) {
    const auto of_angle = [&](double a) { return f(2.0 * std::pow(std::sin(0.5 * a), 2.0)); };
    return each(directions, [&](double theta) { return reference::convolved(of_angle, narrow, kappa, theta); });
  };
  std::vector<Values> references;
  for (const double kappa : kKappas) references.push_back(reference(kappa));
  for (int count = 1; count <= kBrdfTermCountMax; ++count) {
    const std::vector<VmfTerm> fitted = terms(count);
    std::vector<std::string> cells = {fmt::format("{}, {} term{}", name, count, count > 1 ? "s" : "")};
    for (std::size_t i = 0; i < kKappas.size(); ++i)
      cells.push_back(relative_l1(directions, product_of_terms(fitted, kKappas[i], directions), references[i]));
    table.add(cells);
  }
}

void add_facets(MarkdownTable& table, const std::vector<Direction>& directions, const std::string& brdfs) {
  for (const double sigma : {0.05, 0.2}) {
    Brdf brdf;
    brdf.kind = BrdfKind::kTorranceSparrow;
    brdf.sigma = static_cast<float>(sigma);
    const std::vector<VmfTerm> terms = vmf_terms(brdf);
    add_row(table, fmt::format("Torrance-Sparrow, Cook-Torrance, sigma {:g}", sigma), [&](double kappa) {
      const double kappa_f = 0.5 / (sigma * sigma);
      return relative_l1(directions, product_of_terms(terms, kappa, directions), each(directions, [&](double theta) {
                           return reference::convolved_vmf(kappa_f, kappa, theta);
                         }));
    });
  }
  for (const double alpha : {0.05, 0.1, 0.2, 0.4, 0.7}) {
    const auto f = [alpha](double e) { return reference::ggx(alpha, 2.0 * std::asin(std::sqrt(0.5 * e))); };
    add_terms(
        table, fmt::format("GGX, alpha {:g}", alpha), f, 6.0 * alpha,
        [alpha](int count) { return vmf_terms(ggx_of(alpha, count)); }, directions);
    add_row(table, fmt::format("GGX, alpha {:g}, one wider GGX (closed form)", alpha), [&](double kappa) {
      const double wider = std::sqrt((alpha * alpha + 2.0 / kappa) / (1.0 + 2.0 / kappa));
      return relative_l1(directions, each(directions, [&](double theta) { return reference::ggx(wider, theta); }),
                         each(directions, [&](double theta) { return reference::convolved_ggx(alpha, kappa, theta); }));
    });
  }
  if (brdfs.empty()) return;
  std::vector<std::filesystem::path> files(std::filesystem::directory_iterator(brdfs), {});
  std::sort(files.begin(), files.end());
  for (const std::filesystem::path& file : files) {
    Brdf brdf;
    brdf.kind = BrdfKind::kMeasured;
    brdf.measured = std::make_shared<const MeasuredBrdf>(read_measured_brdf(file.string()));
    const auto f = [&](double e) { return e < 1.0 ? facet_density(brdf, e).x : 0.0; };
    const auto terms = [&](int count) {
      Brdf some = brdf;
      some.term_count = count;
      return vmf_terms(some);
    };
    double half = 1e-4;  // the angle at which f has fallen to half of its peak
    while (half < 0.5 && f(0.5 * half * half) > 0.5 * f(0.0)) half *= 1.2;
    add_terms(table, file.stem().string() + " (red)", f, 6.0 * half, terms, directions);
  }
}

// Makes a table of the errors of spherical harmonics. They are exact for functions up to their order.
std::string harmonics_table(const std::vector<Direction>& directions) {
  constexpr std::array kOrders = {2, 4, 8, 12, 20};
  std::vector<std::string> head = {"harmonics up to order"};
  for (const int order : kOrders) head.push_back(fmt::format("{}", order));
  MarkdownTable table(head);
  const auto add = [&](const std::string& name, double s, double kappa, const Values& reference) {
    Brdf lobe, facets;
    lobe.kind = BrdfKind::kTorranceSparrow;  // the facets have a vMF distribution
    lobe.sigma = static_cast<float>(std::sqrt(0.5 / kappa));
    facets.kind = BrdfKind::kBlinnPhong;
    facets.exponent = static_cast<float>(s > 0.0 ? s : 1.0);
    std::vector<std::string> cells = {name};
    for (const int order : kOrders) {
      const std::vector<glm::dvec3> a = zonal_coefficients(facets, order), g = zonal_coefficients(lobe, order);
      const double scale = s > 0.0 ? 1.0 : kPi;
      cells.push_back(relative_l1(directions,
                                  each(directions,
                                       [&](double theta) {
                                         double sum = 0.0;
                                         for (int l = 0; l <= order; ++l) {
                                           const auto i = static_cast<std::size_t>(l);
                                           sum += (2 * l + 1) / (4.0 * kPi) * scale * a[i].x * g[i].x *
                                                  std::legendre(static_cast<unsigned>(l), std::cos(theta));
                                         }
                                         return std::max(sum, 0.0);
                                       }),
                                  reference));
    }
    table.add(cells);
  };
  for (const double kappa : {12.0, 400.0}) {
    add(fmt::format("Lambert, kappa {:g}", kappa), 0.0, kappa,
        each(directions, [&](double theta) { return reference::convolved_lambert(kappa, theta); }));
    for (const double s : {12.0, 100.0})
      add(fmt::format("Blinn-Phong {:g}, kappa {:g}", s, kappa), s, kappa,
          each(directions, [&](double theta) { return reference::convolved_blinn_phong(s, kappa, theta); }));
  }
  return table.text();
}

// Normals whose weights sum to 1. The weights are a Gaussian over two coordinates, cut off at the limit of valid
// normals.
struct Normals {
  std::vector<glm::dvec3> n;
  std::vector<double> weights;
};

Normals gaussian_normals(double mean_x, double sigma,
                         const std::function<bool(double x, double y, glm::dvec3& n)>& normal) {
  constexpr int kSide = 96;
  constexpr double kReach = 4.5;
  Normals all;
  double total = 0.0;
  for (int i = 0; i < kSide; ++i)
    for (int k = 0; k < kSide; ++k) {
      const double x = kReach * (2.0 * (i + 0.5) / kSide - 1.0), y = kReach * (2.0 * (k + 0.5) / kSide - 1.0);
      glm::dvec3 n;
      if (!normal(mean_x + sigma * x, sigma * y, n)) continue;
      all.n.push_back(n);
      all.weights.push_back(std::exp(-0.5 * (x * x + y * y)));
      total += all.weights.back();
    }
  for (double& weight : all.weights) weight /= total;
  return all;
}

Values shaded(const Normals& normals, const std::vector<Direction>& directions, double s) {
  Values values;
  for (const Direction& d : directions) {
    double sum = 0.0;
    for (std::size_t i = 0; i < normals.n.size(); ++i) {
      const double t = glm::dot(normals.n[i], d.w);
      if (t > 0.0) sum += normals.weights[i] * (s > 0.0 ? (s + 1.0) / (2.0 * kPi) * std::pow(t, s) : t);
    }
    values.push_back(sum);
  }
  return values;
}

// Makes a table of the errors of planar Gaussians and of slope Gaussians, at several tilts.
std::string tilted_table(ShadingKernels& kernels, const std::vector<Direction>& directions) {
  std::vector<std::string> head = {"Gaussian, tilt in degrees"};
  for (const double tilt : kTilts) head.push_back(fmt::format("{:g}", tilt));
  MarkdownTable table(head);
  const auto add = [&](const std::string& name, const std::function<std::string(double tilt)>& error) {
    std::vector<std::string> cells = {name};
    for (const double tilt : kTilts) cells.push_back(error(tilt * kPi / 180.0));
    table.add(cells);
  };
  constexpr double kSigma = 0.1;
  for (const double s : {0.0, 20.0, 100.0, 500.0})
    add(s > 0.0 ? fmt::format("planar Gaussian, Blinn-Phong {:g}", s) : "planar Gaussian, Lambert", [&](double tilt) {
      const Normals normals = gaussian_normals(std::sin(tilt), kSigma, [](double x, double y, glm::dvec3& n) {
        const double square = x * x + y * y;
        n = {x, y, std::sqrt(std::max(1.0 - square, 0.0))};
        return square < 1.0;
      });
      glm::dvec4 lobe(0.0);
      for (std::size_t i = 0; i < normals.n.size(); ++i) {
        const glm::dvec3& n = normals.n[i];
        lobe += normals.weights[i] * glm::dvec4(n.x, n.y, n.x * n.x + n.y * n.y, 1.0);
      }
      return relative_l1(directions, kernels.lobe(glm::vec4(lobe), true, directions, s),
                         shaded(normals, directions, s));
    });
  constexpr std::array kShadings = {std::pair(MULTUM_SHADE_LEAN, "LEAN"),
                                    std::pair(MULTUM_SHADE_LEAN_JACOBIAN, "LEAN with the Jacobian")};
  for (const auto& [shading, words] : kShadings)
    for (const double s : {20.0, 100.0, 500.0})
      add(fmt::format("Gaussian of slopes, {}, Blinn-Phong {:g}", words, s), [&, method = shading](double tilt) {
        const Normals normals = gaussian_normals(-std::tan(tilt), kSigma, [](double x, double y, glm::dvec3& n) {
          n = glm::normalize(glm::dvec3(-x, -y, 1.0));
          return true;
        });
        MultumFilteredMoments moments = {};
        for (std::size_t i = 0; i < normals.n.size(); ++i) {
          const glm::dvec3& n = normals.n[i];
          const double x = -n.x / n.z, y = -n.y / n.z;
          const auto weighted = [&](double value) { return static_cast<float>(normals.weights[i] * value); };
          moments.s += weighted(x), moments.t += weighted(y), moments.st += weighted(x * y);
          moments.ss += weighted(x * x), moments.tt += weighted(y * y);
        }
        moments.share = 1.0f;
        return relative_l1(directions, kernels.moments(moments, method, directions, s), shaded(normals, directions, s));
      });
  return table.text();
}

}  // namespace

std::string formula_section(Device& device, const std::string& brdfs) {
  ShadingKernels kernels(device);
  const std::vector<Direction> round = meridian(), all = hemisphere();
  MarkdownTable lobes(kappa_head());
  add_blinn_phong(lobes, kernels, round);
  add_lambert(lobes, kernels, round);
  add_facets(lobes, round, brdfs);
  return "Each formula is applied to a distribution that has exactly the shape that the formula assumes, so the "
         "whole error comes from the formula. Errors are relative L1 errors in % over the hemisphere. The reference is "
         "a "
         "numerical integral in double precision. The comparison covers only the shape of the convolution, and omits "
         "the factors `n . l`, Fresnel and visibility. The rows for Blinn-Phong, Lambert, Gaussians and moments are "
         "computed by the kernels that measure a bake. tests/agreement shows that the runtime's GLSL code agrees with "
         "these kernels. The other rows are computed in double precision.\n\n" +
         lobes.text() +
         "\nHarmonics are exact up to their order. The next table lists the errors of the harmonics of one "
         "lobe. Negative values are clamped to 0 as in the runtime.\n\n" +
         harmonics_table(round) +
         "\nThe next table lists the errors of planar Gaussians (sigma 0.1 in n_x and n_y) and of slope Gaussians "
         "(sigma 0.1 per slope), tilted towards the rim. The spread of the BRDF is added to the spread of the "
         "normals.\n\n" +
         tilted_table(kernels, all);
}

}  // namespace multum::bench
