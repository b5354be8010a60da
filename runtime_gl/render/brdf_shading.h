// SPDX-License-Identifier: Apache-2.0
// A BRDF in a shader: a file of shaders/brdf with its flag, and uniforms.
#pragma once

#include "host/brdf/brdf.h"
#include "runtime_gl/materials/material.h"

namespace multum::gl {

ShaderParts brdf_shader_parts(const Brdf& brdf);
/// `zonal_order`: that of the material (Material::zonal_order).
void set_brdf(const ShaderProgram& shader, const Brdf& brdf, int zonal_order);

}  // namespace multum::gl
