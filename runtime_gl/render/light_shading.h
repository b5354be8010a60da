// SPDX-License-Identifier: Apache-2.0
// Defines the lights of a scene in a shader by flags for the numbers of lights, and by uniforms.
#pragma once

#include "runtime_gl/materials/material.h"
#include "runtime_gl/render/scene.h"

namespace multum::gl {

ShaderParts light_shader_parts(const RenderScene& scene);
void set_lights(const ShaderProgram& shader, const RenderScene& scene);

}  // namespace multum::gl
