// SPDX-License-Identifier: Apache-2.0
// Publishes packed fields with their player for browsers, either as a folder for any static web server, or as one page
// that opens from disk. Converts the geometry from the scene file that the field names (scene_glb.h).
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace multum {

/// The maximum number of bytes of a field and its geometry in one page. Browsers parse such a page as a whole, and
/// base64 makes it a third larger.
constexpr std::uint64_t kPlayerPageBytesMax = std::uint64_t{16} << 20;

struct PlayerOutput {
  std::string folder;  // folder of the player, which is created; if empty, none is written
  std::string page;    // name of the page, *.html; if empty, none is written
  /// Called with the path of the field's scene file before the file is opened. Throws if the path is not allowed.
  std::function<void(const std::string& path)> check_geometry = {};

  bool is_asked_for() const { return !folder.empty() || !page.empty(); }
};

/// Checks the outputs before any work. Throws Error(kUsage) for a name that cannot be written. Throws
/// Error(kEnvironment) if the program was built without the decoder for browsers. The message of this error names what
/// the build lacked.
void check_player_output(const PlayerOutput& output);

/// Writes the player of the packed field at `field`. Throws Error(kInput) if the field or its geometry cannot be read,
/// or if the geometry does not match the textures. Throws Error(kUsage) if the field is too large for a page.
void write_player(const std::string& field, const PlayerOutput& output);

}  // namespace multum
