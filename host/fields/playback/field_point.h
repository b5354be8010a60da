// SPDX-License-Identifier: Apache-2.0
// Interpolates at a point of a field's parameter space. Computes the shares of samples, and the cameras and objects at
// the point.
#pragma once

#include <functional>
#include <vector>

#include <glm/mat4x4.hpp>

#include "host/fields/codec/field_blocks.h"

namespace multum {

/// A sample and its share at a point. The shares at a point sum to 1.
struct SampleShare {
  std::size_t sample;
  float share;
};

/// Returns indices along each parameter. A point outside the grid becomes the nearest point of the grid.
std::vector<double> clamped_point(const SampleGrid& grid, std::vector<double> point);

/// Returns the sample nearest to a clamped point. If two samples are equally near, returns the later one.
std::size_t nearest_sample(const SampleGrid& grid, const std::vector<double>& point);

/// Returns the nearest sample first, then all others around the point. The share of each sample is the product of its
/// linear shares along the parameters. Without `linear`, returns only the nearest sample.
std::vector<SampleShare> sample_shares(const SampleGrid& grid, const std::vector<double>& point, bool linear);

/// Interpolates an object's rotation by slerp, and its sizes and position linearly, at `share` of 0..1. Matrices with
/// shear are interpolated linearly as a whole.
glm::dmat4 place_between(const glm::dmat4& from, const glm::dmat4& to, double share);

/// Interpolates the world-to-clip matrix of a perspective camera. The rotation is interpolated by slerp, and the
/// position and the projection are interpolated linearly. Other matrices are interpolated linearly as a whole.
glm::dmat4 camera_between(const glm::dmat4& from, const glm::dmat4& to, double share);

using MatrixBetween = glm::dmat4 (*)(const glm::dmat4&, const glm::dmat4&, double);

/// Interpolates the matrices of the samples around a clamped point, one parameter after another. At a sample the result
/// equals the sample's matrix bit by bit.
glm::dmat4 matrix_at(const SampleGrid& grid, const std::vector<double>& point,
                     const std::function<glm::dmat4(std::size_t sample)>& of_sample, MatrixBetween between);

}  // namespace multum
