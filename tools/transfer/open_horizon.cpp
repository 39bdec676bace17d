#include "tools/transfer/open_horizon.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tools/transfer/matrices.h"
#include "tools/transfer/surface_points.h"
#include "transport/sh.h"

namespace bakelight::transfer {
namespace {

// The half below the tangent plane, as visibility in the object's frame.
std::vector<float> halfBelow(int order, const Float3& normal) {
  const std::vector<double> zonal = transport::diskLightZonal(order, std::numbers::pi / 2);
  const std::vector<double> half = transport::orientZonal(zonal, -transport::vec3(normal).normalized());
  return {half.begin(), half.end()};
}

}  // namespace

void openHorizons(const formats::TriangleMesh& mesh, const TransferOptions& options, Transfer& transfer) {
  const int order = options.row_order + options.order - 1;
  const std::size_t matrix = static_cast<std::size_t>(transport::coefficientCount(options.row_order)) *
                             transport::coefficientCount(options.order),
                    channels = static_cast<std::size_t>(transfer.channels);
  const MatrixBaker baker(options.row_order, options.order);
  tbb::parallel_for(std::size_t{0}, mesh.vertexCount(), [&](std::size_t v) {
    const std::vector<float> half = halfBelow(order, mesh.normals[v]);
    if (!transfer.visibility.empty())
      for (std::size_t i = 0; i < half.size(); ++i) transfer.visibility[v * half.size() + i] += half[i];
    if (transfer.matrices.empty()) return;
    std::vector<float> passes(matrix);
    baker.fromVisibility(half, passes);
    baker.turnRows(localFromObject(mesh.normals[v], transfer.tangents[v]), passes);
    for (std::size_t c = 0; c < channels; ++c)
      for (std::size_t i = 0; i < matrix; ++i)
        transfer.matrices[(v * channels + c) * matrix + i] += passes[i];
  });
}

}  // namespace bakelight::transfer
