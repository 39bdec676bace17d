#include "tools/player/operators/cluster_operator.h"

#include <cstdint>

#include "tools/player/gl/gl_program.h"

namespace bakelight::player {

ClusterOperator::ClusterOperator(const formats::ShTransfer& transfer,
                                 const formats::ClusteredOperator& clustered, std::size_t largest_block_bytes)
    : weights_(clustered.weights, transfer.glossy.value().output_order, largest_block_bytes),
      basis_(transfer, clustered.basis, largest_block_bytes),
      clusters_(makeBuffer(clustered.clusters.size() * sizeof(std::uint32_t), clustered.clusters.data())),
      program_(makeComputeProgram({kTableGlsl, kClusterComp}, weights_.definitions())) {
  const std::size_t cluster_size = 1 + weights_.table().columns();
  const std::size_t rows = basis_.rows().table().rows();
  requireFit(rows % cluster_size == 0 && clustered.clusters.size() == weights_.table().rows());
  for (const std::uint32_t cluster : clustered.clusters) requireFit(cluster < rows / cluster_size);
}

void ClusterOperator::evaluate(const Buffer& light) {
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, light.name());
  basis_.run();
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, basis_.rows().values().name());
  weights_.run(program_, weights_.coefficients(), &clusters_);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

std::size_t ClusterOperator::gpuBytes() const {
  return weights_.gpuBytes() + basis_.rows().gpuBytes() + sizeInBytes(clusters_);
}

std::size_t ClusterOperator::dispatchCount() const {
  return weights_.dispatchCount() + basis_.rows().dispatchCount();
}

}  // namespace bakelight::player
