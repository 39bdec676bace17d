#include "tools/inspect/render.h"

#include <cmath>
#include <numbers>

#include "formats/error.h"
#include "tools/inspect/image_figures.h"
#include "tools/inspect/mesh_figures.h"
#include "transport/evaluator.h"

namespace bakelight::inspect {

using formats::Float3;
using formats::Image;
using formats::TriangleMesh;
using transport::Vec3;
using transport::vec3;

namespace {

constexpr float kBackdropRadiance = 0.03f;
constexpr int kClayOrder = 3;  // clamped-cosine shading lives in three bands

// Area-weighted over all triangles that meet at a position.
std::vector<Float3> smoothNormals(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> first = firstVertexAtPosition(mesh);
  std::vector<Vec3> sums(mesh.vertexCount(), Vec3::Zero());
  for (const formats::Triangle& t : mesh.triangles) {
    const Vec3 a = vec3(mesh.positions[t[0]]);
    const Vec3 normal = (vec3(mesh.positions[t[1]]) - a).cross(vec3(mesh.positions[t[2]]) - a);
    for (const std::uint32_t vertex : t) sums[first[vertex]] += normal;
  }
  std::vector<Float3> normals(mesh.vertexCount());
  for (std::size_t i = 0; i < normals.size(); ++i)
    normals[i] =
        transport::float3(sums[first[i]].norm() > 0 ? sums[first[i]].normalized() : Vec3(Vec3::UnitY()));
  return normals;
}

}  // namespace

transport::OrbitCamera cameraFor(const TriangleMesh& mesh, const PreviewOptions& options,
                                 const std::string& file) {
  const transport::BoundingSphere bounds = transport::boundingSphere(mesh);
  if (!(bounds.radius > 0) || mesh.triangles.empty())
    throw badInput({file, "", ""}, "the mesh has no extent, there is nothing to see",
                   "at least one triangle");
  return transport::frameSphere(bounds, options.yaw_deg, options.pitch_deg, 35, 1);
}

double exposureFor(const transport::ShLight& light) {
  const double mean = luminance(light[0][0], light[0][1], light[0][2]) / std::sqrt(4 * std::numbers::pi);
  return kMiddleValue / mean;
}

double defaultExposure() {
  return exposureFor(transport::defaultLight(kClayOrder));
}

std::vector<Float3> clayRadiance(const TriangleMesh& mesh) {
  const std::vector<Float3> normals = mesh.normals.empty() ? smoothNormals(mesh) : mesh.normals;
  const std::vector<double> factors = transport::clampedCosineFactors(kClayOrder);
  std::vector<float> vectors;
  for (const Float3& normal : normals) {
    const std::vector<double> basis = transport::evaluateSh(kClayOrder, vec3(normal));
    for (int l = 0; l < kClayOrder; ++l)
      for (int m = -l; m <= l; ++m)
        vectors.push_back(static_cast<float>(kClayAlbedo * factors[l] / std::numbers::pi *
                                             basis[transport::coefficientIndex(l, m)]));
  }
  return transport::evaluateDiffuse(vectors, kClayOrder, transport::defaultLight(kClayOrder));
}

transport::CpuPicture takePicture(const TriangleMesh& mesh, const transport::RadianceAtHits& shade,
                                  const transport::OrbitCamera& camera, double exposure,
                                  const PreviewOptions& options) {
  const transport::RayScene scene(mesh);
  const auto backdrop = [exposure](const Vec3&) {
    const auto gray = static_cast<float>(kBackdropRadiance / exposure);
    return formats::Float4{gray, gray, gray, 1};
  };
  return transport::renderOnCpu(scene, shade, camera, {options.size_px, options.size_px, kSupersampling},
                                backdrop);
}

Image render(const TriangleMesh& mesh, const transport::RadianceAtHits& shade,
             const transport::OrbitCamera& camera, double exposure, const PreviewOptions& options) {
  return transport::encodeForDisplay(takePicture(mesh, shade, camera, exposure, options).linear,
                                     static_cast<float>(exposure));
}

}  // namespace bakelight::inspect
