// A diffuse body that moves through the light around an object. transport::VolumeShading is the same on the CPU.
#pragma once

#include <cstddef>
#include <Eigen/Core>
#include <vector>

#include "formats/neighborhood.h"
#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/gpu_table.h"
#include "tools/player/gl/surface_mesh.h"
#include "transport/receiver.h"

namespace bakelight::player {

class Receiver {
 public:
  // `object` is the object's bounding sphere. Throws std::invalid_argument if the neighborhood has no volume, or its table does not fit it.
  Receiver(const formats::Neighborhood& neighborhood, const transport::Receiver& receiver,
           const transport::BoundingSphere& object);

  // Light around the object, as GpuLight::sh. Cost: points × 18 · order² multiply-adds a colour.
  void setLight(const Buffer& light);
  // Where it is in the world, and its radiance there, under the light of the last setLight.
  void place(const Eigen::Matrix3d& world_from_object, double time_s);
  // `clip_from_centered` takes positions from the object's middle. Into the framebuffer that is bound, by depth test.
  void draw(const Eigen::Matrix4d& clip_from_centered) const;
  double reach() const;  // of all that it may come to, from the object's middle
  std::size_t gpuBytes() const;

 private:
  transport::Receiver receiver_;
  transport::BoundingSphere object_;
  int coefficients_;
  std::array<GLuint, 3> counts_;
  GpuTable matrices_;
  std::vector<RowRange> ranges_;
  Program matrix_program_, program_;
  Buffer changes_, axes_, normals_, radiance_;
  SurfaceMesh mesh_;
  RadiantSurface surface_;
  transport::Vec3 middle_ = transport::Vec3::Zero();  // from the object's
  GLuint light_ = 0;
};

}  // namespace bakelight::player
