// Values for vertices that have none of their own, from their neighbors.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::transport {

// Gives each buried vertex the mean row of its neighbours, ring by ring from where the surface comes out. A
// component that is buried as a whole stays as it is: nobody sees it. Linear in the table.
class BuriedFill {
 public:
  BuriedFill() = default;
  // `buried` has one entry a vertex.
  BuriedFill(const formats::TriangleMesh& mesh, std::span<const std::uint8_t> buried);

  std::uint64_t filledVertices() const { return steps_.size(); }
  // `table` has at least one row of `row_size` a vertex.
  void apply(std::span<float> table, std::size_t row_size) const;

 private:
  struct Step {
    std::uint32_t vertex;
    std::vector<std::uint32_t> sources;  // done before it
  };
  std::vector<Step> steps_;
};

}  // namespace bakelight::transport
