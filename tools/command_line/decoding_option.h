// SPDX-License-Identifier: Apache-2.0
// --decode child|child:SECONDS|here: where images (host/image/image_file.h) and meshes (host/mesh/mesh_source.h) are
// decoded.
#pragma once

#include <CLI/CLI.hpp>

namespace multum {

/// In a child unless the option says otherwise: multum-decode beside this program. `as_given`: where the option's text
/// goes, for programs that are started in turn; null: nowhere.
void add_decoding_option(CLI::App& app, std::string* as_given = nullptr);
/// The default, for what has no command line of its own.
void decode_in_child();

}  // namespace multum
