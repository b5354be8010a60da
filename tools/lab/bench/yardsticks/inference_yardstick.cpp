// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/yardsticks/inference_yardstick.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include "host/foundation/base/error.h"

namespace multum::bench {
namespace {

template <int kOrder>
using Matrix = Eigen::SparseMatrix<float, kOrder, int>;
using Columns = Eigen::Matrix<float, Eigen::Dynamic, 3>;
using Interleaved = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
using InterleavedMap = Eigen::Map<const Interleaved>;

template <int kOrder>
Matrix<kOrder> matrix_of(const SparseRows& rows, std::size_t texel_count) {
  const std::vector<int> begin(rows.begin.begin(), rows.begin.end()), columns(rows.columns.begin(), rows.columns.end());
  return Eigen::Map<const Matrix<Eigen::RowMajor>>(
      static_cast<Eigen::Index>(rows.row_count()), static_cast<Eigen::Index>(texel_count),
      static_cast<Eigen::Index>(columns.size()), begin.data(), columns.data(), rows.weights.data());
}

InterleavedMap mapped(const std::vector<float>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size() / 3), 3};
}

std::vector<float> interleaved(const Interleaved& values) { return {values.data(), values.data() + values.size()}; }

template <int kOrder>
class LeastSquaresYardstick : public InferenceYardstick {
 public:
  LeastSquaresYardstick(const SparseRows& rows, std::size_t texel_count, int threads)
      : threads_(threads), matrix_(matrix_of<kOrder>(rows, texel_count)) {
    solver_.compute(matrix_);
    solver_.setTolerance(0.0f);
  }

  std::vector<float> solve(const std::vector<float>& colours, const std::vector<float>& start,
                           int iteration_count) override {
    Eigen::setNbThreads(threads_);
    solver_.setMaxIterations(iteration_count);
    const Columns b = mapped(colours), from = mapped(start);
    const Columns x = solver_.solveWithGuess(b, from);  // this solves one column after the other
    MULTUM_CHECK(solver_.iterations() == iteration_count);
    return interleaved(x);
  }

 private:
  int threads_;
  Matrix<kOrder> matrix_;
  Eigen::LeastSquaresConjugateGradient<Matrix<kOrder>> solver_;
};

// Follows Eigen 3.4, IterativeLinearSolvers/LeastSquareConjugateGradient.h, line by line, with rows of three scalars.
class ThreeColumnsYardstick : public InferenceYardstick {
 public:
  ThreeColumnsYardstick(const SparseRows& rows, std::size_t texel_count, int threads)
      : threads_(threads), matrix_(matrix_of<Eigen::RowMajor>(rows, texel_count)), transpose_(matrix_.transpose()) {
    const Eigen::VectorXf ones = Eigen::VectorXf::Ones(matrix_.rows());
    const Eigen::ArrayXf squares = (transpose_.cwiseProduct(transpose_) * ones).array();
    inverse_diagonal_ = (squares > 0.0f).select(1.0f / squares, 1.0f);
  }

  std::vector<float> solve(const std::vector<float>& colours, const std::vector<float>& start,
                           int iteration_count) override {
    using Three = Eigen::Array<float, 1, 3>;
    Eigen::setNbThreads(threads_);
    Interleaved x = mapped(start), product(matrix_.rows(), 3), gradient(matrix_.cols(), 3);
    product.noalias() = matrix_ * x;
    Interleaved residual = mapped(colours) - product;
    gradient.noalias() = transpose_ * residual;
    Interleaved p = inverse_diagonal_.matrix().asDiagonal() * gradient, z = p;
    Three now = gradient.cwiseProduct(p).colwise().sum();
    for (int i = 0; i < iteration_count; ++i) {
      product.noalias() = matrix_ * p;
      const Three alpha = now / Three(product.colwise().squaredNorm());
      x += p * alpha.matrix().asDiagonal();
      residual -= product * alpha.matrix().asDiagonal();
      gradient.noalias() = transpose_ * residual;
      z = inverse_diagonal_.matrix().asDiagonal() * gradient;
      const Three before = now;
      now = gradient.cwiseProduct(z).colwise().sum();
      const Three beta = now / before;
      p = z + p * beta.matrix().asDiagonal();
    }
    return interleaved(x);
  }

 private:
  int threads_;
  Matrix<Eigen::RowMajor> matrix_, transpose_;
  Eigen::ArrayXf inverse_diagonal_;
};

}  // namespace

std::string yardstick_name(const YardstickWay& way) {
  const char* form = way.form == YardstickForm::kRowMajor      ? "LSCG per colour, row-major"
                     : way.form == YardstickForm::kColumnMajor ? "LSCG per colour, column-major"
                                                               : "LSCG's iteration on three columns";
  return std::string(form) + ", " + std::to_string(way.threads) + (way.threads == 1 ? " thread" : " threads");
}

std::unique_ptr<InferenceYardstick> make_inference_yardstick(const SparseRows& rows, std::size_t texel_count,
                                                             const YardstickWay& way) {
  switch (way.form) {
    case YardstickForm::kRowMajor:
      return std::make_unique<LeastSquaresYardstick<Eigen::RowMajor>>(rows, texel_count, way.threads);
    case YardstickForm::kColumnMajor:
      return std::make_unique<LeastSquaresYardstick<Eigen::ColMajor>>(rows, texel_count, way.threads);
    case YardstickForm::kThreeColumns: break;
  }
  return std::make_unique<ThreeColumnsYardstick>(rows, texel_count, way.threads);
}

}  // namespace multum::bench
