// SPDX-License-Identifier: Apache-2.0
// Writes pictures, prints a table of errors and times, and writes a report.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "runtime_gl/context/headless_context.h"
#include "tools/multum_view/view_drawing.h"

namespace multum {

/// Refuses output files that cannot be written, or that would overwrite each other or an input. This check runs before
/// anything is drawn, so that no rendering is wasted and no picture is written without its report.
void check_outputs(const MapOptions& options, const ViewScenes& scenes);

/// Writes the sheet. With --pictures, also writes every picture, and its difference from the reference, to its own
/// file.
void write_pictures(const OutputOptions& options, const std::vector<NamedPicture>& pictures);

/// Draws each view of views_of(), prints its table, and writes its pictures. Returns the rows of all views.
nlohmann::json draw_views(const PictureOptions& options, const gl::RenderScene& scene,
                          const std::function<std::vector<NamedPicture>(const gl::RenderScene& scene)>& draw);

/// Prints the table and returns its rows.
nlohmann::json print_table(const std::vector<NamedPicture>& pictures);

/// The contents of a report without its rows.
struct ReportFacts {
  const gl::HeadlessContext& context;
  ComparisonOptions comparison = {};
  bool brdf_is_in_map = false;  // true if each texel of the file has its own roughness, which replaces the scene's
                                // roughness
};
void write_report(const PictureOptions& options, const gl::RenderScene& scene, const ReportFacts& facts,
                  const nlohmann::json& pictures);

/// Writes the shader variants to `path`.
void write_shaders(const std::string& path, const std::vector<gl::ShaderVariant>& variants);

}  // namespace multum
