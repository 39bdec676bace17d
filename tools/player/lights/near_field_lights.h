// Emitters near the object (Fujita & Kanai 2004): bodies that are drawn into a cube map around the virtual
// sphere's centre, whose projection into spherical harmonics, on the GPU, is the object's second light.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "formats/light_rig.h"
#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/surface_mesh.h"
#include "tools/player/lights/gpu_light.h"
#include "transport/camera.h"
#include "transport/light_rig.h"

namespace bakelight::player {

class NearFieldLights {
 public:
  // `rig` has emitters. The cube map stands at `center` (object space); its faces, in the order and
  // orientation of transport/cube_map.h, have `resolution_px`² texels of 32-bit floats. Throws
  // Error(kBadInput) for a resolution that this GL's buffers cannot hold at this order, or radiance that is
  // not finite.
  NearFieldLights(formats::LightRig rig, const transport::BoundingSphere& object,
                  const transport::Vec3& center, int order, int resolution_px);

  // Moves the emitters. What they light and their number do not matter: one mesh, one draw a face.
  void place(double time_s);
  // Draws the six faces and projects them: L_i = Σ texels radiance · y_i(centre direction) · exact solid
  // angle, in a fixed order. The object is turned by `world_from_object` about its bounding sphere's centre;
  // emitters stay.
  void project(const Eigen::Matrix3d& world_from_object);
  // Draws the bodies with depth test into the framebuffer that is bound. Positions are counted from the
  // object's centre.
  void draw(const Eigen::Matrix4f& clip_from_position) const;

  // In the object's frame; dark until the first project().
  const GpuLight& light() const { return light_; }
  // The same, read back: order² entries.
  transport::ShLight readLight() const;
  // The six faces read back as a strip 6:1, R, G, B: what transport::renderEmitterCube returns.
  formats::Image readCube() const;

  bool anyMoves() const;
  // Of the sphere around the object's centre that holds all emitters as placed.
  double radius() const { return radius_; }
  std::size_t gpuBytes() const;

 private:
  void makeCube();
  void makeProjection();
  void upload(const transport::EmitterMesh& emitters);
  void drawCube(const Eigen::Matrix3d& world_from_object) const;
  void projectCube() const;

  formats::LightRig rig_;
  transport::BoundingSphere object_;
  transport::Vec3 center_;
  int order_, resolution_;
  double radius_ = 0;

  Buffer positions_, radiance_, indices_;
  std::size_t vertex_count_ = 0;
  std::optional<RadiantSurface> bodies_;

  Texture faces_, depth_;
  std::array<Framebuffer, 6> face_framebuffers_;
  Program row_program_, sum_program_;
  Buffer weighted_basis_;  // order² × six faces × texels: y_i · solid angle
  Buffer row_sums_;        // six faces × rows × order² × RGB and padding
  GpuLight light_;
};

}  // namespace bakelight::player
