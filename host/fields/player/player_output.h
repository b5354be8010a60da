// SPDX-License-Identifier: Apache-2.0
// Publishes packed fields with their player for browsers: as a folder for any static web server, or as one page that
// opens from disk. The geometry is taken from the scene file that the field names, and converted (scene_glb.h).
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace multum {

/// Bytes of a field and its geometry together that fit into one page: browsers parse such a page at once, and a third
/// is added by base64.
constexpr std::uint64_t kPlayerPageBytesMax = std::uint64_t{16} << 20;

struct PlayerOutput {
  std::string folder;  // to write a player to, which is made; empty: none
  std::string page;    // *.html to write; empty: none
  /// Called with the path of the scene file that the field names, before it is looked at: throws where it may not be.
  std::function<void(const std::string& path)> check_geometry = {};

  bool is_asked_for() const { return !folder.empty() || !page.empty(); }
};

/// Before any work is done. Throws Error: kUsage for a name that cannot be written, kEnvironment where the program was
/// built without the decoder for browsers, naming what its build lacked.
void check_player_output(const PlayerOutput& output);

/// Of the packed field at `field`. Throws Error: kInput where the field, or the geometry that it names, cannot be read
/// or is not the one its textures are for; kUsage where it is too large for a page.
void write_player(const std::string& field, const PlayerOutput& output);

}  // namespace multum
