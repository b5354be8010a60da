// SPDX-License-Identifier: Apache-2.0
// The files that assimp may open for a model. These are the model itself, and regular files beneath its folder. For
// assimp, names with "..", absolute names, links that lead out of the folder, FIFOs and devices do not exist. assimp
// then omits the materials of an OBJ file, and rejects a model that cannot be read without the missing file.
#pragma once

#include <string>

#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>

namespace multum {

class ModelFiles : public Assimp::IOSystem {
 public:
  explicit ModelFiles(std::string model);

  bool Exists(const char* name) const override;
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* mode) override;
  void Close(Assimp::IOStream* stream) override;

 private:
  const std::string model_, folder_;
};

}  // namespace multum
