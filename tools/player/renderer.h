// Draws a pack under its lights: surface, emitters, backdrop and surroundings into a picture target. How the surface gets
// its radiance is the technique's matter. Needs a current OpenGL 4.5 core context, which must outlive it; the
// same for windows and headless pictures.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "formats/image.h"
#include "formats/pack.h"
#include "tools/player/gl/picture_target.h"
#include "tools/player/gl/surface_mesh.h"
#include "tools/player/lights/backdrop.h"
#include "tools/player/lights/near_field_lights.h"
#include "tools/player/surroundings/surroundings.h"
#include "tools/player/techniques/technique.h"
#include "transport/frame.h"
#include "transport/lighting.h"

namespace bakelight::player {

class Renderer {
 public:
  // Uploads mesh, technique, emitters and backdrop; the pack may be freed afterwards. `lighting` has at least
  // the order that lightOrder tells. Throws Error(kBadInput) if no technique plays the pack, or the backdrop
  // or the cube map is larger than this GL's textures or buffers, Error(kNotAvailable) if GL is out of memory
  // or lacks a feature, std::invalid_argument for a receiver in a pack without a volume.
  Renderer(const formats::Pack& pack, transport::Lighting lighting,
           const SurroundingsOptions& surroundings = {});

  // Brings everything to `settings` and draws the subsamples into target(). Lights and target storage are
  // touched only if they changed.
  void draw(const formats::FrameSettings& settings);

  // What draw() calls when needed; even if nothing has changed, for timing. Without emitters and punctual lights the second does
  // nothing.
  void updateLight(const formats::FrameSettings& settings);  // turns the distant light and evaluates it
  void updateNearLight(
      const formats::FrameSettings&
          settings);  // places emitters and punctual lights, projects the cube map of the former

  bool hasNearLights() const { return near_lights_ || punctual_; }
  bool moves() const;            // lights or a receiver, with time
  std::size_t gpuBytes() const;  // of buffers and textures, without the picture target
  const PictureTarget& target() const { return target_; }
  float exposure(const formats::FrameSettings& settings) const;
  const transport::BoundingSphere& bounds() const { return bounds_; }

 private:
  // What the lights were evaluated for.
  struct LightState {
    Eigen::Matrix3d object_from_light = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d world_from_object = Eigen::Matrix3d::Zero();
    double time_s = 0;
  };

  // For techniques whose light is a cube map.
  struct CubeLight {
    int side;
    std::vector<formats::DistantLight> sources;
    std::vector<transport::Float3> distant;  // of the sources, as evaluated_ has them turned
  };

  Renderer(const formats::Pack& pack, transport::Lighting lighting, const PlayedTechnique& technique,
           const SurroundingsOptions& surroundings);
  void light();
  void setCubeLight();
  void updateStaleLights(const formats::FrameSettings& settings);
  Eigen::Matrix4d clipFromCentered(const transport::OrbitCamera& camera) const;
  void drawBodies(const Eigen::Matrix4d& clip_from_centered, const Eigen::Matrix3d& world_from_object) const;

  transport::BoundingSphere bounds_;
  int order_;
  transport::ShLight distant_;         // in its own frame
  transport::ShLight exposure_light_;  // see transport::exposureFactor
  std::optional<CubeLight> cube_;
  GpuLight distant_light_;
  std::optional<formats::LightRig> punctual_;  // of punctual lights alone
  std::optional<NearFieldLights> near_lights_;
  SurfaceMesh mesh_;
  std::unique_ptr<Technique> technique_;
  Surroundings surroundings_;
  LightState evaluated_;
  Backdrop backdrop_;
  PictureTarget target_;
};

// Bands of the distant light that the renderer of this pack needs. Throws as its constructor does for a pack
// that no technique plays.
int lightOrder(const formats::Pack& pack);

}  // namespace bakelight::player
