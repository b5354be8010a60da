// SPDX-License-Identifier: Apache-2.0
// A library opened at run time, its symbols kept out of the program's (RTLD_LOCAL). It is never closed: Mesa leaves
// threads and exit handlers behind that run code of it.
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
