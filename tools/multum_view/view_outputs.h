// SPDX-License-Identifier: Apache-2.0
// Writes pictures, a table of errors and times, a report.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "runtime_gl/context/headless_context.h"
#include "tools/multum_view/view_drawing.h"

namespace multum {

/// Refuses, before anything is drawn, file names that would overwrite each other or what is read, or that cannot be
/// written: nothing is rendered for nothing, and no picture is left beside a report that failed.
void check_outputs(const MapOptions& options, const ViewScenes& scenes);

/// The sheet, and with --pictures every picture, and what it is off by, in a file of its own.
void write_pictures(const OutputOptions& options, const std::vector<NamedPicture>& pictures);

/// Draws, prints and writes each of views_of(); returns the rows of all.
nlohmann::json draw_views(const PictureOptions& options, const gl::RenderScene& scene,
                          const std::function<std::vector<NamedPicture>(const gl::RenderScene& scene)>& draw);

/// Prints it, and returns its rows.
nlohmann::json print_table(const std::vector<NamedPicture>& pictures);

/// What a report says besides its rows.
struct ReportFacts {
  const gl::HeadlessContext& context;
  ComparisonOptions comparison = {};
  bool brdf_is_in_map = false;  // each texel of the file has its own roughness, whatever the scene says
};
void write_report(const PictureOptions& options, const gl::RenderScene& scene, const ReportFacts& facts,
                  const nlohmann::json& pictures);

/// To `path`.
void write_shaders(const std::string& path, const std::vector<gl::ShaderVariant>& variants);

}  // namespace multum
