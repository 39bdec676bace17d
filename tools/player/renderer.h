// Draws a pack under a light: surface and backdrop into a picture target. Needs a current OpenGL 4.5 core
// context, which must outlive it; the same for windows and headless pictures.
#pragma once

#include <Eigen/Core>
#include <span>

#include "formats/image.h"
#include "formats/pack.h"
#include "tools/player/frame.h"
#include "tools/player/gl_objects.h"
#include "tools/player/picture_target.h"
#include "tools/player/vertex_radiance.h"

namespace bakelight::player {

class Renderer {
 public:
  // Uploads mesh, transfer table and backdrop; the pack may be freed afterwards. Throws Error(kBadInput) if
  // the environment image is larger than this GL's textures, Error(kNotAvailable) if GL is out of memory or
  // lacks a feature.
  Renderer(const formats::Pack& pack, Environment environment);

  // Brings everything to `settings` and draws the subsamples into target(). Light and target storage are
  // touched only if they changed.
  void draw(const FrameSettings& settings);

  // Evaluates the light even if it has not changed, for timing. draw() calls it when needed.
  void updateLight(const FrameSettings& settings);

  const PictureTarget& target() const { return target_; }
  float exposure(const FrameSettings& settings) const;
  const transport::BoundingSphere& bounds() const { return bounds_; }

 private:
  void uploadMesh(const formats::Pack& pack);
  void uploadBackdrop(const formats::Image& image);
  void drawSurface(const transport::OrbitCamera& camera) const;
  void drawBackdrop(const transport::OrbitCamera& camera, const Eigen::Matrix3d& world_from_light) const;

  transport::BoundingSphere bounds_;
  formats::Float3 base_color_;
  int order_;
  transport::ShLight light_;  // in its own frame
  double light_yaw_deg_ = 0, light_pitch_deg_ = 0;
  bool light_evaluated_ = false;

  VertexRadiance vertex_radiance_;
  PictureTarget target_;
  Program surface_program_, backdrop_program_;
  VertexArray surface_, no_attributes_;
  Buffer positions_, indices_;
  GLsizei index_count_ = 0;
  Texture backdrop_;
};

}  // namespace bakelight::player
