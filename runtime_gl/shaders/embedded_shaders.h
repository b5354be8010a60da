// SPDX-License-Identifier: Apache-2.0
// Returns the texts of the files in this folder, which are embedded at build time. The texts have no version line.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace multum::gl {

/// Returns the texts of brdf/, keyed by file, such as "ggx.glsl". Each text is followed by a 0 byte, which is not part
/// of its view.
const std::map<std::string, std::string_view>& brdf_shaders();
/// Returns the text of a file that must exist.
inline const char* brdf_shader_text(std::string_view file) { return brdf_shaders().at(std::string(file)).data(); }

extern const char* const shader_common_movmf_shading_glsl;
extern const char* const shader_common_gmm_shading_glsl;
extern const char* const shader_common_moment_shading_glsl;
extern const char* const shader_common_blue_noise_glsl;
extern const char* const shader_common_evaluations_glsl;
extern const char* const shader_common_footprint_glsl;
extern const char* const shader_common_reflection_glsl;
extern const char* const shader_common_sh_shading_glsl;
extern const char* const shader_common_texture_filter_glsl;
extern const char* const shader_common_pyramid_glsl;
extern const char* const shader_common_vmf_zonal_glsl;
extern const char* const shader_surface_lobes_glsl;
extern const char* const shader_surface_gmm_glsl;
extern const char* const shader_surface_movmf_glsl;
extern const char* const shader_surface_normals_glsl;
extern const char* const shader_surface_roughness_texture_glsl;
extern const char* const shader_surface_sh_glsl;
extern const char* const shader_light_environment_glsl;
extern const char* const shader_light_environment_frame_glsl;
extern const char* const shader_light_environment_levels_glsl;
extern const char* const shader_light_environment_samples_glsl;
extern const char* const shader_light_environment_sh_glsl;
extern const char* const shader_light_lights_glsl;
extern const char* const shader_scene_vert;
extern const char* const shader_scene_frag;
extern const char* const shader_pyramid_frag;
extern const char* const shader_full_screen_vert;
extern const char* const shader_accumulate_frag;
extern const char* const shader_textured_vert;
extern const char* const shader_textured_frag;
extern const char* const shader_filter_probe_frag;
extern const char* const shader_layer_sum_frag;
extern const char* const shader_sub_pixel_mean_frag;

}  // namespace multum::gl
