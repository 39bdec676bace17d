// Draws a pack under its lights: surface, emitters and backdrop into a picture target. Needs a current OpenGL
// 4.5 core context, which must outlive it; the same for windows and headless pictures.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "formats/image.h"
#include "formats/pack.h"
#include "tools/player/exit_radiance.h"
#include "tools/player/gl_objects.h"
#include "tools/player/near_field_lights.h"
#include "tools/player/picture_target.h"
#include "transport/frame.h"
#include "transport/lighting.h"

namespace bakelight::player {

class Renderer {
 public:
  // Uploads mesh, transfer tables, emitters and backdrop; the pack may be freed afterwards. Throws
  // Error(kBadInput) if the backdrop or the cube map is larger than this GL's textures or buffers,
  // Error(kNotAvailable) if GL is out of memory or lacks a feature.
  Renderer(const formats::Pack& pack, transport::Lighting lighting);

  // Brings everything to `settings` and draws the subsamples into target(). Lights and target storage are
  // touched only if they changed.
  void draw(const formats::FrameSettings& settings);

  // What draw() calls when needed; even if nothing has changed, for timing. Without emitters the second does
  // nothing.
  void updateLight(const formats::FrameSettings& settings);  // turns the distant light and evaluates it
  void updateNearLight(
      const formats::FrameSettings& settings);  // places the emitters and projects their cube map

  bool hasEmitters() const { return near_lights_.has_value(); }
  bool emittersMove() const { return near_lights_ && near_lights_->anyMoves(); }
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

  void uploadMesh(const formats::Pack& pack);
  void uploadBackdrop(const formats::Image& image);
  void updateStaleLights(const formats::FrameSettings& settings);
  void drawBodies(const transport::OrbitCamera& camera, const Eigen::Matrix3d& world_from_object) const;
  void drawBackdrop(const transport::OrbitCamera& camera, const Eigen::Matrix3d& world_from_light) const;

  transport::BoundingSphere bounds_;
  int order_;
  transport::ShLight distant_;         // in its own frame
  transport::ShLight exposure_light_;  // see transport::exposureFactor
  std::optional<NearFieldLights> near_lights_;
  ExitRadiance exit_radiance_;
  LightState evaluated_;

  PictureTarget target_;
  Program surface_program_, backdrop_program_;
  VertexArray surface_, no_attributes_;
  Buffer positions_, indices_;
  GLsizei index_count_ = 0;
  Texture backdrop_;
  std::size_t backdrop_bytes_ = 0;
};

}  // namespace bakelight::player
