// Shading at the vertices of a pack, interpolated between them: SH transfer under Lambert, lobes or BRDF
// tables. What the player's shaders compute, on the CPU.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "formats/pack_contents.h"
#include "transport/glossy_evaluator.h"
#include "transport/pack_shading.h"
#include "transport/sh.h"

namespace bakelight::transport {

class VertexShading final : public PackShading {
 public:
  // SH transfer whose reflections are those of formats::reflectionKinds.
  static bool shades(const formats::Pack& pack);
  // Decodes the diffuse vectors and lays glossy tables out (GlossyEvaluator). Throws std::invalid_argument if
  // the pack's tables do not fit its mesh.
  explicit VertexShading(const formats::Pack& pack);

  LightNeeds needs() const override;
  // Diffuse exit radiance, and transferred radiance of a glossy pack (output_order² × RGB a vertex). Near
  // light goes through near_field where the pack has it, else as if from far away. On all TBB threads.
  void setLight(std::span<const Float3> distant, std::span<const Float3> near) override;
  // The diffuse part plus what the reflection makes of transferred radiance; nothing to do for a pack
  // without. On all TBB threads; the same bytes whatever their number.
  void setView(const ViewPoint& view) override;
  void radianceAt(std::span<const SurfaceHit> hits, std::span<Float3> radiance) const override;

  // Exit radiance of each vertex, base colour and vertex colours included.
  std::span<const Float3> vertexRadiance() const { return glossy_ ? radiance_ : diffuse_; }

 private:
  // Vertices that reflect alike, beside the diffuse part.
  struct Reflection {
    formats::VertexRange vertices;
    std::vector<double> kernel;  // of a lobe; empty for a table
    formats::Float3 specular_color = {1, 1, 1};
    formats::BrdfTable table;
    std::vector<ShRotation> local_from_object;  // for a table after visibility: rows need the local frame
  };

  void prepareGlossy(const formats::Pack& pack);
  Reflection reflectionOf(const formats::PackPart& part, const formats::VertexRange& vertices) const;
  void setDiffuse(std::span<const Float3> light, std::span<const Float3> near_light);
  Float3 lobeReflection(const Reflection& reflection, std::size_t vertex, const Vec3& eye) const;
  Float3 tableReflection(const Reflection& reflection, std::size_t vertex, const Vec3& eye) const;

  int order_, channels_;
  std::optional<Vec3> near_center_;
  std::vector<formats::Triangle> triangles_;
  std::vector<float> vectors_, near_vectors_;  // near_vectors_: empty where vectors_ serve for both
  std::vector<Float3> albedo_;

  // Glossy packs only.
  std::unique_ptr<const GlossyEvaluator> glossy_;
  int output_order_ = 0;
  bool object_frame_ = false;  // that of transferred_; else local
  std::vector<Reflection> reflections_;
  std::vector<Float3> positions_, normals_;
  std::vector<formats::Float4> tangents_;

  std::vector<Float3> diffuse_, transferred_, radiance_;
};

}  // namespace bakelight::transport
