// A whole pack at run time on the CPU, in the two steps that the player takes, so that each can be timed: a
// change of light, and a change of view.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "formats/pack_contents.h"
#include "transport/glossy_evaluator.h"
#include "transport/sh.h"

namespace bakelight::transport {

class PackEvaluator {
 public:
  // Decodes the diffuse vectors and lays glossy tables out (GlossyEvaluator); copies whatever else it needs,
  // so `pack` may go. Throws std::invalid_argument if the pack's tables do not fit its mesh.
  explicit PackEvaluator(const formats::Pack& pack);

  // Light change: diffuse exit radiance, and transferred radiance of a glossy pack (row_order² × RGB a
  // vertex). `light` is distant light in the object's frame; `near_light` (empty, or order² entries) is what
  // the virtual sphere's centre sees of near emitters, through near_vectors where the pack has them, else as
  // distant light. Throws std::invalid_argument for a light of fewer bands than the pack. On all TBB threads.
  void setLight(std::span<const Float3> light, std::span<const Float3> near_light);

  // View change: exit radiance of each vertex towards `eye` (object space), base colour and vertex colours
  // included: the diffuse part, plus rows of the eye · transferred radiance. The player's picture is this,
  // interpolated. Valid until the next call; black before the first setLight. On all TBB threads; a pack
  // without a lobe has nothing to do here.
  std::span<const Float3> radianceTowards(const Vec3& eye);

  std::size_t vertexCount() const { return diffuse_.size(); }

 private:
  void prepareGlossy(const formats::Pack& pack);
  void setDiffuse(std::span<const Float3> light, std::span<const Float3> near_light);
  Float3 lobeReflection(std::size_t vertex, const Vec3& eye) const;
  Float3 tableReflection(std::size_t vertex, const Vec3& eye) const;

  int order_, channels_;
  std::vector<float> vectors_, near_vectors_;  // near_vectors_: empty where vectors_ serve for both
  Float3 base_color_;
  std::vector<Float3> colors_;

  // Glossy packs only.
  std::unique_ptr<const GlossyEvaluator> glossy_;
  int row_order_ = 0;
  bool object_frame_ = false;  // that of transferred_; else local
  formats::GlossyMaterial material_;
  std::vector<double> kernel_;                 // of a lobe
  std::vector<ShRotation> local_from_object_;  // for a table, whose rows need the local frame
  std::vector<Float3> positions_, normals_;
  std::vector<formats::Float4> tangents_;

  std::vector<Float3> diffuse_, transferred_, radiance_;
};

}  // namespace bakelight::transport
