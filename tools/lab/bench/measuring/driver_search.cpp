// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/measuring/driver_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/processes/child_process.h"

namespace multum::bench {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolders[] = {
    "/usr/local/nvidia/lib64", "/usr/lib/x86_64-linux-gnu", "/usr/lib64", "/usr/lib", "/usr/lib/wsl/lib",
    "/opt/rocm/lib",           "/opt/amdgpu/lib64"};
constexpr const char* kOpenclLibraries[] = {"libnvidia-opencl.so.1", "libamdocl64.so", "libigdrcl.so", "libpocl.so.2"};
constexpr const char* kEglLibraries[] = {"libEGL_nvidia.so.0", "libEGL_mesa.so.0"};
constexpr const char* kOpenclVendors = "/etc/OpenCL/vendors";
constexpr const char* kEglVendors[] = {"/etc/glvnd/egl_vendor.d", "/usr/share/glvnd/egl_vendor.d",
                                       "/usr/local/nvidia/share/glvnd/egl_vendor.d"};

std::string text_of(const fs::path& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<fs::path> files_of(const fs::path& folder, const std::string& extension) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == extension) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

// Returns one line per library, such as "libEGL.so.1 (libc6,x86-64) => /usr/lib/...". Without ldconfig, the text is
// empty.
std::string loader_list() {
  for (const char* program : {"/sbin/ldconfig", "/usr/sbin/ldconfig"}) {
    try {
      const ChildResult result = run_child({program, "-p"});
      if (result.exit_code == 0) return result.output;
    } catch (const Error&) {  // the program does not exist
    }
  }
  return "";
}

std::string find_library(const std::string& list, const std::string& name) {
  std::istringstream lines(list);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t arrow = line.find(" => ");
    if (arrow != std::string::npos && line.find("\t" + name + " ") == 0) return line.substr(arrow + 4);
  }
  std::error_code error;
  for (const char* folder : kFolders)
    if (fs::exists(fs::path(folder) / name, error)) return (fs::path(folder) / name).string();
  return "";
}

std::string naming_file(const std::vector<fs::path>& files, const std::string& library) {
  for (const fs::path& file : files)
    if (text_of(file).find(library) != std::string::npos) return file.string();
  return "";
}

std::vector<fs::path> egl_files() {
  std::vector<fs::path> files;
  for (const char* folder : kEglVendors)
    for (const fs::path& file : files_of(folder, ".json")) files.push_back(file);
  return files;
}

std::vector<FoundDriver> find_all(const std::string& list, const auto& names, const std::vector<fs::path>& files) {
  std::vector<FoundDriver> found;
  for (const char* name : names) {
    const std::string library = find_library(list, name);
    if (!library.empty()) found.push_back({library, naming_file(files, name)});
  }
  return found;
}

// libglvnd reads only the first two folders.
bool is_looked_at(const std::string& file) {
  return file.starts_with(kEglVendors[0]) || file.starts_with(kEglVendors[1]);
}

}  // namespace

DriverSearch find_drivers() {
  const std::string list = loader_list();
  return {find_all(list, kOpenclLibraries, files_of(kOpenclVendors, ".icd")),
          find_all(list, kEglLibraries, egl_files())};
}

void name_drivers(const DriverSearch& found, const std::string& folder) {
  const auto unnamed = [](const FoundDriver& driver) { return driver.named_by.empty(); };
  if (std::any_of(found.opencl.begin(), found.opencl.end(), unnamed) && std::getenv("OCL_ICD_VENDORS") == nullptr) {
    const fs::path vendors = fs::path(folder) / "vendors";
    fs::create_directories(vendors);
    for (const fs::path& file : files_of(kOpenclVendors, ".icd")) fs::copy_file(file, vendors / file.filename());
    for (const FoundDriver& driver : found.opencl)
      if (driver.named_by.empty())
        write_text_file((vendors / (fs::path(driver.library).filename().string() + ".icd")).string(),
                        driver.library + "\n");
    setenv("OCL_ICD_VENDORS", (vendors.string() + "/").c_str(), 1);
  }
  const auto unseen = [](const FoundDriver& driver) { return !is_looked_at(driver.named_by); };
  if (std::any_of(found.egl.begin(), found.egl.end(), unseen) &&
      std::getenv("__EGL_VENDOR_LIBRARY_FILENAMES") == nullptr) {
    std::string files;
    for (const FoundDriver& driver : found.egl) {
      std::string file = driver.named_by;
      if (file.empty()) {
        file = folder + "/" + fs::path(driver.library).filename().string() + ".json";
        const nlohmann::json json = {{"file_format_version", "1.0.0"}, {"ICD", {{"library_path", driver.library}}}};
        write_text_file(file, json.dump());
      }
      files += (files.empty() ? "" : ":") + file;
    }
    setenv("__EGL_VENDOR_LIBRARY_FILENAMES", files.c_str(), 1);
  }
}

}  // namespace multum::bench
