// SPDX-License-Identifier: Apache-2.0
// Converts the exceptions that libraries throw for damaged files to an error that names the file. OpenEXR's own
// exceptions may pass through OpenImageIO.
#pragma once

#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

#include "host/foundation/base/error.h"

namespace multum {

class NotEnoughMemory : public Error {
 public:
  explicit NotEnoughMemory(const std::string& path)
      : Error(ErrorCode::kEnvironment, path + ": not enough memory to read it") {}
};

template <typename Body>
auto with_damage_named(const std::string& path, const Body& body) {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    throw NotEnoughMemory(path);
  } catch (const Error&) {
    throw;
  } catch (const std::system_error& error) {  // for example, if there is no memory for a thread's stack
    const bool is_memory =
        error.code() == std::errc::not_enough_memory || error.code() == std::errc::resource_unavailable_try_again;
    if (is_memory) throw NotEnoughMemory(path);
    throw Error(ErrorCode::kInput, path + ": damaged: " + error.what());
  } catch (const std::runtime_error& error) {
    throw Error(ErrorCode::kInput, path + ": damaged: " + error.what());
  } catch (const std::logic_error& error) {
    throw Error(ErrorCode::kInput, path + ": damaged: " + error.what());
  }
}

}  // namespace multum
