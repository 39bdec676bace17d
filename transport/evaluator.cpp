#include "transport/evaluator.h"

#include <tbb/parallel_for.h>

#include <stdexcept>

namespace bakelight::transport {

std::vector<Float3> evaluateDiffuse(std::span<const float> vectors, int order,
                                    std::span<const Float3> light) {
  const std::size_t count = coefficientCount(order);
  if (light.size() < count || vectors.size() % count != 0)
    throw std::invalid_argument("transfer vectors and light do not fit together");
  std::vector<Float3> radiance(vectors.size() / count);
  tbb::parallel_for(std::size_t{0}, radiance.size(), [&](std::size_t vertex) {
    const float* vector = &vectors[vertex * count];
    Float3 sum = {0, 0, 0};
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < 3; ++c) sum[c] += vector[i] * light[i][c];
    radiance[vertex] = sum;
  });
  return radiance;
}

}  // namespace bakelight::transport
