// Bi-scale shading (Sloan, Liu, Shum & Snyder 2003): transferred radiance at the vertices, radiance transfer textures at the
// pixels. transport::BiScaleShading does the same on the CPU.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "formats/pack_contents.h"
#include "formats/rtt_reflection.h"
#include "tools/player/lights/total_light.h"
#include "tools/player/operators/transfer_operator.h"
#include "tools/player/techniques/technique.h"

namespace bakelight::player {

class BiScale final : public Technique {
 public:
  static bool plays(const formats::Pack& pack);
  static transport::LightNeeds needs(const formats::Pack& pack);

  BiScale(const formats::Pack& pack, const SurfaceMesh& mesh, bool near_light);

  void setLight(const GpuLight& distant, const GpuLight* near) override;
  void lookFrom(const transport::ViewPoint& view) override;
  void draw(const Eigen::Matrix4f& clip_from_position) const override;
  std::size_t gpuBytes() const override;

 private:
  // Components by fours: what a texel of a texture and an attribute of a vertex hold.
  static constexpr std::size_t kGroup = 4;
  // Groups that one draw adds up: 12 of the 16 attributes and varyings that GL guarantees.
  static constexpr std::size_t kGroupsAtOnce = 4;

  // Of up to kGroupsAtOnce groups.
  struct Draw {
    Buffer basis;  // coefficients × RGB × groups × 4 components
    VertexArray vertices;
  };
  struct Patch {
    formats::VertexRange vertices;
    GLsizei index_count = 0;
    Buffer indices;
    std::size_t groups = 0, groups_at_once = 0;
    int order = 0, views = 1;
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
    std::array<float, 4> index_decoding = {1, 1, 0, 0};  // scale, offset
    Program project_program, program;
    std::vector<Draw> draws;
  };

  void uploadFactors(const formats::RttReflection& reflection, Patch& patch);
  void uploadRelief(const formats::RttReflection& reflection, Patch& patch);
  void addDraws(const formats::RttReflection& reflection, Patch& patch);
  void drawDepth(const Eigen::Matrix4f& clip_from_position) const;
  void project();

  const SurfaceMesh& mesh_;
  int output_order_;
  std::size_t most_groups_ = 0;
  std::unique_ptr<TransferOperator> transfer_;
  TotalLight light_;
  Buffer normals_, tangents_, texcoords_, albedo_;
  Buffer projected_;  // n × most_groups_ × RGB × 4 components
  std::vector<std::unique_ptr<Texture>> index_images_;
  std::size_t index_bytes_ = 0;
  std::vector<Patch> patches_;
  Program depth_program_;
  VertexArray depth_vertices_;
  formats::Float3 eye_ = {0, 0, 0};
  float pixel_angle_ = 0;
};

}  // namespace bakelight::player
