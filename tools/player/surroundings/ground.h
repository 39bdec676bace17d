// The plane that an object stands on, in its shadow and the light that it reflects. transport::GroundShading is the same on the CPU.
#pragma once

#include <cstddef>
#include <Eigen/Core>

#include "formats/neighborhood.h"
#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/gpu_table.h"
#include "tools/player/gl/surface_mesh.h"
#include "tools/player/operators/diffuse_pass.h"
#include "transport/neighborhood_shading.h"

namespace bakelight::player {

class Ground {
 public:
  // Positions count from `origin`. Throws std::invalid_argument if the neighborhood has no ground, or its table does not fit it.
  Ground(const formats::Neighborhood& neighborhood, const transport::Vec3& origin,
         const formats::Float3& albedo);

  void setLight(const Buffer& light);  // as GpuLight::sh
  // Over what the framebuffer that is bound shows, by depth test; its upper side only.
  void draw(const Eigen::Matrix4f& clip_from_position) const;
  double radius() const { return radius_; }  // from `origin` to its farthest point
  std::size_t gpuBytes() const;

 private:
  transport::GroundFade fade_;  // from `origin`
  double radius_;
  SurfaceMesh mesh_;
  GpuTable vectors_;
  DiffusePass pass_;
  Program program_;
  VertexArray vertices_;
};

}  // namespace bakelight::player
