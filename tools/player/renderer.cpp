#include "tools/player/renderer.h"

#include <algorithm>
#include <Eigen/Geometry>
#include <stdexcept>
#include <utility>

#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gpu_timer.h"
#include "transport/cube_light.h"

namespace bakelight::player {
namespace {

// Exposure goes by the mean light, whatever the technique needs.
int orderOf(const transport::LightNeeds& needs) {
  return std::max(needs.sh_order, 1);
}

std::optional<NearFieldLights> nearLights(const transport::BoundingSphere& bounds,
                                          const transport::LightNeeds& needs, int order,
                                          transport::Lighting& lighting) {
  if (lighting.near.emitters.empty()) return std::nullopt;
  const int resolution = needs.cube_side > 0
                             ? transport::cubeResolutionFor(needs.cube_side, lighting.cube_resolution)
                             : lighting.cube_resolution;
  return std::optional<NearFieldLights>(std::in_place, std::move(lighting.near), bounds,
                                        needs.near_center.value_or(bounds.center), order, resolution);
}

std::optional<formats::LightRig> punctualLights(const formats::LightRig& near) {
  if (near.punctual.empty()) return std::nullopt;
  formats::LightRig rig;
  rig.punctual = near.punctual;
  rig.object_units = near.object_units;
  return rig;
}

Eigen::Matrix3d objectFromLight(const formats::FrameSettings& settings) {
  return transport::worldFromObject(settings).transpose() * transport::worldFromLight(settings);
}

}  // namespace

int lightOrder(const formats::Pack& pack) {
  return std::max(orderOf(techniqueFor(pack).needs(pack)), neighborhoodOrder(pack));
}

Renderer::Renderer(const formats::Pack& pack, transport::Lighting lighting,
                   const SurroundingsOptions& surroundings)
    : Renderer(pack, std::move(lighting), techniqueFor(pack), surroundings) {}

Renderer::Renderer(const formats::Pack& pack, transport::Lighting lighting, const PlayedTechnique& technique,
                   const SurroundingsOptions& surroundings)
    : bounds_(transport::boundingSphere(pack.mesh)),
      order_(lightOrder(pack)),
      distant_(std::move(lighting.distant)),
      exposure_light_(distant_),
      distant_light_(darkLight()),
      punctual_(punctualLights(lighting.near)),
      near_lights_(nearLights(bounds_, technique.needs(pack), order_, lighting)),
      mesh_(pack.mesh, bounds_.center),
      technique_(technique.make(pack, mesh_, near_lights_.has_value())),
      surroundings_(pack, surroundings, bounds_, near_lights_.has_value()),
      backdrop_(lighting.backdrop) {
  if (distant_.size() < static_cast<std::size_t>(transport::coefficientCount(order_)))
    throw std::invalid_argument("the light has fewer bands than the pack's technique needs");
  if (const int side = technique.needs(pack).cube_side; side > 0)
    cube_ = CubeLight{side, std::move(lighting.sources), {}};
  if (near_lights_) {
    near_lights_->project(Eigen::Matrix3d::Identity());
    exposure_light_ = transport::sum(distant_, near_lights_->readLight());
  }
  if (punctual_)
    exposure_light_ = transport::withMeanLight(
        std::move(exposure_light_), transport::placedPunctualLights(*punctual_, bounds_, 0), bounds_.center);
}

void Renderer::light() {
  surroundings_.setLight(distant_light_, near_lights_ ? &near_lights_->light() : nullptr);
  if (cube_) return;  // it is evaluated where it changes
  technique_->setLight(distant_light_, near_lights_ ? &near_lights_->light() : nullptr);
}

void Renderer::updateLight(const formats::FrameSettings& settings) {
  evaluated_.object_from_light = objectFromLight(settings);
  const transport::ShRotation rotation(order_, evaluated_.object_from_light);
  setLight(distant_light_, rotation.apply(distant_));
  light();
  if (cube_) cube_->distant = transport::cubeLight(cube_->sources, cube_->side, evaluated_.object_from_light);
  setCubeLight();
}

bool Renderer::moves() const {
  const auto moves = [](const formats::PunctualLight& light) {
    return light.motion.kind != formats::Motion::Kind::kStill;
  };
  return (near_lights_ && near_lights_->anyMoves()) || surroundings_.moves() ||
         (punctual_ && std::any_of(punctual_->punctual.begin(), punctual_->punctual.end(), moves));
}

void Renderer::updateNearLight(const formats::FrameSettings& settings) {
  evaluated_.world_from_object = transport::worldFromObject(settings);
  evaluated_.time_s = settings.time_s;
  if (punctual_) {
    std::vector<transport::PlacedPunctualLight> lights =
        transport::placedPunctualLights(*punctual_, bounds_, settings.time_s);
    transport::turnAbout(bounds_.center, evaluated_.world_from_object.transpose(), lights);
    technique_->setPunctualLights(lights);
  }
  if (!near_lights_) return;
  near_lights_->place(settings.time_s);
  near_lights_->project(evaluated_.world_from_object);
}

void Renderer::setCubeLight() {
  if (!cube_) return;
  if (!near_lights_) return technique_->setCubeLight(cube_->distant);
  std::vector<transport::Float3> radiance = cube_->distant;
  transport::addCubeMap(near_lights_->readCube(), cube_->side, radiance);
  technique_->setCubeLight(radiance);
}

void Renderer::updateStaleLights(const formats::FrameSettings& settings) {
  bool near_is_new = false;
  if ((near_lights_ || punctual_) && (evaluated_.time_s != settings.time_s ||
                                      evaluated_.world_from_object != transport::worldFromObject(settings)))
    updateNearLight(settings), near_is_new = true;
  if (evaluated_.object_from_light != objectFromLight(settings))
    updateLight(settings);
  else if (near_is_new)
    light(), setCubeLight();
  else
    light();
}

float Renderer::exposure(const formats::FrameSettings& settings) const {
  return static_cast<float>(transport::exposureFactor(settings, exposure_light_));
}

void Renderer::draw(const formats::FrameSettings& settings) {
  const transport::OrbitCamera camera = transport::frameCamera(settings, bounds_);
  const Eigen::Matrix3d world_from_object = transport::worldFromObject(settings);
  updateStaleLights(settings);
  technique_->lookFrom({world_from_object.transpose() * (camera.eye() - bounds_.center) + bounds_.center,
                        camera.pixelAngle(settings.height_px * settings.supersampling)});

  target_.resize(settings.width_px, settings.height_px, settings.supersampling);
  target_.beginFrame(settings.background == formats::Background::kTransparent ? 0.0f : 1.0f);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);  // the backdrop lies at the far plane itself
  surroundings_.place(world_from_object, settings.time_s);
  const Eigen::Matrix4d clip_from_centered = clipFromCentered(camera);
  drawBodies(clip_from_centered, world_from_object);
  if (settings.background == formats::Background::kEnvironment)
    backdrop_.draw(camera, transport::worldFromLight(settings), target_.widthPx() * target_.supersampling(),
                   target_.heightPx() * target_.supersampling());
  surroundings_.drawGround(clip_from_centered, world_from_object,
                           settings.background == formats::Background::kTransparent);
  throwIfGlFailed("drawing");
}

Eigen::Matrix4d Renderer::clipFromCentered(const transport::OrbitCamera& camera) const {
  transport::BoundingSphere all = bounds_;
  all.radius = std::max(all.radius, surroundings_.radius());
  if (near_lights_) all.radius = std::max(all.radius, near_lights_->radius());
  const double aspect = static_cast<double>(target_.widthPx()) / target_.heightPx();
  const Eigen::Affine3d world_from_centered(Eigen::Translation3d(bounds_.center));
  return camera.clipFromView(aspect, all) * camera.viewFromWorld() * world_from_centered.matrix();
}

void Renderer::drawBodies(const Eigen::Matrix4d& clip_from_centered,
                          const Eigen::Matrix3d& world_from_object) const {
  // Both sides are drawn, as rays hit both: open meshes show their inside.
  const Eigen::Matrix4f clip_from_position =
      (clip_from_centered * Eigen::Affine3d(world_from_object).matrix()).cast<float>();
  technique_->draw(clip_from_position);
  surroundings_.drawReceiver(clip_from_centered);
  if (!near_lights_) return;
  const GpuPass pass("emitters");
  near_lights_->draw(clip_from_centered.cast<float>());
}

std::size_t Renderer::gpuBytes() const {
  return mesh_.gpuBytes() + technique_->gpuBytes() + sizeInBytes(distant_light_.sh) + backdrop_.gpuBytes() +
         surroundings_.gpuBytes() + (near_lights_ ? near_lights_->gpuBytes() : 0);
}

}  // namespace bakelight::player
