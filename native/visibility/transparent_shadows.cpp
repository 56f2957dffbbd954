// SPDX-License-Identifier: GPL-3.0-or-later
// Shadow rays through transparent surfaces: Embree asks at each of them, in no particular order.
#include "visibility/geometry.h"

namespace penumbra {

double Geometry::transparency(const Ray& ray, const Hit& hit, uint8_t channel) const {
  PlacedPoint surface;
  surface_point(ray, hit, surface);
  return opacity_->may_be_transparent(surface.material)
             ? opacity_->transparency(surface, ray.direction, channel)
             : 0;
}

void Geometry::filter_shadow_rays(const RTCFilterFunctionNArguments* arguments) {
  const auto& context = *static_cast<const embree::ShadowContext*>(arguments->context);
  const Geometry& geometry = *context.geometry;
  float* transmittance = context.transmittance;
  const unsigned n = arguments->N;
  RTCRayN* rays = arguments->ray;
  for (unsigned i = 0; i < n; ++i) {
    if (!arguments->valid[i]) continue;
    Ray ray{{RTCRayN_org_x(rays, n, i), RTCRayN_org_y(rays, n, i), RTCRayN_org_z(rays, n, i)},
            {RTCRayN_dir_x(rays, n, i), RTCRayN_dir_y(rays, n, i), RTCRayN_dir_z(rays, n, i)},
            0,
            0,
            kShadowRay,
            double(RTCRayN_time(rays, n, i))};
    const unsigned instance = RTCHitN_instID(arguments->hit, n, i, 0);
    const Hit hit{instance != RTC_INVALID_GEOMETRY_ID ? instance : RTCHitN_geomID(arguments->hit, n, i),
                  RTCHitN_primID(arguments->hit, n, i), RTCHitN_u(arguments->hit, n, i),
                  double(RTCRayN_tfar(rays, n, i))};
    // Inside of an instance Embree gives the ray in the space of its mesh.
    const PlacedInstance& placed = geometry.instances_[hit.instance];
    if (placed.shared) {
      const Affine render_from_mesh = at_time(placed.mesh_motion, placed.render_from_mesh, ray.time);
      ray.origin = render_from_mesh.point(ray.origin);
      ray.direction = render_from_mesh.vector(ray.direction);
    }
    const unsigned id = RTCRayN_id(rays, n, i);
    float& left = transmittance[id];
    left *= float(geometry.transparency(ray, hit, context.channels[id]));
    if (left > 0) arguments->valid[i] = 0;  // goes on
  }
}

}  // namespace penumbra
