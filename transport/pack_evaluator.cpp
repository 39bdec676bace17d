// A whole pack towards an eye: diffuse part, glossy part, colours. See transport/glossy_evaluator.h.
#include <tbb/parallel_for.h>

#include <cmath>
#include <stdexcept>

#include "transport/evaluator.h"
#include "transport/glossy.h"
#include "transport/glossy_evaluator.h"

namespace bakelight::transport {
namespace {

// Columns: tangent, bitangent, normal.
Eigen::Matrix3d objectFromLocal(const formats::Pack& pack, std::size_t vertex) {
  const formats::Float4& tangent = pack.transfer.tangents[vertex];
  Eigen::Matrix3d frame;
  frame.col(2) = vec3(pack.mesh.normals[vertex]);
  frame.col(0) = Vec3(tangent[0], tangent[1], tangent[2]);
  frame.col(1) = tangent[3] * frame.col(2).cross(frame.col(0));
  return frame;
}

// From a vertex towards the eye; along the normal for an eye at the vertex itself.
Vec3 towardsEye(const formats::Pack& pack, std::size_t vertex, const Vec3& eye) {
  const Vec3 offset = eye - vec3(pack.mesh.positions[vertex]);
  const double distance = offset.norm();
  return distance > 0 ? Vec3(offset / distance) : vec3(pack.mesh.normals[vertex]);
}

void checkFrames(const formats::Pack& pack) {
  if (pack.transfer.tangents.size() != pack.mesh.vertexCount() ||
      pack.mesh.normals.size() != pack.mesh.vertexCount())
    throw std::invalid_argument("a glossy pack needs a normal and a tangent for each vertex");
}

void add(std::vector<Float3>& sum, std::span<const Float3> more, const Float3& factor = {1, 1, 1}) {
  if (more.size() != sum.size()) throw std::invalid_argument("tables of the pack do not fit its mesh");
  for (std::size_t v = 0; v < sum.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c) sum[v][c] += factor[c] * more[v][c];
}

std::vector<Float3> diffusePart(const formats::Pack& pack, std::span<const Float3> light,
                                std::span<const Float3> near_light) {
  const formats::RadianceTransfer& transfer = pack.transfer;
  std::vector<Float3> radiance(pack.mesh.vertexCount(), Float3{0, 0, 0});
  if (transfer.vectors.empty()) return radiance;
  add(radiance, evaluateDiffuse(transfer.vectors.decode(), transfer.order, light, transfer.channels));
  if (near_light.empty()) return radiance;
  const formats::EncodedTable& vectors =
      transfer.near_vectors.empty() ? transfer.vectors : transfer.near_vectors;
  add(radiance, evaluateDiffuse(vectors.decode(), transfer.order, near_light, transfer.channels));
  return radiance;
}

// Three rows a vertex, from the table, times transferred radiance in the local frame.
std::vector<Float3> tableReflection(const formats::Pack& pack, std::span<const Float3> transferred,
                                    const Vec3& eye) {
  const formats::RadianceTransfer& transfer = pack.transfer;
  const std::size_t count = coefficientCount(transfer.row_order);
  const bool object_frame = transfer.storage == formats::MatrixStorage::kVisibility;
  std::vector<Float3> radiance(pack.mesh.vertexCount());
  tbb::parallel_for(std::size_t{0}, radiance.size(), [&](std::size_t vertex) {
    Eigen::Matrix3d frame = objectFromLocal(pack, vertex);
    std::span<const Float3> incident = transferred.subspan(vertex * count, count);
    std::vector<Float3> turned;
    if (object_frame) {
      // The table is isotropic, so any right-handed frame about the normal does.
      frame.col(1) = frame.col(2).cross(frame.col(0));
      frame = Eigen::Quaterniond(frame).normalized().toRotationMatrix();
      turned = ShRotation(transfer.row_order, frame.transpose()).apply(incident);
      incident = turned;
    }
    std::vector<double> rows(3 * count);
    tableRows(transfer.material.table, frame.transpose() * towardsEye(pack, vertex, eye), transfer.row_order,
              rows);
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = 0;
      for (std::size_t i = 0; i < count; ++i) sum += rows[c * count + i] * incident[i][c];
      radiance[vertex][c] = static_cast<float>(sum);
    }
  });
  return radiance;
}

std::vector<Float3> lobeReflection(const formats::Pack& pack, const GlossyEvaluator& evaluator,
                                   std::span<const double> kernel, std::span<const Float3> light,
                                   const Vec3& eye) {
  std::vector<Float3> radiance(pack.mesh.vertexCount());
  const bool object_frame = pack.transfer.storage == formats::MatrixStorage::kVisibility;
  evaluator.shade(light, lobeRows(pack, kernel, eye, object_frame, evaluator.vertexOrder()), radiance);
  return radiance;
}

// Near emitters have no matrices of their own: their light comes as if from far away.
ShLight allLight(std::span<const Float3> light, std::span<const Float3> near_light, int order) {
  ShLight all(light.begin(), light.begin() + coefficientCount(order));
  if (!near_light.empty()) add(all, near_light.first(all.size()));
  return all;
}

}  // namespace

std::vector<float> lobeRows(const formats::Pack& pack, std::span<const double> kernel, const Vec3& eye,
                            bool object_frame, std::span<const std::uint32_t> vertex_order) {
  constexpr std::size_t kTile = GlossyEvaluator::kTile;
  checkFrames(pack);
  const int order = static_cast<int>(kernel.size());
  const std::size_t count = coefficientCount(order);
  std::vector<float> rows(count * vertex_order.size());
  tbb::parallel_for(std::size_t{0}, vertex_order.size(), [&](std::size_t place) {
    const std::uint32_t vertex = vertex_order[place];
    float* const tile_rows = &rows[place / kTile * kTile * count + place % kTile];
    const Eigen::Matrix3d frame = objectFromLocal(pack, vertex);
    const Vec3 local_eye = frame.transpose() * towardsEye(pack, vertex, eye);
    std::array<double, kMaxOrder * kMaxOrder> row;
    if (object_frame) {
      const Vec3 reflection = frame * Vec3(-local_eye.x(), -local_eye.y(), std::abs(local_eye.z()));
      evaluateSh(order, reflection, row);
      for (int l = 0; l < order; ++l)
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) row[i] *= kernel[l];
    } else {
      lobeRow(kernel, local_eye, row);
    }
    for (std::size_t i = 0; i < count; ++i) tile_rows[i * kTile] = static_cast<float>(row[i]);
  });
  return rows;
}

std::vector<Float3> evaluatePack(const formats::Pack& pack, std::span<const Float3> light,
                                 std::span<const Float3> near_light, const Vec3& eye) {
  const formats::RadianceTransfer& transfer = pack.transfer;
  const formats::GlossyMaterial& material = transfer.material;
  const std::size_t count = coefficientCount(transfer.order);
  if (light.size() < count || (!near_light.empty() && near_light.size() < count))
    throw std::invalid_argument("the light has fewer bands than the pack");
  std::vector<Float3> radiance = diffusePart(pack, light, near_light);
  for (std::size_t v = 0; v < radiance.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c)
      radiance[v][c] *= pack.base_color[c] * (pack.colors.empty() ? 1.0f : pack.colors[v][c]);
  if (transfer.storage == formats::MatrixStorage::kNone || material.model == formats::LobeModel::kNone)
    return radiance;

  checkFrames(pack);
  const GlossyEvaluator evaluator(transfer);
  const ShLight all_light = allLight(light, near_light, transfer.order);
  switch (material.model) {
    case formats::LobeModel::kNone:
      break;
    case formats::LobeModel::kPhong:
      add(radiance,
          lobeReflection(pack, evaluator, phongKernel(transfer.row_order, material.exponent), all_light, eye),
          material.specular_color);
      break;
    case formats::LobeModel::kGgx:
      add(radiance,
          lobeReflection(pack, evaluator, ggxKernel(transfer.row_order, material.roughness), all_light, eye),
          material.specular_color);
      break;
    case formats::LobeModel::kTable:
      add(radiance, tableReflection(pack, evaluator.transferredRadiance(all_light), eye));
      break;
  }
  return radiance;
}

}  // namespace bakelight::transport
