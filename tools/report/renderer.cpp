#include "tools/report/renderer.h"

#include <algorithm>

#include "formats/mesh_ply.h"
#include "formats/neighborhood.h"
#include "transport/frame.h"
#include "transport/near_light.h"
#include "transport/neighborhood_shading.h"
#include "transport/sh.h"

namespace bakelight::report {

using transport::Vec3;

Renderer::Renderer(const Plan& plan, std::vector<transport::OrbitCamera> cameras, const Sources& sources)
    : plan_(plan), cameras_(std::move(cameras)), sources_(sources) {}

Renderer::Conditions Renderer::conditions(const formats::TriangleMesh& mesh,
                                          const transport::LightNeeds& needs, std::size_t view) {
  const formats::FrameSettings& frame = plan_.views[view].frame;
  const transport::Lighting& light = lighting(view, needs.sh_order);
  const Eigen::Matrix3d world_from_object = transport::worldFromObject(frame);
  const transport::OrbitCamera& camera = cameras_[view];
  const Eigen::Matrix3d object_from_light = world_from_object.transpose() * transport::worldFromLight(frame);
  transport::requirePunctualTaken(light.near, needs, plan_.views[view].lights_path.string());
  transport::Occlusion shadows;
  if (!light.near.punctual.empty()) {
    transport::Occlusion& known = shadows_[formats::geometryHash(mesh)];
    if (!known) known = transport::shadowsOf(mesh);
    shadows = known;
  }
  Conditions conditions{light.distant,
                        object_from_light,
                        transport::nearLight(mesh, needs, light, frame.time_s, world_from_object),
                        {},
                        transport::punctualLightsOn(mesh, light.near, frame.time_s, world_from_object),
                        shadows,
                        world_from_object.transpose() * (camera.eye() - camera.target) + camera.target};
  if (needs.cube_side == 0) return conditions;
  const auto own_mesh = std::make_shared<const formats::TriangleMesh>(mesh);
  conditions.cube_of = [=, &light, time_s = frame.time_s](const Eigen::Matrix3d& turn) {
    return transport::cubeLightOn(*own_mesh, needs, light, object_from_light * turn, world_from_object,
                                  time_s);
  };
  conditions.cube = conditions.cube_of(Eigen::Matrix3d::Identity());
  return conditions;
}

void Renderer::Conditions::light(transport::PackShading& shading, const Eigen::Matrix3d& turn) const {
  const transport::LightNeeds needs = shading.needs();
  shading.setPunctualLights(punctual, shadows);
  if (needs.cube_side > 0) return shading.setCubeLight(cube);
  shading.setLight(transport::ShRotation(needs.sh_order, object_from_light * turn).apply(distant), near);
}

std::vector<Picture> Renderer::picturesOf(const formats::Pack& pack, const LightUp& light) {
  const std::unique_ptr<transport::PackShading> shading = transport::makePackShading(pack);
  const transport::LightNeeds needs = shading->needs();
  const transport::BoundingSphere bounds = transport::boundingSphere(pack.mesh);
  std::vector<Picture> pictures;
  for (std::size_t view = 0; view < plan_.views.size(); ++view) {
    const Conditions conditions = this->conditions(pack.mesh, needs, view);
    light ? light(view, conditions, *shading) : conditions.light(*shading);
    shading->setView({conditions.eye, cameras_[view].pixelAngle(plan_.views[view].frame.height_px *
                                                                plan_.views[view].frame.supersampling)});
    const transport::EmitterMesh emitters =
        transport::emitterMesh(lighting(view, needs.sh_order).near, bounds, plan_.views[view].frame.time_s);
    pictures.push_back(pictureOf(gbuffer(pack, view, emitters), transport::radianceOf(*shading),
                                 transport::interpolated(emitters.mesh.triangles, emitters.radiance)));
  }
  return pictures;
}

void Renderer::addGround(const formats::Pack& pack, std::size_t view, const Conditions& conditions,
                         const Picture& reference, Picture& picture) const {
  const auto* neighborhood = pack.neighborhood ? pack.neighborhood->as<formats::Neighborhood>() : nullptr;
  if (neighborhood == nullptr || !neighborhood->ground) return;
  transport::GroundShading ground(*neighborhood);
  ground.setLight(
      transport::ShRotation(neighborhood->order, conditions.object_from_light).apply(conditions.distant),
      conditions.near);
  const PlanView& of = plan_.views[view];
  const Eigen::Matrix3d object_from_world = transport::worldFromObject(of.frame).transpose();
  for (int y = 0; y < of.frame.height_px; ++y)
    for (int x = 0; x < of.frame.width_px; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * of.frame.width_px + x;
      float* texel = &picture.linear.values[4 * pixel];
      if (texel[3] > 0 || reference.covered[pixel] == 0) continue;
      const Vec3 direction =
          cameras_[view].directionThrough(x + 0.5, y + 0.5, of.frame.width_px, of.frame.height_px);
      const formats::Float4 seen =
          ground.seen(conditions.eye, object_from_world * direction, of.ground_albedo);
      if (seen[3] < 1) continue;
      std::copy(seen.begin(), seen.end(), texel);
      picture.covered[pixel] = 1;
    }
}

double Renderer::exposure(const formats::TriangleMesh& mesh, const transport::LightNeeds& needs,
                          std::size_t view) {
  const transport::Lighting& light = lighting(view, needs.sh_order);
  return transport::exposureFactor(plan_.views[view].frame, transport::exposureLight(mesh, needs, light));
}

const transport::Lighting& Renderer::lighting(std::size_t view, int order) {
  const auto known = lightings_.find({view, order});
  if (known != lightings_.end()) return known->second;
  const PlanView& plan = plan_.views[view];
  // Cameras share the lights of other views.
  for (std::size_t other = 0; other < plan_.views.size(); ++other) {
    const PlanView& candidate = plan_.views[other];
    const auto same = lightings_.find({other, order});
    if (same != lightings_.end() && candidate.environment_path == plan.environment_path &&
        candidate.lights_path == plan.lights_path && candidate.windowing == plan.windowing)
      return lightings_.emplace(std::pair(view, order), same->second).first->second;
  }
  transport::Lighting light =
      transport::lightingFor(sources_.lights(plan.environment_path, plan.lights_path, plan.windowing), order,
                             plan.lights_path.string());
  light.backdrop = {};  // not seen
  return lightings_.emplace(std::pair(view, order), std::move(light)).first->second;
}

const GBuffer& Renderer::gbuffer(const formats::Pack& pack, std::size_t view,
                                 const transport::EmitterMesh& emitters) {
  const std::pair key(formats::geometryHash(pack.mesh), view);
  const auto known = gbuffers_.find(key);
  if (known != gbuffers_.end()) return known->second;
  const formats::FrameSettings& frame = plan_.views[view].frame;
  const transport::PictureGrid grid{frame.width_px, frame.height_px, frame.supersampling};
  return gbuffers_
      .emplace(key,
               traceGBuffer(pack.mesh, emitters, transport::worldFromObject(frame), cameras_[view], grid))
      .first->second;
}

}  // namespace bakelight::report
