#include "tools/inspect/tensor_figures.h"

#include <cmath>
#include <Eigen/Core>

#include "transport/sh.h"

namespace bakelight::inspect {

using formats::ElementType;
using formats::Tensor;

double elementOf(const Tensor& tensor, std::uint64_t index) {
  switch (tensor.type) {
    case ElementType::kFloat32:
      return tensor.as<float>()[index];
    case ElementType::kFloat16:
      return static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(tensor.as<std::uint16_t>()[index]));
    case ElementType::kFloat64:
      return tensor.as<double>()[index];
    case ElementType::kUint8:
      return tensor.as<std::uint8_t>()[index];
    case ElementType::kUint16:
      return tensor.as<std::uint16_t>()[index];
    case ElementType::kUint32:
      return tensor.as<std::uint32_t>()[index];
    case ElementType::kInt32:
      return tensor.as<std::int32_t>()[index];
    case ElementType::kInt64:
      return static_cast<double>(tensor.as<std::int64_t>()[index]);
  }
  return 0;
}

Moments measureTensor(const Tensor& tensor) {
  Moments moments;
  for (std::uint64_t i = 0; i < tensor.elementCount(); ++i) moments.add(elementOf(tensor, i));
  return moments;
}

std::vector<double> bandEnergies(std::span<const float> vectors, int order) {
  const auto count = static_cast<std::size_t>(transport::coefficientCount(order));
  std::vector<double> energies(static_cast<std::size_t>(order), 0.0);
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    const auto band = static_cast<std::size_t>(std::sqrt(static_cast<double>(i % count)));
    energies[band] += static_cast<double>(vectors[i]) * vectors[i];
  }
  const std::size_t row_count = vectors.size() / count;
  const auto rows = static_cast<double>(row_count);
  for (double& energy : energies) energy /= rows;
  return energies;
}

int orderOfColumns(std::uint64_t columns) {
  for (int order = 1; order <= transport::kMaxOrder; ++order)
    if (columns == static_cast<std::uint64_t>(transport::coefficientCount(order))) return order;
  return 0;
}

}  // namespace bakelight::inspect
