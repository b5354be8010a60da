// SPDX-License-Identifier: Apache-2.0
// The files that assimp may open for a model: the model itself, and regular files beneath its folder. What a model
// names otherwise - by "..", an absolute name, a link that leads out of the folder, a FIFO or a device - is not there
// for assimp: it leaves out an OBJ file's materials, and refuses a model that needs the file.
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
