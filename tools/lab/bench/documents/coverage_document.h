// SPDX-License-Identifier: Apache-2.0
// Writes a page about the 95 % intervals of reported errors (host/bakes/accuracy/footprint_error.h). For every normal
// map in a folder and for many settings, the page states how often such an interval contains the error of all
// footprints.
#pragma once

#include <string>

namespace multum::bench {

struct CoverageDocumentOptions {
  std::string output;  // Markdown file
  std::string maps;    // folder of normal maps
  std::string commit;  // commit that the document names
  int side = 256;      // side in texels; larger maps are replaced by a mosaic of this size
  int replicates = 40;
  int map_count = 0;  // number of maps, in the order of their names; all maps if 0
  int threads = 2;
};

int write_coverage_document(const CoverageDocumentOptions& options);

}  // namespace multum::bench
