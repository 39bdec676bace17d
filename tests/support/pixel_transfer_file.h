// A file as transfer writes it for madePixelTransfer.
#pragma once

#include "formats/mesh_ply.h"
#include "formats/tensors.h"
#include "tests/support/made_pixel_pack.h"

namespace bakelight::tests {

inline formats::TensorFile pixelTransferFile(const formats::TriangleMesh& mesh) {
  using formats::ElementType;
  using formats::Tensor;
  const formats::PixelTransfer transfer = madePixelTransfer(mesh);
  const formats::PixelTransferRows rows(transfer);
  const formats::PixelCodes codes = rows.view();
  const auto entries = static_cast<std::uint64_t>(codes.codes.size());
  std::vector<float> tangents, normals;
  for (const formats::Float4& t : transfer.tangents) tangents.insert(tangents.end(), t.begin(), t.end());
  for (const formats::Float3& n : mesh.normals) normals.insert(normals.end(), n.begin(), n.end());
  formats::TensorFile file;
  file.metadata = {{"technique", "pixel"},    {"cube_side", "3"},
                   {"local_side", "4"},       {"subsamples", "2"},
                   {"transport", "shadowed"}, {"mesh_hash", formats::geometryHash(mesh)}};
  file.tensors["codes"] = Tensor::from(ElementType::kUint8, {entries}, codes.codes);
  file.tensors["columns"] = Tensor::from(ElementType::kUint16, {entries}, codes.columns);
  file.tensors["row_offsets"] = Tensor::from(
      ElementType::kInt64, {static_cast<std::uint64_t>(codes.row_offsets.size())}, codes.row_offsets);
  file.tensors["tangents"] =
      Tensor::from(ElementType::kFloat32, {mesh.vertexCount(), 4}, std::span<const float>(tangents));
  file.tensors["normals"] =
      Tensor::from(ElementType::kFloat32, {mesh.vertexCount(), 3}, std::span<const float>(normals));
  return file;
}

}  // namespace bakelight::tests
