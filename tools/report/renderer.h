// Pictures of packs in the views of a plan, as the player shows them, on the CPU.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formats/pack_contents.h"
#include "tools/report/gbuffer.h"
#include "tools/report/plan.h"
#include "tools/report/sources.h"
#include "transport/lighting.h"
#include "transport/pack_shading.h"

namespace bakelight::report {

class Renderer {
 public:
  // `cameras` has one entry a view. Plan and sources must outlive the renderer.
  Renderer(const Plan& plan, std::vector<transport::OrbitCamera> cameras, const Sources& sources);

  // What a PackShading is given in a view.
  struct Conditions {
    transport::ShLight distant;           // as the light stands, of the order needed
    Eigen::Matrix3d object_from_light;    // turns it into the object's frame
    transport::ShLight near;              // in the object's frame; empty without emitters
    std::vector<transport::Float3> cube;  // all light in the object's frame, where a cube map is needed
    std::vector<transport::PlacedPunctualLight> punctual;  // in the object's frame
    transport::Occlusion shadows;                          // of the object, where there are any
    transport::Vec3 eye;                                   // in the object's space

    // `turn` turns the light first; not of a cube map, which stays as it is: see turnedCube.
    void light(transport::PackShading& shading,
               const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity()) const;
    // The cube map of light that was turned first. Slow, as lights are drawn into it again.
    std::vector<transport::Float3> turnedCube(const Eigen::Matrix3d& turn) const { return cube_of(turn); }
    std::function<std::vector<transport::Float3>(const Eigen::Matrix3d&)> cube_of = {};
  };
  Conditions conditions(const formats::TriangleMesh& mesh, const transport::LightNeeds& needs,
                        std::size_t view);

  // One picture a view. Meshes and lights that were seen before are not traced or projected again. `light`, if any, is what lights
  // the pack instead of Conditions::light.
  using LightUp = std::function<void(std::size_t view, const Conditions&, transport::PackShading&)>;
  std::vector<Picture> picturesOf(const formats::Pack& pack, const LightUp& light = {});

  // In place of empty pixels of that picture of a pack that `reference` covers, the ground that it stands on where that is opaque, under the conditions' light; nothing for a
  // pack that has none.
  void addGround(const formats::Pack& pack, std::size_t view, const Conditions& conditions,
                 const Picture& reference, Picture& picture) const;

  // The player's factor on radiance in that view (transport::exposureFactor).
  double exposure(const formats::TriangleMesh& mesh, const transport::LightNeeds& needs, std::size_t view);

 private:
  const transport::Lighting& lighting(std::size_t view, int order);
  const GBuffer& gbuffer(const formats::Pack& pack, std::size_t view, const transport::EmitterMesh& emitters);

  const Plan& plan_;
  std::vector<transport::OrbitCamera> cameras_;
  const Sources& sources_;
  std::map<std::pair<std::size_t, int>, transport::Lighting> lightings_;  // by view and order
  std::map<std::string, transport::Occlusion> shadows_;                   // by mesh
  std::map<std::pair<std::string, std::size_t>, GBuffer> gbuffers_;       // by mesh and view
};

}  // namespace bakelight::report
