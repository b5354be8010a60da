// SPDX-License-Identifier: Apache-2.0
// Implements multum_render_plane().
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "host/api/api_call.h"
#include "host/api/api_device.h"
#include "host/api/api_error.h"
#include "host/api/api_map.h"
#include "host/api/lobe_shading.h"
#include "host/delivery/picture/plane_picture.h"

namespace multum {
namespace {

class MapTexels : public PlaneTexels {
 public:
  explicit MapTexels(multum_map& map) : map_(map) {}
  const BakedHeader& header() const override { return map_.header(); }
  int lobe_count() const override { return map_.info().lobe_count; }
  const std::vector<float>& lobes(int level) const override { return map_.level(level)[MULTUM_LOBES]; }
  const std::vector<float>& colours(int level) const override { return map_.level(level)[MULTUM_COLOURS]; }

 private:
  multum_map& map_;
};

PlaneView view_of(const multum_plane& plane) {
  if (plane.size < sizeof(multum_plane))
    throw Error(ErrorCode::kUsage, fmt::format("multum_render_plane: the field `size` of plane is {}, expected a plane "
                                               "that MULTUM_PLANE_INIT initialised",
                                               plane.size));
  const auto vector = [](const double(&v)[3]) { return glm::dvec3(v[0], v[1], v[2]); };
  return {vector(plane.eye), vector(plane.target), plane.fov, vector(plane.light),
          plane.width,       plane.height,         plane.taps};
}

}  // namespace
}  // namespace multum

multum_status multum_render_plane(multum_device* device, multum_map* map, const multum_brdf* brdf,
                                  const multum_plane* plane, const multum_callbacks* callbacks, float* rgba,
                                  multum_error** error) {
  return multum::guarded(error, [&] {
    multum::require(device, "multum_render_plane", "device", "a device");
    multum::require(map, "multum_render_plane", "map", "a map");
    multum::require(brdf, "multum_render_plane", "brdf", "a BRDF");
    multum::require(plane, "multum_render_plane", "plane", "a view of the plane");
    multum::require(rgba, "multum_render_plane", "rgba", "room for the picture");
    multum::ApiCall call(callbacks);
    multum::check_has_lobes(*map);
    const multum::DeviceUse use(*device, call.progress());
    const std::vector<float> picture =
        multum::draw_plane(device->device, multum::MapTexels(*map), {brdf->brdf, brdf->terms, brdf->exponent},
                           multum::view_of(*plane), call.progress());
    std::copy(picture.begin(), picture.end(), rgba);
  });
}
