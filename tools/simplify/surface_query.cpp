#include "tools/simplify/surface_query.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tools/simplify/triangle_distance.h"

namespace bakelight::simplify {
namespace {

// Search radius beyond the best distance found, relative and (in units of the query's coordinates) absolute.
constexpr double kRelativeMargin = 1e-5;
constexpr double kMarginUnit = 1e-6;

}  // namespace

struct SurfaceQuery::Implementation {
  WorkingMesh mesh;
  std::vector<Vec3> normals;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  ~Implementation() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }

  struct Search {
    const Implementation* surface;
    Vec3 position, normal;
    bool facing_only;
    Material material;
    SurfacePoint best;
  };
  static bool visit(RTCPointQueryFunctionArguments* arguments);
  SurfacePoint run(const Vec3& position, const Vec3& normal, bool facing_only, Material material) const;
};

bool SurfaceQuery::Implementation::visit(RTCPointQueryFunctionArguments* arguments) {
  Search& search = *static_cast<Search*>(arguments->userPtr);
  const Implementation& surface = *search.surface;
  const std::uint32_t t = arguments->primID;
  if (search.facing_only && surface.normals[t].dot(search.normal) <= 0) return false;
  if (search.material && surface.mesh.materials[t] != *search.material) return false;
  const Vec3 &a = surface.mesh.corner(t, 0), &b = surface.mesh.corner(t, 1), &c = surface.mesh.corner(t, 2);
  const Vec3 weights = closestWeights(a, b, c, search.position);
  const Vec3 position = weights[0] * a + weights[1] * b + weights[2] * c;
  const double distance = (position - search.position).norm();
  SurfacePoint& best = search.best;
  if (best.valid && (distance > best.distance || (distance == best.distance && t > best.triangle)))
    return false;
  best = {true, distance, position, t, weights};
  // Boxes as near as that have corners no farther out than query and distance together.
  const double rounding = kMarginUnit * (search.position.cwiseAbs().maxCoeff() + distance);
  const float radius = static_cast<float>(distance * (1 + kRelativeMargin) + rounding);
  if (radius >= arguments->query->radius) return false;
  arguments->query->radius = radius;
  return true;
}

SurfacePoint SurfaceQuery::Implementation::run(const Vec3& position, const Vec3& normal, bool facing_only,
                                               Material material) const {
  Search search{this, position, normal, facing_only, material, {}};
  RTCPointQuery query{static_cast<float>(position.x()), static_cast<float>(position.y()),
                      static_cast<float>(position.z()), 0.0f, std::numeric_limits<float>::infinity()};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene, &query, &context, &visit, &search);
  return search.best;
}

SurfaceQuery::SurfaceQuery(WorkingMesh mesh) : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.mesh = std::move(mesh);
  self.normals.reserve(self.mesh.triangles.size());
  for (std::size_t t = 0; t < self.mesh.triangles.size(); ++t) {
    const Vec3 area = self.mesh.areaVector(t);
    self.normals.push_back(area.norm() > 0 ? Vec3(area / area.norm()) : Vec3(Vec3::Zero()));
  }
  self.device = rtcNewDevice(nullptr);
  if (self.device == nullptr) throw std::runtime_error("Embree: no device");
  self.scene = rtcNewScene(self.device);
  const RTCGeometry geometry = rtcNewGeometry(self.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), self.mesh.positions.size()));
  auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Triangle), self.mesh.triangles.size()));
  if (vertices == nullptr || indices == nullptr) throw std::bad_alloc();
  for (const Vec3& position : self.mesh.positions) {
    for (int k = 0; k < 3; ++k) *vertices++ = static_cast<float>(position[k]);
  }
  for (const Triangle& triangle : self.mesh.triangles)
    indices = std::copy(triangle.begin(), triangle.end(), indices);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(self.scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(self.scene);
  if (rtcGetDeviceError(self.device) != RTC_ERROR_NONE)
    throw std::runtime_error("Embree: cannot build the tree");
}

SurfaceQuery::~SurfaceQuery() = default;

SurfacePoint SurfaceQuery::closest(const Vec3& position, Material material) const {
  return implementation_->run(position, Vec3::Zero(), false, material);
}

SurfacePoint SurfaceQuery::closestFacing(const Vec3& position, const Vec3& normal, Material material) const {
  return implementation_->run(position, normal, true, material);
}

const WorkingMesh& SurfaceQuery::mesh() const {
  return implementation_->mesh;
}

const Vec3& SurfaceQuery::triangleNormal(std::uint32_t triangle) const {
  return implementation_->normals[triangle];
}

}  // namespace bakelight::simplify
