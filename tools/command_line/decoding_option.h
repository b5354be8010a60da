// SPDX-License-Identifier: Apache-2.0
// Option --decode child|child:SECONDS[,MEMORY]: limits of the child that decodes images
// (host/formats/image/files/image_file.h) and meshes (host/formats/mesh/mesh_source.h).
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace multum {

/// `as_given`: where the option's text goes too, for programs that this one starts.
void add_decoding_option(CLI::App& app, std::string* as_given = nullptr);

}  // namespace multum
