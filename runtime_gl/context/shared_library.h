// SPDX-License-Identifier: Apache-2.0
// Opens a library at run time and keeps its symbols separate from those of the program (RTLD_LOCAL). The library is
// never closed, because Mesa leaves threads and exit handlers that run its code.
#pragma once

#include <dlfcn.h>

#include <string>

#include "host/foundation/base/error.h"

namespace multum::gl {

class SharedLibrary {
 public:
  explicit SharedLibrary(const char* name) : name_(name), handle_(dlopen(name, RTLD_NOW | RTLD_LOCAL)) {
    if (handle_ != nullptr) return;
    const char* reason = dlerror();
    throw Error(ErrorCode::kEnvironment,
                "cannot open " + name_ + ": " + (reason != nullptr ? reason : "no reason given"));
  }

  template <typename Function>
  Function symbol(const char* name) const {
    void* address = dlsym(handle_, name);
    if (address == nullptr) throw Error(ErrorCode::kEnvironment, name_ + " has no function " + name);
    return reinterpret_cast<Function>(address);
  }

 private:
  std::string name_;
  void* handle_;
};

}  // namespace multum::gl
