// SPDX-License-Identifier: Apache-2.0
// Makes a page of how often the 95 % interval of a stated error (host/bakes/accuracy/footprint_error.h) holds what
// all footprints say, for every normal map of a folder and many settings.
#pragma once

#include <string>

namespace multum::bench {

struct CoverageDocumentOptions {
  std::string output;  // Markdown file
  std::string maps;    // folder of normal maps
  std::string commit;  // named in the document
  int side = 256;      // texels: of larger maps a mosaic this large is baked
  int replicates = 40;
  int map_count = 0;  // of the folder's, the first by name; 0: all
  int threads = 2;
};

int write_coverage_document(const CoverageDocumentOptions& options);

}  // namespace multum::bench
