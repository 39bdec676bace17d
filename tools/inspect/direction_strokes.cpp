#include "tools/inspect/direction_strokes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tools/inspect/render.h"
#include "transport/color.h"
#include "transport/vector_types.h"

namespace bakelight::inspect {

using formats::Float3;
using formats::Image;
using formats::MesoMesh;
using transport::Vec3;
using transport::vec3;

namespace {

constexpr int kStrokeCell_px = 11;  // a stroke in each square of so many pixels
constexpr double kStrokeHalf_px = 6, kStrokeHalfWidth_px = 0.7, kDotRadius_px = 5;
constexpr Float3 kInk = {0.05F, 0.05F, 0.08F}, kWith = {0.85F, 0.08F, 0.06F}, kAgainst = {0.08F, 0.2F, 0.9F};

// Pixels of world points, and the other way round.
class Projection {
 public:
  Projection(const transport::OrbitCamera& camera, const transport::BoundingSphere& bounds, int size_px)
      : clip_(camera.clipFromView(1, bounds) * camera.viewFromWorld()), size_(size_px) {}
  Eigen::Vector2d pixelOf(const Vec3& point) const {
    const Eigen::Vector4d clip = clip_ * point.homogeneous();
    return {(clip.x() / clip.w() + 1) / 2 * size_, (1 - clip.y() / clip.w()) / 2 * size_};
  }

 private:
  Eigen::Matrix4d clip_;
  int size_;
};

// Covers what is nearer than `radius` to the line between two pixels.
void drawStroke(Image& linear, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double radius,
                const Float3& ink, float exposure) {
  const Eigen::Vector2d way = to - from;
  const auto bound = [&](double low, double high, int side) {
    return std::array{std::clamp(static_cast<int>(low - radius - 1), 0, side),
                      std::clamp(static_cast<int>(high + radius + 2), 0, side)};
  };
  const auto columns = bound(std::min(from.x(), to.x()), std::max(from.x(), to.x()), linear.width),
             rows = bound(std::min(from.y(), to.y()), std::max(from.y(), to.y()), linear.height);
  for (int y = rows[0]; y < rows[1]; ++y)
    for (int x = columns[0]; x < columns[1]; ++x) {
      const Eigen::Vector2d p(x + 0.5, y + 0.5);
      const double length = way.squaredNorm();
      const double along = length > 0 ? std::clamp((p - from).dot(way) / length, 0.0, 1.0) : 0;
      const double cover = std::clamp(radius + 0.5 - (p - from - along * way).norm(), 0.0, 1.0);
      float* pixel = linear.texel(x, y);
      for (std::size_t c = 0; c < 3; ++c)
        pixel[c] = static_cast<float>((1 - cover) * pixel[c] + cover * ink[c] / exposure);
    }
}

}  // namespace

std::vector<TurningTriangle> turningTriangles(const MesoMesh& meso) {
  std::vector<TurningTriangle> turning;
  const double step = 2 * std::numbers::pi / meso.symmetry;
  for (std::uint32_t t = 0; t < meso.mesh.triangleCount(); ++t) {
    const formats::Triangle& corners = meso.mesh.triangles[t];
    const Vec3 a = vec3(meso.mesh.positions[corners[0]]), x = vec3(meso.mesh.positions[corners[1]]) - a;
    const Vec3 normal = x.cross(vec3(meso.mesh.positions[corners[2]]) - a);
    if (!(normal.norm() > 0)) continue;
    const Vec3 across = normal.cross(x).normalized(), along = x.normalized();
    std::array<double, 3> angles;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 tangent = vec3(meso.tangents[corners[k]]);
      angles[k] = std::atan2(tangent.dot(across), tangent.dot(along));
    }
    double turn = 0;
    for (std::size_t k = 0; k < 3; ++k) turn += std::remainder(angles[(k + 1) % 3] - angles[k], step);
    const int index = static_cast<int>(std::lround(turn / step));
    if (index != 0) turning.push_back({t, index});
  }
  return turning;
}

Preview drawDirections(const MesoMesh& meso, const PreviewOptions& options, const std::string& file) {
  const formats::TriangleMesh& mesh = meso.mesh;
  const transport::OrbitCamera camera = cameraFor(mesh, options, file);
  const double exposure = defaultExposure();
  const std::vector<Float3> clay = clayRadiance(mesh);
  transport::CpuPicture picture =
      takePicture(mesh, transport::interpolated(mesh.triangles, clay), camera, exposure, options);
  const Projection projection(camera, transport::boundingSphere(mesh), options.size_px);
  const int width = options.size_px * kSupersampling;
  const auto hitAt = [&](int x, int y) -> const transport::SubsampleHit& {
    const int at = kSupersampling / 2;
    return picture.hits[static_cast<std::size_t>(y * kSupersampling + at) * static_cast<std::size_t>(width) +
                        static_cast<std::size_t>(x * kSupersampling + at)];
  };
  for (int y = kStrokeCell_px / 2; y < options.size_px; y += kStrokeCell_px)
    for (int x = kStrokeCell_px / 2; x < options.size_px; x += kStrokeCell_px) {
      const transport::SubsampleHit& hit = hitAt(x, y);
      if (!hit.valid()) continue;
      const std::uint32_t v = mesh.triangles[hit.triangle][0];
      const Vec3 place =
          camera.eye() + static_cast<double>(hit.distance) *
                             camera.directionThrough(x + 0.5, y + 0.5, options.size_px, options.size_px);
      const Vec3 tangent = vec3(meso.tangents[v]), across = vec3(mesh.normals[v]).cross(tangent);
      // What a pixel is there; strokes are foreshortened as the surface is.
      const double unit =
          hit.distance * 2 * std::tan(camera.field_of_view_deg * std::numbers::pi / 360) / options.size_px;
      const Eigen::Vector2d middle = projection.pixelOf(place);
      const auto draw = [&](const Vec3& way, double from) {
        const Vec3 half = kStrokeHalf_px * unit * way;
        drawStroke(picture.linear, from == 0 ? middle : projection.pixelOf(place - half),
                   projection.pixelOf(place + half), kStrokeHalfWidth_px, kInk, static_cast<float>(exposure));
      };
      draw(tangent, meso.symmetry == 1 ? 0 : -1);
      if (meso.symmetry == 4) draw(across, -1);
      if (meso.symmetry == 1)
        drawStroke(picture.linear, middle, middle, 1.6, kInk, static_cast<float>(exposure));
    }
  const std::vector<TurningTriangle> turning = turningTriangles(meso);
  const transport::RayScene scene(mesh);
  for (const TurningTriangle& singular : turning) {
    Vec3 middle = Vec3::Zero();
    for (const std::uint32_t v : mesh.triangles[singular.triangle]) middle += vec3(mesh.positions[v]) / 3;
    const Vec3 way = middle - camera.eye();
    const transport::Hit hit = scene.nearestHit(camera.eye(), way.normalized());
    if (hit.valid && hit.distance < way.norm() * (1 - 1e-3)) continue;  // hidden
    const Eigen::Vector2d pixel = projection.pixelOf(middle);
    drawStroke(picture.linear, pixel, pixel, kDotRadius_px, singular.index > 0 ? kWith : kAgainst,
               static_cast<float>(exposure));
  }
  return {transport::encodeForDisplay(picture.linear, static_cast<float>(exposure)),
          "directions of symmetry " + std::to_string(meso.symmetry) + "; " + std::to_string(turning.size()) +
              " singularities, red where directions turn with the way around them, blue where against it"};
}

}  // namespace bakelight::inspect
