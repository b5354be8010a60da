// SPDX-License-Identifier: Apache-2.0
// Adds --decode child|child:SECONDS[,MEMORY]: limits of the child process that decodes images
// (host/formats/image/files/image_file.h) and meshes (host/formats/mesh/mesh_source.h).
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace multum {

/// `as_given`, if not null, gets the text of the option, for programs that this one starts.
void add_decoding_option(CLI::App& app, std::string* as_given = nullptr);

}  // namespace multum
