#include "transport/surface_query.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "transport/triangle_distance.h"

namespace bakelight::transport {
namespace {

// Search radius beyond the best distance found, relative and (in units of the query's coordinates) absolute.
constexpr double kRelativeMargin = 1e-5;
constexpr double kMarginUnit = 1e-6;

}  // namespace

struct SurfaceQuery::Implementation {
  SurfaceMesh mesh;
  std::vector<Vec3> normals;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  ~Implementation() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }

  ClosestPoint on(std::uint32_t triangle, const Vec3& position) const;
  // Boxes as near as that have corners no farther out than query and distance together.
  static float radius(const Vec3& position, double distance) {
    const double rounding = kMarginUnit * (position.cwiseAbs().maxCoeff() + distance);
    return static_cast<float>(distance * (1 + kRelativeMargin) + rounding);
  }

  enum class Among { kAll, kFacing, kPreferFacing };
  struct Search {
    const Implementation* surface;
    Vec3 position, normal;
    Among among;
    Material material = {};
    double factor = 1;
    ClosestPoint best = {}, facing = {};

    void meet(std::uint32_t triangle);
    // What is farther cannot matter any more.
    double reach() const;
    ClosestPoint result() const;
  };
  struct Probe {
    const Implementation* surface;
    Vec3 position;
    double distance;
    bool found = false;
  };
  static bool visit(RTCPointQueryFunctionArguments* arguments);
  static bool visitProbe(RTCPointQueryFunctionArguments* arguments);
  ClosestPoint run(Search search) const;
};

ClosestPoint SurfaceQuery::Implementation::on(std::uint32_t t, const Vec3& from) const {
  const Vec3 &a = mesh.corner(t, 0), &b = mesh.corner(t, 1), &c = mesh.corner(t, 2);
  const Vec3 weights = closestWeights(a, b, c, from);
  const Vec3 position = weights[0] * a + weights[1] * b + weights[2] * c;
  return {true, (position - from).norm(), position, t, weights};
}

void SurfaceQuery::Implementation::Search::meet(std::uint32_t triangle) {
  if (material && surface->mesh.materials[triangle] != *material) return;
  const bool faces = among != Among::kAll && surface->normals[triangle].dot(normal) > 0;
  if (among == Among::kFacing && !faces) return;
  const ClosestPoint met = surface->on(triangle, position);
  const auto keep = [&](ClosestPoint& of) {
    if (!of.valid || met.distance < of.distance ||
        (met.distance == of.distance && met.triangle < of.triangle))
      of = met;
  };
  keep(best);
  if (among == Among::kPreferFacing && faces) keep(facing);
}

double SurfaceQuery::Implementation::Search::reach() const {
  if (!best.valid) return std::numeric_limits<double>::infinity();
  if (among != Among::kPreferFacing) return best.distance;
  return facing.valid ? std::min(facing.distance, factor * best.distance) : factor * best.distance;
}

ClosestPoint SurfaceQuery::Implementation::Search::result() const {
  const bool prefer =
      among == Among::kPreferFacing && facing.valid && facing.distance <= factor * best.distance;
  return prefer ? facing : best;
}

bool SurfaceQuery::Implementation::visit(RTCPointQueryFunctionArguments* arguments) {
  Search& search = *static_cast<Search*>(arguments->userPtr);
  search.meet(arguments->primID);
  const float radius = Implementation::radius(search.position, search.reach());
  if (radius >= arguments->query->radius) return false;
  arguments->query->radius = radius;
  return true;
}

bool SurfaceQuery::Implementation::visitProbe(RTCPointQueryFunctionArguments* arguments) {
  Probe& probe = *static_cast<Probe*>(arguments->userPtr);
  if (probe.found || probe.surface->on(arguments->primID, probe.position).distance > probe.distance)
    return false;
  probe.found = true;
  arguments->query->radius = 0;
  return true;
}

namespace {

RTCPointQuery pointQuery(const Vec3& position, float radius) {
  return {static_cast<float>(position.x()), static_cast<float>(position.y()),
          static_cast<float>(position.z()), 0.0f, radius};
}

}  // namespace

ClosestPoint SurfaceQuery::Implementation::run(Search search) const {
  RTCPointQuery query = pointQuery(search.position, radius(search.position, search.reach()));
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene, &query, &context, &visit, &search);
  return search.result();
}

SurfaceQuery::SurfaceQuery(SurfaceMesh mesh) : implementation_(std::make_unique<Implementation>()) {
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
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(formats::Triangle),
                              self.mesh.triangles.size()));
  if (vertices == nullptr || indices == nullptr) throw std::bad_alloc();
  for (const Vec3& position : self.mesh.positions) {
    for (int k = 0; k < 3; ++k) *vertices++ = static_cast<float>(position[k]);
  }
  for (const formats::Triangle& triangle : self.mesh.triangles)
    indices = std::copy(triangle.begin(), triangle.end(), indices);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(self.scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(self.scene);
  if (rtcGetDeviceError(self.device) != RTC_ERROR_NONE)
    throw std::runtime_error("Embree: cannot build the tree");
}

SurfaceQuery::~SurfaceQuery() = default;

ClosestPoint SurfaceQuery::closest(const Vec3& position, Material material,
                                   std::optional<std::uint32_t> near_triangle) const {
  Implementation::Search search{implementation_.get(), position, Vec3::Zero(), Implementation::Among::kAll,
                                material};
  if (near_triangle) search.meet(*near_triangle);
  return implementation_->run(search);
}

ClosestPoint SurfaceQuery::closestFrom(std::uint32_t near_triangle, const Vec3& position) const {
  Implementation::Search search{implementation_.get(), position, Vec3::Zero(), Implementation::Among::kAll};
  search.meet(near_triangle);
  return implementation_->run(search);
}

ClosestPoint SurfaceQuery::closestFacing(const Vec3& position, const Vec3& normal, Material material,
                                         std::optional<std::uint32_t> near_triangle) const {
  Implementation::Search search{implementation_.get(), position, normal, Implementation::Among::kFacing,
                                material};
  if (near_triangle) search.meet(*near_triangle);
  return implementation_->run(search);
}

ClosestPoint SurfaceQuery::closestPreferFacing(const Vec3& position, const Vec3& normal, double factor,
                                               std::uint32_t near_triangle) const {
  Implementation::Search search{implementation_.get(), position, normal,
                                Implementation::Among::kPreferFacing};
  search.factor = factor;
  search.meet(near_triangle);
  return implementation_->run(search);
}

bool SurfaceQuery::within(const Vec3& position, double distance) const {
  Implementation::Probe probe{implementation_.get(), position, distance};
  RTCPointQuery query = pointQuery(position, Implementation::radius(position, distance));
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(implementation_->scene, &query, &context, &Implementation::visitProbe, &probe);
  return probe.found;
}

const SurfaceMesh& SurfaceQuery::mesh() const {
  return implementation_->mesh;
}

const Vec3& SurfaceQuery::triangleNormal(std::uint32_t triangle) const {
  return implementation_->normals[triangle];
}

}  // namespace bakelight::transport
