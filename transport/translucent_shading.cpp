#include "transport/translucent_shading.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "transport/diffusion.h"
#include "transport/evaluator.h"
#include "transport/sh.h"
#include "transport/translucent_tables.h"

namespace bakelight::transport {

using formats::Float4;

namespace {

const formats::Translucency& translucencyOf(const formats::Pack& pack) {
  return *pack.appearances.at(0).reflection.as<formats::Translucency>();
}

std::vector<std::uint32_t> placesOf(const formats::Translucency& translucency) {
  const auto texels = formats::wordsOf(translucency.texels);
  std::vector<std::uint32_t> places;
  for (const std::uint32_t texel : formats::wordsOf(translucency.receivers)) places.push_back(texels[texel]);
  return places;
}

constexpr const char* kWhatVerticesNeed =
    "a translucent pack needs normal, texture coordinates, knot and transfer of each vertex";

// Before anything looks at its vertices.
const formats::TriangleMesh& checkedMesh(const formats::Pack& pack) {
  const std::size_t count = pack.mesh.vertexCount();
  if (pack.mesh.normals.size() != count || pack.mesh.texcoords.size() != count ||
      translucencyOf(pack).knots.size() != count || (!pack.colors.empty() && pack.colors.size() != count))
    throw std::invalid_argument(kWhatVerticesNeed);
  return pack.mesh;
}

formats::EncodedTable blackTable(std::size_t rows, std::size_t columns) {
  return {
      formats::Precision::kFloat32, rows, columns, formats::Bytes(rows * columns * sizeof(float)), {}, {}};
}

formats::SparseRows emptyRows(std::size_t rows, std::size_t value_columns) {
  return {formats::integersOf(std::vector<std::uint32_t>(rows, 0)), {4, {}}, blackTable(0, value_columns)};
}

}  // namespace

formats::Pack withBranches(formats::Pack pack, TranslucentResponse::Branches branches) {
  if (branches == TranslucentResponse::Branches::kBoth) return pack;
  if (!TranslucentShading::shades(pack))
    throw std::invalid_argument("a pack that is not translucent has no branches");
  auto& t = *pack.appearances.front().reflection.as<formats::Translucency>();
  if (branches == TranslucentResponse::Branches::kGlobal) {
    t.components = 1;
    t.basis.assign(std::size_t{3} * formats::kKernelTexels, 0.0F);
    t.kernels = blackTable(t.receiverCount(), 1);
    return pack;
  }
  const auto knots = static_cast<std::size_t>(t.knot_count);
  t.areas = blackTable(t.texelCount(), 1);
  t.blend = blackTable(t.texelCount(), 9);
  t.sharpen = emptyRows(knots, 1);
  t.near = emptyRows(knots, 3);
  t.far_count = 0, t.spread = {}, t.far = {};
  return pack;
}

bool TranslucentShading::shades(const formats::Pack& pack) {
  return pack.transfer.as<formats::ShTransfer>() != nullptr && pack.appearances.size() == 1 &&
         pack.appearances.front().reflection.as<formats::Translucency>() != nullptr;
}

TranslucentShading::TranslucentShading(const formats::Pack& pack)
    : order_(pack.sh().order),
      channels_(pack.sh().channels),
      resolution_(translucencyOf(pack).resolution),
      eta_(static_cast<double>(translucencyOf(pack).eta)),
      vectors_(pack.sh().vectors.decode()),
      mesh_(checkedMesh(pack)),
      stain_(stainOf(pack)),
      knots_(translucencyOf(pack).knots),
      knot_count_(static_cast<std::size_t>(translucencyOf(pack).knot_count)),
      places_(placesOf(translucencyOf(pack))),
      response_(translucencyOf(pack)),
      irradiance_(translucencyOf(pack), mesh_),
      radiosity_(static_cast<std::size_t>(resolution_) * resolution_, Float4{0, 0, 0, 0}) {
  if (pack.sh().near_field) {
    near_vectors_ = pack.sh().near_field->vectors.decode();
    near_center_ = vec3(pack.sh().near_field->center);
  }
  const std::size_t values = mesh_.vertexCount() * channels_ * coefficientCount(order_);
  if (vectors_.size() != values || (!near_vectors_.empty() && near_vectors_.size() != values))
    throw std::invalid_argument(kWhatVerticesNeed);
}

void TranslucentShading::setLight(std::span<const Float3> distant, std::span<const Float3> near) {
  std::vector<Float3> at_vertices = evaluateDiffuse(vectors_, order_, distant, channels_);
  if (!near.empty()) {
    const std::vector<Float3> more =
        evaluateDiffuse(near_vectors_.empty() ? vectors_ : near_vectors_, order_, near, channels_);
    for (std::size_t v = 0; v < more.size(); ++v)
      for (std::size_t c = 0; c < 3; ++c) at_vertices[v][c] += more[v][c];
  }
  // Vectors give exit radiance of a white surface; what falls on it is π times that.
  std::vector<Float3> at_knots(knot_count_, Float3{0, 0, 0});
  for (std::size_t v = knots_.size(); v-- > 0;) at_knots[knots_[v]] = at_vertices[v];
  std::vector<Float3> entering = response_.interpolated(at_knots);
  for (Float3& texel : entering)
    for (float& value : texel) value = std::max(std::numbers::pi_v<float> * value, 0.0F);
  for (std::size_t t = 0; t < punctual_.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) entering[t][c] += punctual_[t][c];
  const std::vector<Float3> leaving = response_.respond(entering);
  for (std::size_t r = 0; r < places_.size(); ++r)
    radiosity_[places_[r]] = {leaving[r][0], leaving[r][1], leaving[r][2], 1};
}

void TranslucentShading::setPunctualLights(std::span<const PlacedPunctualLight> lights,
                                           const Occlusion& occluded) {
  punctual_ = lights.empty() ? std::vector<Float3>() : irradiance_.entering(lights, occluded);
}

void TranslucentShading::radianceAt(std::span<const SurfaceHit> hits, std::span<Float3> radiance) const {
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const formats::Triangle& t = mesh_.triangles[hits[i].triangle];
    const std::array<float, 3> w = {1 - hits[i].u - hits[i].v, hits[i].u, hits[i].v};
    Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
    float u = 0, v = 0;
    Float3 stain{};
    for (std::size_t k = 0; k < 3; ++k) {
      position += static_cast<double>(w[k]) * vec3(mesh_.positions[t[k]]);
      normal += static_cast<double>(w[k]) * vec3(mesh_.normals[t[k]]);
      u += w[k] * mesh_.texcoords[t[k]][0], v += w[k] * mesh_.texcoords[t[k]][1];
      for (std::size_t c = 0; c < 3; ++c) stain[c] += w[k] * stain_[t[k]][c];
    }
    const float x = u * static_cast<float>(resolution_) - 0.5F,
                y = (1 - v) * static_cast<float>(resolution_) - 0.5F;
    const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
    Float4 sum{};
    for (int dy = 0; dy < 2; ++dy)
      for (int dx = 0; dx < 2; ++dx) {
        const int column = std::clamp(left + dx, 0, resolution_ - 1),
                  row = std::clamp(top + dy, 0, resolution_ - 1);
        const float share_x = x - static_cast<float>(left), share_y = y - static_cast<float>(top);
        const float weight = (dx == 1 ? share_x : 1 - share_x) * (dy == 1 ? share_y : 1 - share_y);
        const Float4& texel = radiosity_[static_cast<std::size_t>(row) * resolution_ + column];
        for (std::size_t c = 0; c < 4; ++c) sum[c] += weight * texel[c];
      }
    const double cosine = std::abs(normal.normalized().dot((eye_ - position).normalized()));
    const auto leaving = static_cast<float>(schlickTransmittance(cosine, eta_) / std::numbers::pi);
    for (std::size_t c = 0; c < 3; ++c)
      radiance[i][c] = sum[3] > 0 ? stain[c] * leaving * sum[c] / sum[3] : 0;
  }
}

}  // namespace bakelight::transport
