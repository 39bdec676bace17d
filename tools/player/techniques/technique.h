// How a pack is drawn on the GPU: the one way in which the renderer sees a pack. What a technique keeps there
// and which passes it runs are its own matter; transport/pack_shading.h is the same on the CPU.
#pragma once

#include <cstddef>
#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "formats/pack_contents.h"
#include "tools/player/gl/surface_mesh.h"
#include "tools/player/lights/gpu_light.h"
#include "transport/pack_shading.h"

namespace bakelight::player {

class Technique {
 public:
  virtual ~Technique() = default;

  // Light change, in the object's frame: `near`, null without near emitters, is what LightNeeds::near_center
  // sees of them. Lights whose revision is the same as before need not be evaluated again. Both outlive the
  // technique.
  virtual void setLight(const GpuLight& distant, const GpuLight* near) = 0;
  // Light change for those whose LightNeeds ask for a cube map, in place of setLight: transport::PackShading::setCubeLight. Throws
  // std::logic_error from those that do not.
  virtual void setCubeLight(std::span<const formats::Float3> radiance);
  // Change of punctual lights, in the object's frame, which takes effect with the next setLight; empty: none. Throws std::logic_error for any
  // from those whose LightNeeds are without.
  virtual void setPunctualLights(std::span<const transport::PlacedPunctualLight> lights);
  // In every frame, and after a light change.
  virtual void lookFrom(const transport::ViewPoint& view) = 0;
  // Exit radiance towards that eye, linear, with alpha 1, into the framebuffer that is bound, by depth test:
  // both sides of each triangle. Positions are those of the SurfaceMesh.
  virtual void draw(const Eigen::Matrix4f& clip_from_position) const = 0;
  // Of buffers and textures, without the SurfaceMesh.
  virtual std::size_t gpuBytes() const = 0;
};

// Which packs a technique plays, what it asks of the light, and how it is made. Passes that are worth a time
// of their own are GpuPass.
struct PlayedTechnique {
  const char* name;
  bool (*plays)(const formats::Pack& pack);
  transport::LightNeeds (*needs)(const formats::Pack& pack);
  // The pack may go afterwards; `mesh` outlives the technique. Without `near_light`, setLight never gets any.
  // Throws std::invalid_argument if the pack's parts do not fit together.
  std::unique_ptr<Technique> (*make)(const formats::Pack& pack, const SurfaceMesh& mesh, bool near_light);
};
// The list; the last that plays a pack is taken. A technique of a program's own is added at its start.
std::vector<PlayedTechnique>& techniques();

// Throws Error(kBadInput) if none plays the pack. Needs no GL.
const PlayedTechnique& techniqueFor(const formats::Pack& pack);

}  // namespace bakelight::player
