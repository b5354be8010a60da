// SPDX-License-Identifier: Apache-2.0
// A point of a field's parameter space between its samples: which samples it is made of, and where cameras and objects
// are there.
#pragma once

#include <functional>
#include <vector>

#include <glm/mat4x4.hpp>

#include "host/fields/codec/field_blocks.h"

namespace multum {

/// A sample and how much of it there is; shares of a point sum to 1.
struct SampleShare {
  std::size_t sample;
  float share;
};

/// By index along each parameter. Outside of the grid its nearest point counts.
std::vector<double> clamped_point(const SampleGrid& grid, std::vector<double> point);

/// The sample nearest to a clamped point (of two as near the later).
std::size_t nearest_sample(const SampleGrid& grid, const std::vector<double>& point);

/// The nearest sample first, then all others between which the point lies, each by the product of what it is along each
/// parameter (linear). Not `linear`: the nearest alone.
std::vector<SampleShare> sample_shares(const SampleGrid& grid, const std::vector<double>& point, bool linear);

/// A rotation with sizes, and a position, on the way from one to the other at `share`, 0..1: the rotation by slerp,
/// sizes and position linearly. Matrices that shear go linearly as a whole.
glm::dmat4 place_between(const glm::dmat4& from, const glm::dmat4& to, double share);

/// The same of a perspective camera, world to clip: where it is linearly, how it is turned by slerp, what its
/// projection has linearly. Matrices that are no such camera go linearly as a whole.
glm::dmat4 camera_between(const glm::dmat4& from, const glm::dmat4& to, double share);

using MatrixBetween = glm::dmat4 (*)(const glm::dmat4&, const glm::dmat4&, double);

/// The matrix at a clamped point, of those of the samples around it, one parameter after another. At a sample it is
/// that sample's, to the bit.
glm::dmat4 matrix_at(const SampleGrid& grid, const std::vector<double>& point,
                     const std::function<glm::dmat4(std::size_t sample)>& of_sample, MatrixBetween between);

}  // namespace multum
