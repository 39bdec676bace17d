// What the player shows, for rays: mesh and emitters in the world, materials and lights.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/frame_settings.h"
#include "formats/light_rig.h"
#include "formats/material.h"
#include "formats/triangle_mesh.h"
#include "patch/patch_geometry.h"
#include "tools/reference/bsdf.h"
#include "tools/reference/emitter_sampler.h"
#include "tools/reference/random_walk.h"
#include "tools/reference/subsurface.h"
#include "transport/camera.h"
#include "transport/punctual_light.h"
#include "transport/ray_scene.h"
#include "transport/surface_points.h"

namespace bakelight::reference {

// A point that reflects light.
struct ShadingPoint {
  Vec3 origin;  // where its rays start, off the surface
  Vec3 normal;  // for shading, on the side that is seen
  Rgb albedo;
  std::uint32_t material = 0;                        // see Scene::material
  Vec3 position = Vec3::Zero();                      // on the surface
  std::uint32_t triangle = RandomWalk::kNoTriangle;  // that it lies in; none at a vertex
  bool back_face = false;                            // the triangle's clockwise side is seen
  Rgb reflectance = Rgb::Ones();                     // of the medium, where that is the albedo
};

// How light that enters a medium comes out again.
enum class Translucency {
  kDiffusion,  // as the medium's diffusion model says, which packs show
  kRandomWalk  // through the medium itself
};
inline constexpr formats::Word<Translucency> kTranslucencies[] = {{"diffusion", Translucency::kDiffusion},
                                                                  {"random_walk", Translucency::kRandomWalk}};

// What the picture is of.
struct Surface {
  formats::TriangleMesh mesh;          // with normals; its own colours are not looked at
  formats::SurfaceMaterials material;  // of this mesh
  ReflectionModel model = ReflectionModel::kPhysical;
  std::map<std::string, formats::BrdfTable> tables = {};  // with kTable: by material, or "" for all others
  // By number of the material, or empty: what multiplies the albedo (textureAt of the mesh's texture coordinates).
  std::vector<std::shared_ptr<const patch::PatchGeometry>> textures = {};
  // How far off the surface rays start, in radii of the bounding sphere.
  double bias = transport::kDefaultBias;
  Translucency translucency = Translucency::kDiffusion;
};

class Scene {
 public:
  // Camera, turn of the object and lengths of the rig refer to `bounds`: the mesh's bounding sphere, or that
  // of another mesh of which this one is a variant. Throws Error(kBadInput) for a mesh without triangles or
  // without a normal a vertex, and what DistantLightSampler and RayScene throw.
  Scene(const Surface& surface, const formats::LightRig& rig, const formats::FrameSettings& frame,
        const transport::BoundingSphere& bounds);

  const formats::TriangleMesh& mesh() const {
    return mesh_;
  }  // in the world; colors as Subsurface takes them
  // The same and the emitters after it: positions and triangles that rays meet.
  const formats::TriangleMesh& rayMesh() const { return ray_mesh_; }
  const Glossy& material(std::uint32_t number) const { return materials_[number]; }
  // Of what reflects diffusely and is no part of the mesh.
  std::uint32_t diffuseMaterial() const { return static_cast<std::uint32_t>(materials_.size() - 1); }
  // What light that enters does there, by the surface's translucency; null where none enters, and where it is the other's.
  const Subsurface* subsurface(std::uint32_t number) const {
    return number < subsurfaces_.size() ? subsurfaces_[number].get() : nullptr;
  }
  const RandomWalk* randomWalk(std::uint32_t number) const {
    return number < random_walks_.size() ? random_walks_[number].get() : nullptr;
  }
  const DistantLightSampler& distantLight() const { return distant_; }
  const EmitterSampler& emitters() const { return emitters_; }

  const std::vector<transport::PlacedPunctualLight>& punctualLights() const { return punctual_; }

  // Triangles of the rays' scenes: the mesh's, then the emitters'.
  bool isEmitter(std::uint32_t triangle) const { return triangle >= mesh_.triangleCount(); }
  std::uint32_t emitterTriangle(std::uint32_t triangle) const {
    return triangle - static_cast<std::uint32_t>(mesh_.triangleCount());
  }

  const transport::RayScene& rays() const { return rays_; }
  // The emitters alone, for light without the object's shadows; their triangles count from 0.
  const transport::RayScene& emitterRays() const { return emitter_rays_; }

  // Where a ray met the mesh: interpolated normal and albedo, both turned to the side that was hit. Rays
  // start where they would from a smooth surface through the vertices (transport::smoothPoint), then off it by the bias of a bake, so
  // that a smooth convex body does not shadow itself.
  ShadingPoint pointAt(const transport::Hit& hit) const;
  // A vertex from its front, as a bake sees it (transport::frontPoints).
  ShadingPoint pointAtVertex(std::uint32_t vertex) const;

 private:
  Scene(const Surface& surface, const formats::LightRig& rig, const formats::FrameSettings& frame,
        const transport::BoundingSphere& bounds, const transport::EmitterMesh& emitters);
  Rgb albedoOf(std::uint32_t vertex) const;  // without a texture
  Rgb textureAt(std::uint32_t material, const formats::Float2& texcoord) const;

  formats::TriangleMesh mesh_;
  std::vector<transport::Float3> vertex_origins_;
  Rgb albedo_;
  std::vector<transport::Float3> vertex_albedo_;
  std::vector<Glossy> materials_;
  std::vector<std::shared_ptr<const patch::PatchGeometry>> textures_;
  std::vector<std::uint32_t> material_of_triangle_, material_of_vertex_;  // empty: all have the first
  DistantLightSampler distant_;
  EmitterSampler emitters_;
  formats::TriangleMesh ray_mesh_;
  transport::RayScene rays_, emitter_rays_;
  std::vector<transport::PlacedPunctualLight> punctual_;
  double offset_;                                               // of rays, off the surface
  std::vector<std::unique_ptr<const Subsurface>> subsurfaces_;  // by material
  std::vector<std::unique_ptr<const RandomWalk>> random_walks_;
};

}  // namespace bakelight::reference
