// SPDX-License-Identifier: Apache-2.0
// Texture inference (Hakura et al. 2000, section 3.2): the mip pyramid x whose picture A x is nearest to the ray-traced
// pixels b, in weighted least squares over one view or several (eq. 4), with range regularisation (eq. 5) and pyramidal
// regularisation (eq. 6).
//
//   f(x) = sum_r c_r |A_r x - b_r|^2 + eps_f (n_s / n_t) Gamma(x)
//          + eps_b (n_s / n_t) / (g(0) - g(1/2)) sum_t g(x_t),     g(x) = 1 / ((x + d)(1 + d - x)), d = 1/512
//
// with c_r the pixel's coverage, 0 <= x <= 1.
//
// Departures: the paper minimises f with the range term inside one nonlinear conjugate gradient. Here Newton steps are
// solved by linear conjugate gradient, values at a bound whose gradient points outwards are held there, and steps end
// at the bounds: the constraint holds exactly, also without the range term, which the paper needs for it and which
// pulls dark texels away from black.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/fields/inference/solver/inference_problem.h"
#include "host/formats/opencl/device.h"

namespace multum {

struct InferenceStep {
  int iteration;          // of conjugate gradient so far
  double objective;       // f(x), all colours
  double gradient_ratio;  // of the projected gradient to that at x = 0, the worst colour
  std::uint64_t held;     // texel colours at a bound
};

struct InferenceResult {
  std::vector<float> texels;  // three a texel, MipLayout's order, 0..1
  bool converged = false;
  int iterations = 0;
  std::vector<InferenceStep> history;  // one entry a Newton step
};

class TextureSystem;

/// The system of one texture seen in some views; solves for any number of right-hand sides.
class TextureInference {
 public:
  /// All matrices are of one texture size and sampler. Throws Error(kInput) when they are not, or when no row is left;
  /// Error(kEnvironment) when the device's memory does not do.
  TextureInference(Device& device, const std::vector<InferenceView>& views, const InferenceSettings& settings,
                   int threads);
  ~TextureInference();
  TextureInference(TextureInference&&) noexcept;

  /// `colours`: three a row, of all views' rows in their order, rows of weight 0 included; 0..1. `start`: three a
  /// texel, of a neighbouring sample, or empty. The result depends on neither the number of threads nor the run.
  InferenceResult solve(const std::vector<float>& colours, const std::vector<float>& start);

  /// A x for every row: three a row.
  std::vector<float> picture(const std::vector<float>& texels) const;

  bool uses_normal_form() const;
  std::size_t row_count() const;
  std::size_t entry_count() const;         // of A
  std::size_t normal_entry_count() const;  // of A^T A, estimated unless it is used

 private:
  std::unique_ptr<TextureSystem> system_;
};

}  // namespace multum
