// SPDX-License-Identifier: Apache-2.0
// Writes a page that states how often the 95 % interval of a stated error (host/bakes/accuracy/footprint_error.h)
// contains the error of all footprints, for every normal map of a folder and many settings.
#pragma once

#include <string>

namespace multum::bench {

struct CoverageDocumentOptions {
  std::string output;  // Markdown file
  std::string maps;    // folder of normal maps
  std::string commit;  // named in the document
  int side = 256;      // texels: larger maps are replaced by a mosaic of this size
  int replicates = 40;
  int map_count = 0;  // only the first maps of the folder, by name; 0: all
  int threads = 2;
};

int write_coverage_document(const CoverageDocumentOptions& options);

}  // namespace multum::bench
