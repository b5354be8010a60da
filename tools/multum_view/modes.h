// SPDX-License-Identifier: Apache-2.0
// What multum-view does besides drawing baked maps: each with a command line of its own.
#pragma once

namespace multum {

/// `multum-view --probe REQUEST.json`: measures filter matrices (host/asset/probe_request.h).
int run_probe(int argc, char** argv);

/// `multum-view FOLDER --sample V,P -o frame.png`: draws objects with the textures inferred for them.
int run_inferred(int argc, char** argv);

/// `multum-view RESULT --thumbnails FOLDER`: small pictures of a job's input and result, for the page of the service.
int run_thumbnails(int argc, char** argv);

}  // namespace multum
