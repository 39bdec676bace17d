#include "transport/vertex_shading.h"

#include <tbb/parallel_for.h>

#include <algorithm>
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
  if (pack.sh().glossy->tangents.size() != pack.mesh.vertexCount() ||
      pack.mesh.normals.size() != pack.mesh.vertexCount())
    throw std::invalid_argument("a glossy pack needs a normal and a tangent for each vertex");
}

bool isLambert(const formats::Appearance& appearance) {
  return appearance.reflection.as<formats::LambertReflection>() != nullptr;
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

VertexShading::VertexShading(const formats::Pack& pack)
    : order_(pack.sh().order),
      channels_(pack.sh().channels),
      triangles_(pack.mesh.triangles),
      vectors_(pack.sh().vectors.decode()),
      albedo_(pack.colors),
      diffuse_(pack.mesh.vertexCount(), Float3{0, 0, 0}) {
  const formats::ShTransfer& transfer = pack.sh();
  if (transfer.near_field) {
    near_vectors_ = transfer.near_field->vectors.decode();
    near_center_ = vec3(transfer.near_field->center);
  }
  if (!albedo_.empty() && albedo_.size() != diffuse_.size())
    throw std::invalid_argument("a pack has no vertex colours, or one a vertex");
  albedo_.resize(diffuse_.size(), Float3{1, 1, 1});
  const std::vector<formats::VertexRange> ranges = formats::appearanceRanges(pack);
  for (std::size_t i = 0; i < ranges.size(); ++i)
    for (std::size_t v = ranges[i].first; v < ranges[i].end; ++v)
      for (std::size_t c = 0; c < 3; ++c) albedo_[v][c] *= pack.appearances[i].base_color[c];
  const std::size_t values = diffuse_.size() * channels_ * coefficientCount(order_);
  for (const std::vector<float>& table : {std::cref(vectors_), std::cref(near_vectors_)})
    if (!table.empty() && table.size() != values)
      throw std::invalid_argument("transfer vectors of the pack do not fit its mesh");
  if (transfer.glossy && !std::all_of(pack.appearances.begin(), pack.appearances.end(), isLambert))
    prepareGlossy(pack);
}

void VertexShading::prepareGlossy(const formats::Pack& pack) {
  checkFrames(pack);
  const formats::GlossyTransfer& transfer = *pack.sh().glossy;
  glossy_ = std::make_unique<GlossyEvaluator>(pack.sh());
  output_order_ = transfer.output_order;
  object_frame_ = transfer.isInObjectFrame();
  positions_ = pack.mesh.positions;
  normals_ = pack.mesh.normals;
  tangents_ = transfer.tangents;
  transferred_.assign(diffuse_.size() * coefficientCount(output_order_), Float3{0, 0, 0});
  radiance_ = diffuse_;
  const std::vector<formats::VertexRange> ranges = formats::appearanceRanges(pack);
  for (std::size_t i = 0; i < ranges.size(); ++i)
    if (!isLambert(pack.appearances[i]))
      reflections_.push_back(reflectionOf(pack.appearances[i].reflection, ranges[i]));
}

VertexShading::Reflection VertexShading::reflectionOf(const formats::PackPart& part,
                                                      const formats::VertexRange& vertices) const {
  Reflection result;
  result.vertices = vertices;
  if (const auto* phong = part.as<formats::PhongLobe>()) {
    result.kernel = phongKernel(output_order_, phong->exponent);
    result.specular_color = phong->specular_color;
    return result;
  }
  if (const auto* ggx = part.as<formats::GgxLobe>()) {
    result.kernel = ggxKernel(output_order_, ggx->roughness);
    result.specular_color = ggx->specular_color;
    return result;
  }
  const auto* table = part.as<formats::BrdfTable>();
  if (table == nullptr)
    throw std::invalid_argument(std::string("reflection ") + part.kind() + " is none at vertices");
  result.table = *table;
  if (!object_frame_) return result;
  result.local_from_object.reserve(vertices.count());
  for (std::size_t v = vertices.first; v < vertices.end; ++v)
    result.local_from_object.emplace_back(
        output_order_, rightHanded(objectFromLocal(normals_[v], tangents_[v])).transpose());
  return result;
}

bool VertexShading::shades(const formats::Pack& pack) {
  return pack.transfer.as<formats::ShTransfer>() != nullptr &&
         std::all_of(
             pack.appearances.begin(), pack.appearances.end(), [](const formats::Appearance& appearance) {
               const formats::PackPart& part = appearance.reflection;
               return isLambert(appearance) || part.as<formats::PhongLobe>() != nullptr ||
                      part.as<formats::GgxLobe>() != nullptr || part.as<formats::BrdfTable>() != nullptr;
             });
}

LightNeeds VertexShading::needs() const {
  return {order_, near_center_};
}

void VertexShading::setLight(std::span<const Float3> light, std::span<const Float3> near_light) {
  const std::size_t count = coefficientCount(order_);
  if (light.size() < count || (!near_light.empty() && near_light.size() < count))
    throw std::invalid_argument("the light has fewer bands than the pack");
  setDiffuse(light, near_light);
  if (!glossy_) return;
  glossy_->transferredRadiance(allLight(light, near_light, order_), transferred_);
  const std::size_t rows = coefficientCount(output_order_);
  for (const Reflection& reflection : reflections_)
    tbb::parallel_for(std::size_t{0}, reflection.local_from_object.size(), [&](std::size_t i) {
      const std::span<Float3> incident =
          std::span(transferred_).subspan((reflection.vertices.first + i) * rows, rows);
      const std::vector<Float3> turned = reflection.local_from_object[i].apply(incident);
      std::copy(turned.begin(), turned.end(), incident.begin());
    });
}

void VertexShading::setDiffuse(std::span<const Float3> light, std::span<const Float3> near_light) {
  std::fill(diffuse_.begin(), diffuse_.end(), Float3{0, 0, 0});
  if (vectors_.empty()) return;
  add(diffuse_, evaluateDiffuse(vectors_, order_, light, channels_));
  if (!near_light.empty())
    add(diffuse_,
        evaluateDiffuse(near_vectors_.empty() ? vectors_ : near_vectors_, order_, near_light, channels_));
  for (std::size_t v = 0; v < diffuse_.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c) diffuse_[v][c] *= albedo_[v][c];
}

void VertexShading::setView(const ViewPoint& view) {
  if (!glossy_) return;
  radiance_ = diffuse_;
  for (const Reflection& reflection : reflections_)
    tbb::parallel_for(reflection.vertices.first, reflection.vertices.end, [&](std::size_t vertex) {
      const Float3 reflected = reflection.kernel.empty() ? tableReflection(reflection, vertex, view.eye)
                                                         : lobeReflection(reflection, vertex, view.eye);
      for (std::size_t c = 0; c < 3; ++c) radiance_[vertex][c] += reflected[c];
    });
}

void VertexShading::radianceAt(std::span<const SurfaceHit> hits, std::span<Float3> radiance) const {
  interpolated(triangles_, vertexRadiance())(hits, radiance);
}

Float3 VertexShading::lobeReflection(const Reflection& reflection, std::size_t vertex,
                                     const Vec3& eye) const {
  Row row;
  lobeRowTowards(towardsEye(positions_[vertex], normals_[vertex], eye),
                 objectFromLocal(normals_[vertex], tangents_[vertex]), reflection.kernel, object_frame_, row);
  const std::size_t count = coefficientCount(output_order_);
  const Float3* incident = &transferred_[vertex * count];
  std::array<double, 3> sum{};
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < 3; ++c) sum[c] += row[i] * incident[i][c];
  Float3 reflected;
  for (std::size_t c = 0; c < 3; ++c)
    reflected[c] = reflection.specular_color[c] * static_cast<float>(sum[c]);
  return reflected;
}

Float3 VertexShading::tableReflection(const Reflection& reflection, std::size_t vertex,
                                      const Vec3& eye) const {
  Eigen::Matrix3d frame = objectFromLocal(normals_[vertex], tangents_[vertex]);
  if (object_frame_) frame = rightHanded(frame);  // that of local_from_object_
  const std::size_t count = coefficientCount(output_order_);
  std::array<double, 3 * kMaxOrder * kMaxOrder> rows;
  tableRows(reflection.table, frame.transpose() * towardsEye(positions_[vertex], normals_[vertex], eye),
            output_order_, std::span(rows).first(3 * count));
  const Float3* incident = &transferred_[vertex * count];
  Float3 reflected;
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += rows[c * count + i] * incident[i][c];
    reflected[c] = static_cast<float>(sum);
  }
  return reflected;
}

}  // namespace bakelight::transport
