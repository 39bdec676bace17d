// Glossy run-time evaluation on the CPU: what the player's shaders compute, from tables at any of the
// storages and precisions, with the widest vector instructions at hand.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "formats/pack_contents.h"
#include "transport/lights.h"

namespace bakelight::transport {

class GlossyEvaluator {
 public:
  // Re-lays the tables for vector instructions (16 vertices side by side), at their precision. Throws
  // std::invalid_argument if the transfer has no matrices or sizes do not fit together.
  explicit GlossyEvaluator(const formats::RadianceTransfer& transfer);
  ~GlossyEvaluator();
  GlossyEvaluator(const GlossyEvaluator&) = delete;
  GlossyEvaluator& operator=(const GlossyEvaluator&) = delete;

  // n × row_order² × RGB: incident radiance after the object's own shadows and bounces, matrix · light. In
  // the local frame for kMatrix and kCpca, in the object frame for kVisibility. `light` has at least order²
  // entries.
  std::vector<Float3> transferredRadiance(std::span<const Float3> light) const;
  // The same into `transferred`, which is overwritten.
  void transferredRadiance(std::span<const Float3> light, std::span<Float3> transferred) const;

  // The order in which the evaluator works on vertices, in tiles of kTile: those of a cluster together. A
  // place that no vertex takes, at the end of a cluster, names any of them.
  static constexpr std::size_t kTile = 16;
  std::span<const std::uint32_t> vertexOrder() const;

  // Exit radiance of each vertex: Σ_i rows[v][i] · transferred[v][i], without storing the transferred
  // radiance. `rows` are in the frame named above and in the order above: tiles × row_order² × kTile, so that
  // they are read as one stream. `radiance` has n entries, in the mesh's order. Overwrites. On all TBB
  // threads; the same bytes whatever their number.
  void shade(std::span<const Float3> light, std::span<const float> rows, std::span<Float3> radiance) const;

  // Bytes that one evaluation reads, without light and rows; multiply-adds it cannot do without (padding left
  // out).
  std::size_t tableBytes() const;
  double multiplyAdds() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// Rows of a lobe for an eye at `eye` (object space), in the order of shade(); in the object frame if
// `object_frame`, else in the local frame of normals and tangents.
std::vector<float> lobeRows(const formats::Pack& pack, std::span<const double> kernel, const Vec3& eye,
                            bool object_frame, std::span<const std::uint32_t> vertex_order);

// Exit radiance of each vertex towards `eye`, base colour and vertex colours included: diffuse part plus
// glossy part of the pack's material. `light` is distant light in the object's frame; `near_light` (empty, or
// order² entries) is what the virtual sphere's centre sees of near emitters, through near_vectors where the
// pack has them, else as distant light. The player's picture is this, interpolated. A PackEvaluator
// (pack_evaluator.h) for one light and one view.
std::vector<Float3> evaluatePack(const formats::Pack& pack, std::span<const Float3> light,
                                 std::span<const Float3> near_light, const Vec3& eye);

}  // namespace bakelight::transport
