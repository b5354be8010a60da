// SPDX-License-Identifier: Apache-2.0
// The lights of a scene in a shader: flags for their numbers, and uniforms.
#pragma once

#include "runtime_gl/materials/material.h"
#include "runtime_gl/render/scene.h"

namespace multum::gl {

ShaderParts light_shader_parts(const RenderScene& scene);
void set_lights(const ShaderProgram& shader, const RenderScene& scene);

}  // namespace multum::gl
