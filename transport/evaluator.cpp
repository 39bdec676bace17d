#include "transport/evaluator.h"

#include <tbb/parallel_for.h>

#include <stdexcept>

namespace bakelight::transport {

std::vector<Float3> evaluateDiffuse(std::span<const float> vectors, int order, std::span<const Float3> light,
                                    int channels) {
  const std::size_t count = coefficientCount(order), row = channels * count;
  if (light.size() < count || (channels != 1 && channels != 3) || vectors.size() % row != 0)
    throw std::invalid_argument("transfer vectors and light do not fit together");
  std::vector<Float3> radiance(vectors.size() / row);
  tbb::parallel_for(std::size_t{0}, radiance.size(), [&](std::size_t vertex) {
    const float* vector = &vectors[vertex * row];
    Float3 sum = {0, 0, 0};
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < 3; ++c) sum[c] += vector[channels == 3 ? c * count + i : i] * light[i][c];
    radiance[vertex] = sum;
  });
  return radiance;
}

}  // namespace bakelight::transport
