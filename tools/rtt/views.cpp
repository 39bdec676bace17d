#include "tools/rtt/views.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "tools/rtt/view_rays.h"
#include "transport/hemisphere_grid.h"
#include "transport/multiversioned.h"

namespace bakelight::rtt {
namespace {

using transport::Vec3;

// Of three colors, each `count` values; `stride` from one to the next in the row.
BAKELIGHT_MULTIVERSIONED void addTinted(const float* row, std::size_t stride, std::size_t count,
                                        const float* tint, float* sums) {
  for (std::size_t channel = 0; channel < 3; ++channel)
    for (std::size_t i = 0; i < count; ++i)
      sums[channel * count + i] += tint[channel] * row[channel * stride + i];
}

// A row of texels towards one view.
class RowOfTexels {
 public:
  RowOfTexels(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
              const SurfaceLight& light, int supersampling)
      : geometry_(geometry), scene_(scene), light_(light), supersampling_(supersampling) {}

  ViewFigures render(const Vec3& view, int column, int row, int y,
                     formats::RadianceTransferTexture& texture) {
    rays_.clear();
    rowOfViewRays(geometry_, scene_, view, {texture.width, texture.height, supersampling_}, y, rays_);
    hits_ = transport::HitBundle(rays_.size());
    scene_.nearestHits(rays_, hits_);
    ViewFigures figures{rays_.size()};
    const std::size_t samples = static_cast<std::size_t>(supersampling_) * supersampling_;
    for (int x = 0; x < texture.width; ++x) {
      const std::span<float> response = texture.response(column, row, x, y);
      for (std::size_t s = 0; s < samples; ++s) {
        const std::size_t ray = static_cast<std::size_t>(x) * samples + s;
        if (hits_.blocked[ray] == 0)
          ++figures.through;
        else if (!add(ray, response))
          ++figures.inside;
      }
      for (float& value : response) value /= static_cast<float>(samples);
    }
    return figures;
  }

 private:
  // False for the inside of a closed part.
  bool add(std::size_t ray, std::span<float> response) const {
    const std::uint32_t triangle = hits_.triangle[ray];
    const float u = hits_.u[ray], v = hits_.v[ray];
    const formats::Float3 albedo = geometry_.albedoAt(triangle, u, v);
    const std::array<float, 3> weights = {1 - u - v, u, v};
    const auto side = static_cast<std::uint32_t>(hits_.back_face[ray] != 0 ? light_.sides.vertices : 0);
    const std::size_t count = light_.coefficients;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const float* row = light_.row(geometry_.mesh.triangles[triangle][corner] + side);
      if (row == nullptr) return false;
      const std::array<float, 3> tint = {weights[corner] * albedo[0], weights[corner] * albedo[1],
                                         weights[corner] * albedo[2]};
      addTinted(row, light_.channels == 3 ? count : 0, count, tint.data(), response.data());
    }
    return true;
  }

  const patch::PatchGeometry& geometry_;
  const transport::PeriodicRayScene& scene_;
  const SurfaceLight& light_;
  int supersampling_;
  transport::FreeRays rays_;
  transport::HitBundle hits_;
};

}  // namespace

ViewFigures renderViews(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                        const SurfaceLight& light, int supersampling, bool masking,
                        const std::function<void()>& progress, formats::RadianceTransferTexture& texture) {
  texture.allocate();
  const auto rows = static_cast<std::size_t>(texture.height);
  std::vector<ViewFigures> parts(texture.viewCount() * rows);
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
    const int view = static_cast<int>(part / rows), y = static_cast<int>(part % rows);
    const int column = view % texture.views, row = view / texture.views;
    const Vec3 towards = masking ? transport::hemisphereCell(texture.views, column, row) : Vec3(0, 0, 1);
    parts[part] = RowOfTexels(geometry, scene, light, supersampling).render(towards, column, row, y, texture);
    if (y == 0) progress();
  });
  ViewFigures figures;
  for (const ViewFigures& part : parts)
    figures.rays += part.rays, figures.through += part.through, figures.inside += part.inside;
  return figures;
}

}  // namespace bakelight::rtt
