// SPDX-License-Identifier: Apache-2.0
// Modes of multum-view besides drawing baked maps: each with a command line of its own.
#pragma once

#include "tools/multum_view/view_options.h"

namespace multum {

/// `multum-view --probe REQUEST.json`: measures filter matrices (host/asset/inferred/probe_request.h).
int run_probe(int argc, char** argv);

/// `multum-view FOLDER --sample V,P -o frame.png`: draws objects with the textures inferred for them.
int run_inferred(int argc, char** argv);

/// `multum-view RESULT --thumbnails FOLDER`: small pictures of a job's input and result, for the page of the service.
int run_thumbnails(int argc, char** argv);

/// --mip, --reflectance: a surface coloured straight from a pyramid.
int run_pyramid(ViewOptions& options);
/// --lod: a pyramid of heights or positions as a mesh of one level.
int run_lod(ViewOptions& options);
/// --material: a model with its own materials, each with a map baked for it.
int run_model(ViewOptions& options);

}  // namespace multum
