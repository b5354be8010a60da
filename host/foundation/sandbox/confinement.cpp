// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/sandbox/confinement.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <glob.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/open_file.h"
#include "host/foundation/base/process_rules/process_rules.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

// Values from linux/landlock.h of later kernels. The header of Debian 12 lacks these values.
constexpr std::uint64_t kTruncate = 1 << 14, kDeviceControl = 1 << 15;
constexpr std::uint64_t kBindTcp = 1 << 0, kConnectTcp = 1 << 1;
constexpr std::uint64_t kSignals = 1 << 1;
struct Ruleset {
  std::uint64_t files = 0, network = 0, scoped = 0;  // accesses that are denied unless a rule allows them
};
constexpr std::uint64_t kReadFile = LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_READ_FILE;
constexpr std::uint64_t kRead = kReadFile | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t kWriteFile = kReadFile | LANDLOCK_ACCESS_FS_WRITE_FILE | kTruncate | kDeviceControl;

int abi() {
  return static_cast<int>(::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION));
}

// Returns all accesses that this kernel can deny.
std::uint64_t all_rights(int version) {
  std::uint64_t rights = (std::uint64_t{1} << 13) - 1;
  if (version >= 2) rights |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= 3) rights |= kTruncate;
  if (version >= 5) rights |= kDeviceControl;
  return rights;
}

void allow(int rules, const std::string& path, std::uint64_t rights) {
  const OpenFile file(::open(path.c_str(), O_PATH | O_CLOEXEC));
  struct stat found {};
  if (!file.is_open() || ::fstat(file.descriptor(), &found) != 0) return;
  landlock_path_beneath_attr rule{};
  rule.allowed_access = S_ISDIR(found.st_mode) ? rights : rights & kWriteFile;
  rule.parent_fd = file.descriptor();
  if (::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) != 0)
    fail_by_errno(path, "this process cannot be confined to it");
}

void add_each(std::vector<std::string>& list, const std::string& paths) {
  for (std::size_t begin = 0; begin < paths.size();) {
    const std::size_t end = std::min(paths.find(':', begin), paths.size());
    if (end > begin) list.push_back(paths.substr(begin, end - begin));
    begin = end + 1;
  }
}

void add_matching(std::vector<std::string>& list, const char* pattern) {
  glob_t found{};
  if (::glob(pattern, 0, nullptr, &found) == 0)
    for (std::size_t i = 0; i < found.gl_pathc; ++i) list.emplace_back(found.gl_pathv[i]);
  ::globfree(&found);
}

// Adds the folders where drivers store compiled programs.
void add_caches(std::vector<std::string>& writable, const Variables& variable) {
  const std::string home = variable("HOME"), named = variable("XDG_CACHE_HOME");
  const std::string cache = !named.empty() ? named : home.empty() ? "" : home + "/.cache";
  for (const char* own : {"MULTUM_CACHE_DIR", "POCL_CACHE_DIR", "MESA_SHADER_CACHE_DIR", "CUDA_CACHE_PATH"})
    if (const std::string path = variable(own); !path.empty()) writable.push_back(path);
  if (!cache.empty())
    for (const char* name :
         {"multum", "pocl", "mesa_shader_cache", "mesa_shader_cache_db", "neo_compiler_cache", "AMD"})
      writable.push_back(cache + "/" + name);
  if (!home.empty() && fs::exists("/dev/nvidiactl")) writable.push_back(home + "/.nv");
  for (const std::string& path : writable) {
    std::error_code ignored;
    fs::create_directories(path, ignored);
  }
}

// A line of a file in /etc that names the library of an OpenCL driver.
void add_drivers(std::vector<std::string>& readable, const Variables& variable) {
  std::vector<std::string> lists;
  add_matching(lists, "/etc/OpenCL/vendors/*.icd");
  const std::string named = variable("OCL_ICD_VENDORS");
  if (named.ends_with(".icd")) lists.push_back(named);
  else if (!named.empty()) add_matching(lists, (named + "/*.icd").c_str());
  std::vector<std::string> libraries;
  for (const std::string& list : lists) {
    std::string library;
    if (std::ifstream file(list); std::getline(file, library)) libraries.push_back(library);
  }
  add_each(libraries, variable("OCL_ICD_FILENAMES"));
  std::error_code error;
  for (const std::string& library : libraries)
    if (library.starts_with('/') && fs::exists(library, error))
      readable.push_back(fs::canonical(library, error).parent_path().string());
}

}  // namespace

Confinement system_confinement(const Variables& variable) {
  Confinement allowed;
  add_caches(allowed.writable, variable);
  for (const char* device : {"/dev/null", "/dev/zero", "/dev/full", "/dev/shm", "/dev/dri", "/dev/kfd", "/dev/dxg"})
    allowed.writable.emplace_back(device);
  add_matching(allowed.writable, "/dev/nvidia*");
  allowed.readable = {"/usr",
                      "/lib",
                      "/lib32",
                      "/lib64",
                      "/bin",
                      "/nix/store",
                      "/run/opengl-driver",
                      "/proc",
                      "/sys",
                      "/dev/random",
                      "/dev/urandom",
                      "/etc/OpenCL",
                      "/etc/ld.so.cache",
                      "/etc/alternatives",
                      "/etc/glvnd",
                      "/etc/drirc",
                      "/etc/localtime",
                      "/etc/ssl/openssl.cnf"};
  for (const char* drivers : {"/opt/rocm*", "/opt/amdgpu*", "/opt/intel"}) add_matching(allowed.readable, drivers);
  add_drivers(allowed.readable, variable);
  // The folders of an unpacked archive are PREFIX/bin, PREFIX/lib and PREFIX/libexec.
  const fs::path folder = program_folder();
  allowed.readable.push_back(folder.string());
  allowed.readable.push_back((folder.parent_path() / "lib").string());
  allowed.readable.push_back((folder.parent_path() / "libexec").string());
  allowed.readable.push_back((folder.parent_path() / "share").string());
  for (const char* paths : {"LD_LIBRARY_PATH", "OCL_ICD_VENDORS", "LIBGL_DRIVERS_PATH", "LD_PRELOAD"})
    add_each(allowed.readable, variable(paths));
  return allowed;
}

std::string part_that_holds(const Confinement& allowed, const std::string& path) {
  std::error_code error;
  const fs::path place = fs::weakly_canonical(fs::absolute(path), error);
  for (const std::vector<std::string>* list : {&allowed.readable, &allowed.writable})
    for (const std::string& part : *list) {
      const fs::path above = fs::weakly_canonical(part, error);
      const auto [end, ignored] = std::mismatch(above.begin(), above.end(), place.begin(), place.end());
      if (!error && !part.empty() && end == above.end()) return part;
    }
  return "";
}

bool can_confine() { return abi() > 0; }

bool confine_this_thread(const Confinement& allowed) {
  const int version = abi();
  if (version <= 0) return false;
  Ruleset handled;
  handled.files = all_rights(version);
  if (version >= 4) handled.network = kBindTcp | kConnectTcp;
  if (version >= 6) handled.scoped = kSignals;
  const std::size_t bytes = version >= 6 ? sizeof(handled) : version >= 4 ? 16 : 8;
  const OpenFile rules(static_cast<int>(::syscall(SYS_landlock_create_ruleset, &handled, bytes, 0)));
  if (!rules.is_open()) fail_by_errno("Landlock", "this process cannot be confined");
  for (const std::string& path : allowed.readable) allow(rules.descriptor(), path, kRead & all_rights(version));
  for (const std::string& path : allowed.writable) allow(rules.descriptor(), path, all_rights(version));
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
      ::syscall(SYS_landlock_restrict_self, rules.descriptor(), 0) != 0)
    fail_by_errno("Landlock", "this process cannot be confined");
  return true;
}

}  // namespace multum
