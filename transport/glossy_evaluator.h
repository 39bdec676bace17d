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
  explicit GlossyEvaluator(const formats::ShTransfer& transfer);
  ~GlossyEvaluator();
  GlossyEvaluator(const GlossyEvaluator&) = delete;
  GlossyEvaluator& operator=(const GlossyEvaluator&) = delete;

  // n × output_order² × RGB: incident radiance after the object's own shadows and bounces, matrix · light. In
  // the local frame, for visibility in the object's. `light` has at least order²
  // entries.
  std::vector<Float3> transferredRadiance(std::span<const Float3> light) const;
  // The same into `transferred`, which is overwritten.
  void transferredRadiance(std::span<const Float3> light, std::span<Float3> transferred) const;

  // Bytes that one evaluation reads, without the light; multiply-adds it cannot do without (padding left
  // out).
  std::size_t tableBytes() const;
  double multiplyAdds() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::transport
