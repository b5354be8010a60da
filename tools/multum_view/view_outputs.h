// SPDX-License-Identifier: Apache-2.0
// Writes the outputs of multum-view: pictures, a table of errors and times, a report.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "tools/multum_view/view_drawing.h"

namespace multum {

/// Refuses, before anything is drawn, file names that would overwrite each other or what is read, or that cannot be
/// written: nothing is rendered for nothing, and no picture is left beside a report that failed.
void check_outputs(const ViewOptions& options);

/// The sheet, and with --pictures every picture, and what it is off by, in a file of its own.
void write_pictures(const ViewOptions& options, const std::vector<NamedPicture>& pictures);

/// Draws, prints and writes each of views_of(); returns the rows of all.
nlohmann::json draw_views(const ViewOptions& options,
                          const std::function<std::vector<NamedPicture>(const ViewOptions& view)>& draw);

/// Prints it, and returns its rows.
nlohmann::json print_table(const std::vector<NamedPicture>& pictures);

/// `context`: how GL describes itself.
void write_report(const ViewOptions& options, const std::string& context, const nlohmann::json& pictures);

/// To options.shaders.
void write_shaders(const ViewOptions& options, const std::vector<gl::ShaderVariant>& variants);

}  // namespace multum
