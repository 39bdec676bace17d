// A surface that wears factored patches (formats/factored_patch.h): Σ_k factors_k(q, v) · projected_k of each pixel. What projects
// light onto the components of each vertex is its techniques' business. transport::PatchLookup looks patches up on the CPU.
#pragma once

#include <array>
#include <cstddef>
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "formats/factored_patch.h"
#include "formats/pack_contents.h"
#include "formats/triangle_mesh.h"
#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/gl_program.h"
#include "transport/pack_shading.h"

namespace bakelight::player {

// Of one appearance: whose it is, and what it is indexed by (null: texture coordinates).
struct SurfacePatch {
  const formats::FactoredPatch* patch = nullptr;
  const formats::PackImage* index = nullptr;
  // Vertices of the patch from here on come by nines, for a triangle that is there three times: nothing is interpolated across
  // it, and each of the three, whose vertices all have the frame of another corner, is drawn where that corner is the nearest by
  // barycentric coordinates.
  std::optional<std::size_t> first_creased = {};
};

class PatchSurface {
 public:
  // Components by fours: what a texel of a texture and an attribute of a vertex hold.
  static constexpr std::size_t kGroup = 4;

  // `mesh` with a normal a vertex; a patch for each material of its triangles. Positions go to the GPU from `origin`. Patches and
  // images need not outlive the constructor. Throws Error(kBadInput) for what the GPU has no room for.
  PatchSurface(const formats::TriangleMesh& mesh, std::span<const formats::Float4> tangents,
               const std::vector<SurfacePatch>& patches, const transport::Vec3& origin);

  // What is drawn: n × mostGroups() × RGB × kGroup floats, whose writer sees to the barrier.
  const Buffer& projected() const { return projected_; }
  std::size_t mostGroups() const { return most_groups_; }
  // Of a patch, filled up with components that are zero: draws × groups at once.
  std::size_t drawCount(std::size_t patch) const { return patches_[patch].draws.size(); }
  std::size_t groupsAtOnce(std::size_t patch) const { return patches_[patch].groups_at_once; }
  // Its basis for a draw: incident values × RGB × groups at once × kGroup components.
  static std::vector<float> basisOf(const formats::FactoredPatch& patch, std::size_t incident_values,
                                    std::size_t first_group, std::size_t groups);

  void lookFrom(const transport::ViewPoint& view);
  // Into the framebuffer that is bound.
  void draw(const Eigen::Matrix4f& clip_from_position) const;
  std::size_t gpuBytes() const;

 private:
  struct Patch {
    GLsizei index_count = 0;
    Buffer indices;
    std::size_t groups = 0, groups_at_once = 0;
    int views = 1;
    float texel_width = 1;
    std::array<float, 2> repeats = {1, 1};  // texture coordinates to places of the patch, without an index
    std::vector<std::array<GLint, 4>>
        levels;  // x, y, width and height in the texture of factors: in texels of the patch
    Texture factors;
    bool relief = false;
    Texture heights, slopes;  // with relief: a layer a view, a texel a view
    float start_height = 0;
    std::size_t texture_bytes = 0;
    const Texture* index = nullptr;
    std::optional<std::size_t> first_creased;
    std::array<float, 4> index_decoding = {1, 1, 0, 0};  // scale, offset
    Program program;
    std::vector<VertexArray> draws;
  };

  void uploadFactors(const formats::FactoredPatch& source, Patch& patch);
  void uploadRelief(const formats::FactoredPatch& source, Patch& patch);
  void addDraws(Patch& patch);
  void drawDepth(const Eigen::Matrix4f& clip_from_position) const;

  transport::Vec3 origin_;
  std::size_t most_groups_ = 0;
  Buffer positions_, normals_, tangents_, texcoords_, indices_;
  GLsizei index_count_ = 0;
  Buffer projected_;
  std::vector<std::unique_ptr<Texture>> index_images_;
  std::size_t index_bytes_ = 0;
  std::vector<Patch> patches_;
  Program depth_program_;
  VertexArray depth_vertices_;
  formats::Float3 eye_ = {0, 0, 0};
  float pixel_angle_ = 0;
};

}  // namespace bakelight::player
