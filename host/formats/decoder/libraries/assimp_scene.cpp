// SPDX-License-Identifier: Apache-2.0
#include "host/formats/decoder/libraries/assimp_scene.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <exception>
#include <mutex>

#include "host/formats/decoder/libraries/model_files.h"
#include "host/formats/mesh/gltf_check.h"
#include "host/foundation/base/files/regular_file.h"
#include "host/foundation/sandbox/damaged_file.h"

namespace multum {
namespace {

/// Listens to assimp's log, because only the log tells whether assimp dropped triangles with indices out of range. The
/// log belongs to the process, so only one import at a time may listen.
class ImportLog {
 public:
  ImportLog() {
    Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0);
    Assimp::DefaultLogger::get()->attachStream(new Listener(&warnings_),
                                               Assimp::Logger::Warn);  // the logger owns the listener
  }
  ~ImportLog() { Assimp::DefaultLogger::kill(); }
  ImportLog(const ImportLog&) = delete;
  ImportLog& operator=(const ImportLog&) = delete;
  bool dropped_triangles() const { return warnings_.find("out-of-range indices") != std::string::npos; }

 private:
  class Listener : public Assimp::LogStream {
   public:
    explicit Listener(std::string* warnings) : warnings_(warnings) {}
    void write(const char* message) override { *warnings_ += message; }

   private:
    std::string* warnings_;
  };
  std::string warnings_;
};

// Reports a lack of memory, which is not a fault of the file. assimp catches the exceptions of its readers.
void rethrow_hunger(const std::string& path, const std::exception_ptr& thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    throw NotEnoughMemory(path);
  } catch (...) {  // the error string contains the reason
  }
}

}  // namespace

MeshImport::MeshImport(const std::string& path, unsigned steps) : importer_(std::make_unique<Assimp::Importer>()) {
  open_regular_file(path);  // otherwise, assimp's message would only say that it cannot open the file
  check_gltf_file(path);
  importer_->SetIOHandler(new ModelFiles(path));  // the importer owns the handler
  static std::mutex log_mutex;
  const std::lock_guard<std::mutex> lock(log_mutex);
  const ImportLog log;
  scene_ = importer_->ReadFile(path, steps);
  if (log.dropped_triangles()) refuse_file(path, "has triangles with indices out of range");
  if (scene_ == nullptr && importer_->GetException()) rethrow_hunger(path, importer_->GetException());
  if (scene_ == nullptr) refuse_file(path, std::string("cannot be read as a mesh: ") + importer_->GetErrorString());
}

MeshImport::~MeshImport() = default;

}  // namespace multum
