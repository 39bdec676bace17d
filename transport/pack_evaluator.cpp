#include "transport/pack_evaluator.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "transport/evaluator.h"
#include "transport/glossy.h"

namespace bakelight::transport {
namespace {

// Columns: tangent, bitangent, normal.
Eigen::Matrix3d objectFromLocal(const Float3& normal, const formats::Float4& tangent) {
  Eigen::Matrix3d frame;
  frame.col(2) = vec3(normal);
  frame.col(0) = Vec3(tangent[0], tangent[1], tangent[2]);
  frame.col(1) = tangent[3] * frame.col(2).cross(frame.col(0));
  return frame;
}

// A table is isotropic, so any right-handed frame about the normal does.
Eigen::Matrix3d rightHanded(Eigen::Matrix3d frame) {
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return Eigen::Quaterniond(frame).normalized().toRotationMatrix();
}

// From a vertex towards the eye; along the normal for an eye at the vertex itself.
Vec3 towardsEye(const Float3& position, const Float3& normal, const Vec3& eye) {
  const Vec3 offset = eye - vec3(position);
  const double distance = offset.norm();
  return distance > 0 ? Vec3(offset / distance) : vec3(normal);
}

using Row = std::array<double, kMaxOrder * kMaxOrder>;

// The lobe's row for one vertex, in the object's frame or in the local one.
void lobeRowTowards(const Vec3& to_eye, const Eigen::Matrix3d& frame, std::span<const double> kernel,
                    bool object_frame, Row& row) {
  const Vec3 local_eye = frame.transpose() * to_eye;
  if (!object_frame) return lobeRow(kernel, local_eye, row);
  const int order = static_cast<int>(kernel.size());
  evaluateSh(order, frame * Vec3(-local_eye.x(), -local_eye.y(), std::abs(local_eye.z())), row);
  for (int l = 0; l < order; ++l)
    for (int i = l * l; i < (l + 1) * (l + 1); ++i) row[i] *= kernel[l];
}

void checkFrames(const formats::Pack& pack) {
  if (pack.transfer.tangents.size() != pack.mesh.vertexCount() ||
      pack.mesh.normals.size() != pack.mesh.vertexCount())
    throw std::invalid_argument("a glossy pack needs a normal and a tangent for each vertex");
}

void add(std::vector<Float3>& sum, std::span<const Float3> more) {
  for (std::size_t v = 0; v < sum.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c) sum[v][c] += more[v][c];
}

// Near emitters have no matrices of their own: their light comes as if from far away.
ShLight allLight(std::span<const Float3> light, std::span<const Float3> near_light, int order) {
  ShLight all(light.begin(), light.begin() + coefficientCount(order));
  if (!near_light.empty()) add(all, near_light.first(all.size()));
  return all;
}

}  // namespace

PackEvaluator::PackEvaluator(const formats::Pack& pack)
    : order_(pack.transfer.order),
      channels_(pack.transfer.channels),
      vectors_(pack.transfer.vectors.decode()),
      near_vectors_(pack.transfer.near_vectors.decode()),
      base_color_(pack.base_color),
      colors_(pack.colors),
      diffuse_(pack.mesh.vertexCount(), Float3{0, 0, 0}) {
  if (!colors_.empty() && colors_.size() != diffuse_.size())
    throw std::invalid_argument("a pack has no vertex colours, or one a vertex");
  const std::size_t values = diffuse_.size() * channels_ * coefficientCount(order_);
  for (const std::vector<float>& table : {std::cref(vectors_), std::cref(near_vectors_)})
    if (!table.empty() && table.size() != values)
      throw std::invalid_argument("transfer vectors of the pack do not fit its mesh");
  if (pack.transfer.storage != formats::MatrixStorage::kNone &&
      pack.transfer.material.model != formats::LobeModel::kNone)
    prepareGlossy(pack);
}

void PackEvaluator::prepareGlossy(const formats::Pack& pack) {
  checkFrames(pack);
  const formats::RadianceTransfer& transfer = pack.transfer;
  glossy_ = std::make_unique<GlossyEvaluator>(transfer);
  row_order_ = transfer.row_order;
  object_frame_ = transfer.storage == formats::MatrixStorage::kVisibility;
  material_ = transfer.material;
  positions_ = pack.mesh.positions;
  normals_ = pack.mesh.normals;
  tangents_ = transfer.tangents;
  transferred_.assign(diffuse_.size() * coefficientCount(row_order_), Float3{0, 0, 0});
  radiance_ = diffuse_;
  if (material_.model == formats::LobeModel::kPhong) kernel_ = phongKernel(row_order_, material_.exponent);
  if (material_.model == formats::LobeModel::kGgx) kernel_ = ggxKernel(row_order_, material_.roughness);
  if (material_.model != formats::LobeModel::kTable || !object_frame_) return;
  local_from_object_.reserve(diffuse_.size());
  for (std::size_t v = 0; v < diffuse_.size(); ++v)
    local_from_object_.emplace_back(row_order_,
                                    rightHanded(objectFromLocal(normals_[v], tangents_[v])).transpose());
}

void PackEvaluator::setLight(std::span<const Float3> light, std::span<const Float3> near_light) {
  const std::size_t count = coefficientCount(order_);
  if (light.size() < count || (!near_light.empty() && near_light.size() < count))
    throw std::invalid_argument("the light has fewer bands than the pack");
  setDiffuse(light, near_light);
  if (!glossy_) return;
  glossy_->transferredRadiance(allLight(light, near_light, order_), transferred_);
  const std::size_t row_count = coefficientCount(row_order_);
  tbb::parallel_for(std::size_t{0}, local_from_object_.size(), [&](std::size_t vertex) {
    const std::span<Float3> incident = std::span(transferred_).subspan(vertex * row_count, row_count);
    const std::vector<Float3> turned = local_from_object_[vertex].apply(incident);
    std::copy(turned.begin(), turned.end(), incident.begin());
  });
}

void PackEvaluator::setDiffuse(std::span<const Float3> light, std::span<const Float3> near_light) {
  std::fill(diffuse_.begin(), diffuse_.end(), Float3{0, 0, 0});
  if (vectors_.empty()) return;
  add(diffuse_, evaluateDiffuse(vectors_, order_, light, channels_));
  if (!near_light.empty())
    add(diffuse_,
        evaluateDiffuse(near_vectors_.empty() ? vectors_ : near_vectors_, order_, near_light, channels_));
  for (std::size_t v = 0; v < diffuse_.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c)
      diffuse_[v][c] *= base_color_[c] * (colors_.empty() ? 1.0f : colors_[v][c]);
}

std::span<const Float3> PackEvaluator::radianceTowards(const Vec3& eye) {
  if (!glossy_) return diffuse_;
  const bool table = material_.model == formats::LobeModel::kTable;
  tbb::parallel_for(std::size_t{0}, radiance_.size(), [&](std::size_t vertex) {
    const Float3 reflected = table ? tableReflection(vertex, eye) : lobeReflection(vertex, eye);
    for (std::size_t c = 0; c < 3; ++c) radiance_[vertex][c] = diffuse_[vertex][c] + reflected[c];
  });
  return radiance_;
}

Float3 PackEvaluator::lobeReflection(std::size_t vertex, const Vec3& eye) const {
  Row row;
  lobeRowTowards(towardsEye(positions_[vertex], normals_[vertex], eye),
                 objectFromLocal(normals_[vertex], tangents_[vertex]), kernel_, object_frame_, row);
  const std::size_t count = coefficientCount(row_order_);
  const Float3* incident = &transferred_[vertex * count];
  std::array<double, 3> sum{};
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < 3; ++c) sum[c] += row[i] * incident[i][c];
  Float3 reflected;
  for (std::size_t c = 0; c < 3; ++c) reflected[c] = material_.specular_color[c] * static_cast<float>(sum[c]);
  return reflected;
}

Float3 PackEvaluator::tableReflection(std::size_t vertex, const Vec3& eye) const {
  Eigen::Matrix3d frame = objectFromLocal(normals_[vertex], tangents_[vertex]);
  if (object_frame_) frame = rightHanded(frame);  // that of local_from_object_
  const std::size_t count = coefficientCount(row_order_);
  std::array<double, 3 * kMaxOrder * kMaxOrder> rows;
  tableRows(material_.table, frame.transpose() * towardsEye(positions_[vertex], normals_[vertex], eye),
            row_order_, std::span(rows).first(3 * count));
  const Float3* incident = &transferred_[vertex * count];
  Float3 reflected;
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += rows[c * count + i] * incident[i][c];
    reflected[c] = static_cast<float>(sum);
  }
  return reflected;
}

std::vector<float> lobeRows(const formats::Pack& pack, std::span<const double> kernel, const Vec3& eye,
                            bool object_frame, std::span<const std::uint32_t> vertex_order) {
  constexpr std::size_t kTile = GlossyEvaluator::kTile;
  checkFrames(pack);
  const std::size_t count = coefficientCount(static_cast<int>(kernel.size()));
  std::vector<float> rows(count * vertex_order.size());
  tbb::parallel_for(std::size_t{0}, vertex_order.size(), [&](std::size_t place) {
    const std::uint32_t vertex = vertex_order[place];
    float* const tile_rows = &rows[place / kTile * kTile * count + place % kTile];
    const Float3& normal = pack.mesh.normals[vertex];
    Row row;
    lobeRowTowards(towardsEye(pack.mesh.positions[vertex], normal, eye),
                   objectFromLocal(normal, pack.transfer.tangents[vertex]), kernel, object_frame, row);
    for (std::size_t i = 0; i < count; ++i) tile_rows[i * kTile] = static_cast<float>(row[i]);
  });
  return rows;
}

std::vector<Float3> evaluatePack(const formats::Pack& pack, std::span<const Float3> light,
                                 std::span<const Float3> near_light, const Vec3& eye) {
  PackEvaluator evaluator(pack);
  evaluator.setLight(light, near_light);
  const std::span<const Float3> radiance = evaluator.radianceTowards(eye);
  return {radiance.begin(), radiance.end()};
}

}  // namespace bakelight::transport
