// SPDX-License-Identifier: Apache-2.0
// Adds --decode child|child:SECONDS[,MEMORY], which limits the child process that decodes images
// (host/formats/image/files/image_file.h) and meshes (host/formats/mesh/mesh_source.h).
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace multum {

/// If `as_given` is not null, it receives the text of the option, which can be passed to programs that this program
/// starts.
void add_decoding_option(CLI::App& app, std::string* as_given = nullptr);

}  // namespace multum
