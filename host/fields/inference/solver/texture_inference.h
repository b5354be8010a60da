// SPDX-License-Identifier: Apache-2.0
// Infers textures (Hakura et al. 2000, section 3.2): finds the mip pyramid x whose picture A x is nearest to the
// ray-traced pixels b, in weighted least squares over one view or several (eq. 4). Range regularization (eq. 5) and
// pyramidal regularization (eq. 6) are added:
//
//   f(x) = sum_r c_r |A_r x - b_r|^2 + eps_f (n_s / n_t) Gamma(x)
//          + eps_b (n_s / n_t) / (g(0) - g(1/2)) sum_t g(x_t),     g(x) = 1 / ((x + d)(1 + d - x)), d = 1/512
//
// where c_r is the pixel's coverage and 0 <= x <= 1.
//
// Departures: The paper minimizes f, including the range term, with one run of nonlinear conjugate gradient. Here
// linear conjugate gradient solves Newton steps. Steps end at the bounds, and values at a bound are held there while
// their gradient points outwards. The constraint then holds exactly, even without the range term. The paper needs the
// range term for this constraint, but that term pulls dark texels away from black.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/fields/inference/solver/inference_problem.h"
#include "host/formats/opencl/device.h"

namespace multum {

struct InferenceStep {
  int iteration;          // conjugate gradient iterations so far
  double objective;       // f(x), summed over all colours
  double gradient_ratio;  // ratio of the projected gradient to the gradient at x = 0, for the worst colour
  std::uint64_t held;     // texel colours at a bound
};

struct InferenceResult {
  std::vector<float> texels;  // three per texel in the order of MipLayout, 0..1
  bool converged = false;
  int iterations = 0;
  std::vector<InferenceStep> history;  // one entry per Newton step
};

class TextureSystem;

/// The system of one texture seen in some views. It can be solved for any number of right-hand sides.
class TextureInference {
 public:
  /// All matrices must have the same texture size and sampler. Throws Error(kInput) if they do not, or if no row is
  /// left. Throws Error(kEnvironment) if the device has too little memory.
  TextureInference(Device& device, const std::vector<InferenceView>& views, const InferenceSettings& settings,
                   int threads);
  ~TextureInference();
  TextureInference(TextureInference&&) noexcept;

  /// `colours` has three values of 0..1 per row, for the rows of all views in order, including rows with weight 0.
  /// `start` is either empty or has three values per texel, which come from a neighbouring sample. The result is the
  /// same in every run and with any number of threads.
  InferenceResult solve(const std::vector<float>& colours, const std::vector<float>& start);

  /// Returns A x for every row, with three values per row.
  std::vector<float> picture(const std::vector<float>& texels) const;

  bool uses_normal_form() const;
  std::size_t row_count() const;
  std::size_t entry_count() const;         // number of entries of A
  std::size_t normal_entry_count() const;  // number of entries of A^T A; only an estimate if A^T A is not used

 private:
  std::unique_ptr<TextureSystem> system_;
};

}  // namespace multum
