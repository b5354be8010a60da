// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/solver/texture_inference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "host/fields/inference/solver/texture_start.h"
#include "host/fields/inference/solver/texture_system.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr double kDelta = 1.0 / 512;  // d of eq. (5)
// The number of partial sums. The number is the same for every device, so that results do not depend on the device. It
// is large enough to keep a GPU busy. With 64 partial sums, an iteration on an H100 took 2.5 ms, of which its matrix
// products took only 0.04 ms (docs/evidence/GPU.md).
constexpr std::size_t kPartCount = 2048, kPartsAGroup = 32;
constexpr int kHalvingsMax = 12;  // most halvings of a Newton step that leads uphill

using Sums = std::array<double, 3>;

// Computes g, g' and g'' of eq. (5). With u = x + d and v = 1 + d - x, g = 1 / (u v), g' = g (1/v - 1/u), g'' = 2 g
// (1/u^2 - 1/(u v) + 1/v^2).
struct RangeTerm {
  double value, slope, curvature;
};

RangeTerm range_term(double x) {
  const double u = 1.0 / (x + kDelta), v = 1.0 / (1.0 + kDelta - x), g = u * v;
  return {g, g * (v - u), 2.0 * g * (u * u - u * v + v * v)};
}

double norm(const Sums& squares, std::size_t colour) { return std::sqrt(std::max(0.0, squares[colour])); }

// The vectors of one solution on the device.
class Solver {
 public:
  Solver(TextureSystem& system, const std::vector<float>& colours, const std::vector<float>& start)
      : system_(system),
        device_(system.device),
        texel_count_(static_cast<std::size_t>(system.layout.texel_count)),
        range_weight_(system.settings.range_weight * static_cast<double>(system.row_count()) /
                      static_cast<double>(texel_count_) / (range_term(0.0).value - range_term(0.5).value)),
        target_(system.projected(colours, &colour_squares_)),
        parts_(device_.make_buffer(2 * kPartCount * sizeof(Colour4), "partial sums")) {
    for (DeviceBuffer* buffer : {&x_, &gradient_, &free_, &curvature_, &inverse_, &step_, &r_, &p_, &q_})
      *buffer = system.make_texels("vectors of conjugate gradient");
    const std::vector<float> texels =
        start.empty() ? start_texels(system.layout, target_, system.column_sums()) : start;
    MULTUM_CHECK(texels.size() == 3 * texel_count_);
    values_.resize(texel_count_);
    for (std::size_t t = 0; t < texel_count_; ++t)
      for (std::size_t c = 0; c < 3; ++c) values_[t][c] = std::clamp(texels[3 * t + c], 0.0f, 1.0f);
    for (std::size_t c = 0; c < 3; ++c)
      for (const Colour4& value : target_)
        target_squares_[c] += static_cast<double>(value[c]) * static_cast<double>(value[c]);
  }

  InferenceResult run() {
    InferenceResult result;
    double objective = evaluate(values_);
    for (int newton = 0;; ++newton) {
      const std::uint64_t held = hold_at_bounds();
      const double ratio = gradient_ratio();
      result.history.push_back({result.iterations, objective, ratio, held});
      result.converged = ratio <= system_.settings.gradient_tolerance;
      if (result.converged || newton == system_.settings.newton_max ||
          result.iterations >= system_.settings.iteration_max)
        break;
      result.iterations += find_step(system_.settings.iteration_max - result.iterations);
      if (!take_step(objective)) break;
    }
    result.texels.reserve(3 * texel_count_);
    for (const Colour4& value : values_) result.texels.insert(result.texels.end(), value.begin(), value.begin() + 3);
    return result;
  }

 private:
  void upload(DeviceBuffer& buffer, const std::vector<Colour4>& list) {
    device_.write(buffer, list.data(), buffer.byte_count());
  }
  std::vector<Colour4> download(const DeviceBuffer& buffer) {
    std::vector<Colour4> list(texel_count_);
    device_.read(buffer, list.data(), buffer.byte_count());
    return list;
  }
  // Reads one or two lists of partial sums.
  template <std::size_t kCount>
  std::array<Sums, kCount> read_sums() {
    std::array<Colour4, kCount * kPartCount> list;
    device_.read(parts_, list.data(), sizeof(list));
    std::array<Sums, kCount> sums{};
    for (std::size_t i = 0; i < list.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) sums[i / kPartCount][c] += static_cast<double>(list[i][c]);
    return sums;
  }

  // Computes half the gradient at x, and returns f(x) = x.(H x) - 2 x.(A^T b) + b.b plus the range terms. One matrix
  // product gives both.
  double evaluate(const std::vector<Colour4>& x) {
    upload(x_, x);
    system_.apply(x_, gradient_);
    half_gradient_ = download(gradient_);
    double objective = colour_squares_[0] + colour_squares_[1] + colour_squares_[2];
    for (std::size_t t = 0; t < texel_count_; ++t)
      for (std::size_t c = 0; c < 3; ++c) {
        const double value = static_cast<double>(x[t][c]);
        objective += value * (static_cast<double>(half_gradient_[t][c]) - 2.0 * static_cast<double>(target_[t][c]));
        half_gradient_[t][c] -= target_[t][c];
        if (range_weight_ == 0.0) continue;
        const RangeTerm range = range_term(value);
        objective += range_weight_ * range.value;
        half_gradient_[t][c] += static_cast<float>(0.5 * range_weight_ * range.slope);
      }
    return objective;
  }

  // Marks the values that may move, and prepares the diagonal. A value at a bound is kept there if its gradient points
  // outwards.
  std::uint64_t hold_at_bounds() {
    std::uint64_t held = 0;
    std::vector<Colour4> is_free(texel_count_, Colour4{}), inverse(texel_count_, Colour4{}),
        curvature(texel_count_, Colour4{});
    for (std::size_t t = 0; t < texel_count_; ++t)
      for (std::size_t c = 0; c < 3; ++c) {
        const float x = values_[t][c], g = half_gradient_[t][c];
        const bool is_held = (x <= 0.0f && g > 0.0f) || (x >= 1.0f && g < 0.0f);
        held += is_held ? 1 : 0;
        is_free[t][c] = is_held ? 0.0f : 1.0f;
        if (range_weight_ > 0.0)
          curvature[t][c] = static_cast<float>(0.5 * range_weight_ * range_term(static_cast<double>(x)).curvature);
        const float diagonal = system_.diagonal[t] + curvature[t][c];
        // Without pyramidal regularization, invisible texels do not change. The same is true if the regularization is
        // so weak that the inverse of the diagonal would be infinite.
        if (is_held || !(diagonal >= std::numeric_limits<float>::min())) continue;
        inverse[t][c] = system_.settings.precondition ? 1.0f / diagonal : 1.0f;
      }
    upload(free_, is_free);
    upload(curvature_, curvature);
    upload(inverse_, inverse);
    is_bounded_ = held > 0 || range_weight_ > 0.0;
    free_values_ = std::move(is_free);
    return held;
  }

  Sums projected_gradient_squares() const {
    Sums squares{0.0, 0.0, 0.0};
    for (std::size_t t = 0; t < texel_count_; ++t)
      for (std::size_t c = 0; c < 3; ++c) {
        const double g = static_cast<double>(free_values_[t][c]) * static_cast<double>(half_gradient_[t][c]);
        squares[c] += g * g;
      }
    return squares;
  }

  double gradient_ratio() const {
    const Sums squares = projected_gradient_squares();
    double ratio = 0.0;
    for (std::size_t c = 0; c < 3; ++c)
      if (target_squares_[c] > 0.0) ratio = std::max(ratio, norm(squares, c) / norm(target_squares_, c));
    return ratio;
  }

  // Solves H step = -gradient over the free values, until the residual is below a given fraction of the gradient. More
  // precision is not useful, because values that leave their range change the problem. Returns the number of
  // iterations.
  int find_step(int iteration_max) {
    const Sums before = projected_gradient_squares();
    Sums goal;
    for (std::size_t c = 0; c < 3; ++c) {
      const double share = system_.settings.step_tolerance * norm(before, c);
      const double end = 0.5 * system_.settings.gradient_tolerance * norm(target_squares_, c);
      goal[c] = std::max(share, end) * std::max(share, end);
    }
    std::vector<Colour4> r(texel_count_);
    for (std::size_t t = 0; t < texel_count_; ++t)
      for (std::size_t c = 0; c < 3; ++c) r[t][c] = -free_values_[t][c] * half_gradient_[t][c];
    upload(r_, r);
    for (DeviceBuffer* buffer : {&step_, &p_, &q_}) device_.fill_zero(*buffer);
    auto [products, norms] = advance_residual({});  // r.(M r) and r.r
    advance_direction({}, {});                      // p = M r
    int iteration = 0;
    for (; iteration < iteration_max; ++iteration) {
      bool is_done = true;
      for (std::size_t c = 0; c < 3; ++c) is_done = is_done && !(norms[c] > goal[c]);  // NaN also ends the loop
      if (is_done) break;
      system_.apply(p_, q_);
      const Sums curvatures = curvature_product();
      Sums alpha{0.0, 0.0, 0.0}, beta{0.0, 0.0, 0.0};
      // A colour does not move if it is solved or its curvature is zero.
      for (std::size_t c = 0; c < 3; ++c)
        if (curvatures[c] > 0.0 && norms[c] > goal[c]) alpha[c] = products[c] / curvatures[c];
      const Sums last = products;
      std::tie(products, norms) = advance_residual(alpha);
      for (std::size_t c = 0; c < 3; ++c)
        if (last[c] > 0.0) beta[c] = products[c] / last[c];
      advance_direction(alpha, beta);
    }
    return iteration;
  }

  static Colour4 rounded(const Sums& values) {
    return {static_cast<float>(values[0]), static_cast<float>(values[1]), static_cast<float>(values[2]), 0.0f};
  }
  Sums curvature_product() {
    system_.curvature_product.launch({kPartCount, kPartsAGroup}, p_, q_, curvature_, free_, parts_, is_bounded_ ? 1 : 0,
                                     static_cast<int>(texel_count_), static_cast<int>(kPartCount));
    return read_sums<1>()[0];
  }
  std::pair<Sums, Sums> advance_residual(const Sums& alpha) {
    system_.advance_residual.launch({kPartCount, kPartsAGroup}, r_, q_, inverse_, parts_, rounded(alpha),
                                    static_cast<int>(texel_count_), static_cast<int>(kPartCount));
    const auto sums = read_sums<2>();
    return {sums[0], sums[1]};
  }
  void advance_direction(const Sums& alpha, const Sums& beta) {
    system_.advance_direction.launch({texel_count_, 256}, step_, p_, r_, inverse_, rounded(alpha), rounded(beta),
                                     static_cast<int>(texel_count_));
  }

  // Sets x = x + step, clamped to the bounds, and halves the step while it leads uphill. Returns false if even the
  // shortest step leads uphill.
  bool take_step(double& objective) {
    const std::vector<Colour4> step = download(step_), from = values_;
    // Allows for the single-precision error of the objective.
    const double slack = 1e-6 * (colour_squares_[0] + colour_squares_[1] + colour_squares_[2]);
    float length = 1.0f;
    for (int halving = 0; halving <= kHalvingsMax; ++halving, length *= 0.5f) {
      for (std::size_t t = 0; t < texel_count_; ++t)
        for (std::size_t c = 0; c < 3; ++c) values_[t][c] = std::clamp(from[t][c] + length * step[t][c], 0.0f, 1.0f);
      const double found = evaluate(values_);
      if (found <= objective + slack) {
        objective = found;
        return true;
      }
    }
    values_ = from;
    objective = evaluate(values_);
    return false;
  }

  TextureSystem& system_;
  Device& device_;
  const std::size_t texel_count_;
  double range_weight_;                 // weight that includes every factor of the sum of g
  Sums colour_squares_{0.0, 0.0, 0.0};  // b.b
  const std::vector<Colour4> target_;   // A^T b
  Sums target_squares_{0.0, 0.0, 0.0};
  std::vector<Colour4> values_, half_gradient_, free_values_;
  bool is_bounded_ = false;  // some value is held at a bound, or the range term curves f
  DeviceBuffer parts_;
  DeviceBuffer x_, gradient_, free_, curvature_, inverse_, step_, r_, p_, q_;
};

}  // namespace

TextureInference::TextureInference(Device& device, const std::vector<InferenceView>& views,
                                   const InferenceSettings& settings, int threads)
    : system_(std::make_unique<TextureSystem>(device, views, settings, threads)) {}
TextureInference::~TextureInference() = default;
TextureInference::TextureInference(TextureInference&&) noexcept = default;

InferenceResult TextureInference::solve(const std::vector<float>& colours, const std::vector<float>& start) {
  return Solver(*system_, colours, start).run();
}

std::vector<float> TextureInference::picture(const std::vector<float>& texels) const {
  return system_->picture(texels);
}
bool TextureInference::uses_normal_form() const { return system_->uses_normal; }
std::size_t TextureInference::row_count() const { return system_->row_count(); }
std::size_t TextureInference::entry_count() const { return system_->entry_count; }
std::size_t TextureInference::normal_entry_count() const { return system_->normal_entry_count; }

}  // namespace multum
