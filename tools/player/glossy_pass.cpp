#include "tools/player/glossy_pass.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

#include "tools/player/gl_context.h"
#include "tools/player/gl_program.h"
#include "transport/glossy.h"
#include "transport/triple_product.h"

namespace bakelight::player {
namespace {

using formats::Float3;
using formats::LobeModel;
using transport::Vec3;

std::vector<float> kernelOf(const formats::GlossyMaterial& material, int row_order) {
  std::vector<double> kernel;
  if (material.model == LobeModel::kPhong) kernel = transport::phongKernel(row_order, material.exponent);
  if (material.model == LobeModel::kGgx) kernel = transport::ggxKernel(row_order, material.roughness);
  return {kernel.begin(), kernel.end()};
}

std::string definitionsOf(const formats::RadianceTransfer& transfer, bool object_frame) {
  const auto unsignedText = [](int value) { return std::to_string(value) + "u\n"; };
  std::string text = "#define ROW_ORDER " + unsignedText(transfer.row_order);
  if (object_frame) text += "#define OBJECT_FRAME\n";
  if (transfer.material.model == LobeModel::kTable) {
    text += "#define BRDF_ANGLES " + unsignedText(transfer.material.table.angles);
    text += "#define BRDF_COEFFICIENTS " +
            unsignedText(transport::coefficientCount(transfer.material.table.order));
  }
  return text;
}

Buffer bufferOf(const auto& values) {
  return makeBuffer(values.size() * sizeof(values[0]), values.data());
}

// Columns t, b, n, made orthonormal to the last digit.
Eigen::Matrix3d objectFromLocal(const Float3& normal, const formats::Float4& tangent) {
  const Vec3 n = transport::vec3(normal).normalized(), along(tangent[0], tangent[1], tangent[2]);
  const Vec3 t = (along - along.dot(n) * n).normalized();
  Eigen::Matrix3d frame;
  frame << t, tangent[3] * n.cross(t), n;
  return frame;
}

}  // namespace

GlossyPass::GlossyPass(const formats::Pack& pack, const Vec3& origin, bool object_frame,
                       std::size_t largest_block_bytes)
    : specular_color_(pack.transfer.material.specular_color),
      kernel_(kernelOf(pack.transfer.material, pack.transfer.row_order)),
      origin_(origin),
      transferred_bytes_(transport::coefficientCount(pack.transfer.row_order) * sizeof(Float3)),
      ranges_(rowRanges(pack.mesh.vertexCount(), transferred_bytes_, 1, largest_block_bytes)),
      program_(makeComputeProgram({kGlossyComp}, definitionsOf(pack.transfer, object_frame))) {
  const auto& material = pack.transfer.material;
  const std::size_t count = pack.mesh.vertexCount();
  if (pack.mesh.normals.size() != count || pack.transfer.tangents.size() != count)
    throw std::invalid_argument("a glossy pack needs a frame a vertex");
  if (material.model == LobeModel::kTable) {
    if (object_frame || material.table.order < pack.transfer.row_order)
      throw std::invalid_argument("BRDF table and transfer do not fit together");
    brdf_ = bufferOf(material.table.values);
  }
  std::vector<Float3> positions;
  for (const auto& position : pack.mesh.positions)
    positions.push_back(transport::float3(transport::vec3(position) - origin));
  positions_ = bufferOf(positions);
  normals_ = bufferOf(pack.mesh.normals);
  tangents_ = bufferOf(pack.transfer.tangents);
  radiance_ = makeBuffer(count * sizeof(Float3), nullptr);
  throwIfGlFailed("preparing the glossy pass");
}

void GlossyPass::evaluate(const Vec3& eye, const Buffer& transferred, const Buffer& diffuse) const {
  glUseProgram(program_.name());
  const Float3 from_origin = transport::float3(eye - origin_);
  glUniform3fv(1, 1, from_origin.data());
  if (brdf_.name() != 0) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, brdf_.name());
  } else {
    glUniform3fv(2, 1, specular_color_.data());
    glUniform1fv(3, static_cast<GLsizei>(kernel_.size()), kernel_.data());
  }
  for (const RowRange& range : ranges_) {
    bindRows(0, transferred, range, transferred_bytes_);
    bindRows(1, positions_, range, sizeof(Float3));
    bindRows(2, radiance_, range, sizeof(Float3));
    bindRows(3, normals_, range, sizeof(Float3));
    bindRows(4, tangents_, range, sizeof(formats::Float4));
    bindRows(5, diffuse, range, sizeof(Float3));
    glUniform1ui(0, static_cast<GLuint>(range.count));
    dispatchItems(range.count);
  }
  glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  throwIfGlFailed("reflecting towards the eye");
}

std::size_t GlossyPass::gpuBytes() const {
  return sizeInBytes(positions_) + sizeInBytes(normals_) + sizeInBytes(tangents_) + sizeInBytes(brdf_) +
         sizeInBytes(radiance_);
}

formats::RadianceTransfer matricesFromVisibility(const formats::Pack& pack) {
  const formats::RadianceTransfer& source = pack.transfer;
  const transport::TripleProduct product(source.row_order, source.order);
  const std::size_t rows = transport::coefficientCount(source.row_order);
  const std::size_t columns = transport::coefficientCount(source.order);
  const std::vector<float> visibility = source.matrices.decode();
  std::vector<float> matrices(pack.mesh.vertexCount() * rows * columns);
  tbb::parallel_for(std::size_t{0}, pack.mesh.vertexCount(), [&](std::size_t v) {
    std::vector<float> matrix(rows * columns);
    product.matrixOf(std::span(visibility).subspan(v * source.matrices.columns, source.matrices.columns),
                     matrix);
    // A left-handed frame is a right-handed one mirrored in y, which turns the sign of every m < 0.
    Eigen::Matrix3d frame = objectFromLocal(pack.mesh.normals[v], source.tangents[v]);
    const bool mirrored = frame.determinant() < 0;
    if (mirrored) frame.col(1) = -frame.col(1);
    const transport::ShRotation local_from_object(source.row_order, frame.transpose());
    std::vector<double> column(rows), turned(rows);
    for (std::size_t j = 0; j < columns; ++j) {
      for (std::size_t i = 0; i < rows; ++i) column[i] = matrix[i * columns + j];
      local_from_object.apply(column, turned);
      for (int l = 0; l < source.row_order; ++l)
        for (int m = -l; m <= l; ++m) {
          const int i = transport::coefficientIndex(l, m);
          matrices[(v * rows + i) * columns + j] =
              static_cast<float>(mirrored && m < 0 ? -turned[i] : turned[i]);
        }
    }
  });
  formats::RadianceTransfer result;
  result.order = source.order;
  result.row_order = source.row_order;
  result.storage = formats::MatrixStorage::kMatrix;
  result.matrices = formats::EncodedTable{formats::Precision::kFloat32,
                                          pack.mesh.vertexCount(),
                                          rows * columns,
                                          formats::Bytes(matrices.size() * sizeof(float)),
                                          {},
                                          {}};
  std::memcpy(result.matrices.data.data(), matrices.data(), result.matrices.data.size());
  return result;
}

}  // namespace bakelight::player
