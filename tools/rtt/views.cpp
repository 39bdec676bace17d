#include "tools/rtt/views.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <span>
#include <vector>

#include "tools/rtt/glossy_samples.h"
#include "tools/rtt/view_rays.h"
#include "transport/hemisphere_grid.h"
#include "transport/multiversioned.h"
#include "transport/random.h"

namespace bakelight::rtt {
namespace {

using formats::Float3;
using transport::Vec3;
using transport::vec3;

// Of three colors, each `count` values; `stride` from one to the next in the row, `sum_stride` in the sums.
BAKELIGHT_MULTIVERSIONED void addTinted(const float* row, std::size_t stride, std::size_t count,
                                        const float* tint, float* sums, std::size_t sum_stride) {
  for (std::size_t channel = 0; channel < 3; ++channel)
    for (std::size_t i = 0; i < count; ++i)
      sums[channel * sum_stride + i] += tint[channel] * row[channel * stride + i];
}

// What all rows of all views share.
struct Setting {
  const patch::PatchGeometry& geometry;
  const transport::PeriodicRayScene& scene;
  const SurfaceLight& light;
  const ViewOptions& options;
  const LightBasis& basis;
  GlossyReflection reflection;
  int glossy_samples = 0;  // of each look
  double offset = 0;       // of rays that leave the surface
  bool plain = false;      // of one albedo
};

Setting settingOf(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                  const SurfaceLight& light, const ViewOptions& options, const LightBasis& basis) {
  Setting setting{geometry, scene, light, options, basis, GlossyReflection(geometry.reflection)};
  setting.glossy_samples = setting.reflection.sampleCount(options.glossy_samples);
  setting.offset = transport::surfaceOffset(geometry.mesh, transport::kDefaultBias);
  setting.plain = geometry.mesh.colors.empty() && geometry.texture.values.empty();
  return setting;
}

// Responses, by what rays meet.
class Looks {
 public:
  Looks(const Setting& setting, std::size_t coefficients) : setting_(setting), coefficients_(coefficients) {}

  transport::FreeRays rays;

  void trace() {
    if (hits_.blocked.size() < rays.size()) hits_ = transport::HitBundle(rays.size());
    setting_.scene.nearestHits(rays, hits_);
  }
  bool met(std::size_t ray) const { return hits_.blocked[ray] != 0; }
  float heightMet(std::size_t ray) const { return rays.z[ray] + hits_.distance[ray] * rays.direction_z[ray]; }

  // Adds the diffuse part of what is met, times `tint`. False for the inside of a closed part.
  bool addDiffuse(std::size_t ray, const Float3& tint, std::span<float> response) const {
    const std::uint32_t triangle = hits_.triangle[ray];
    const float u = hits_.u[ray], v = hits_.v[ray];
    const Float3 albedo =
        setting_.plain ? setting_.geometry.albedo : setting_.geometry.albedoAt(triangle, u, v);
    const std::array<float, 3> weights = {1 - u - v, u, v};
    const SurfaceLight& light = setting_.light;
    const auto side = static_cast<std::uint32_t>(hits_.back_face[ray] != 0 ? light.sides.vertices : 0);
    const std::size_t stride = light.channels == 3 ? coefficients_ : 0;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const float* row = light.row(setting_.geometry.mesh.triangles[triangle][corner] + side);
      if (row == nullptr) return false;
      const Float3 weight = {weights[corner] * albedo[0] * tint[0], weights[corner] * albedo[1] * tint[1],
                             weights[corner] * albedo[2] * tint[2]};
      addTinted(row, stride, coefficients_, weight.data(), response.data(), coefficients_);
    }
    return true;
  }

  struct Place {
    Vec3 position, normal, facet;  // to the side that was met
  };
  Place placeOf(std::size_t ray) const {
    const formats::TriangleMesh& mesh = setting_.geometry.mesh;
    const formats::Triangle& corners = mesh.triangles[hits_.triangle[ray]];
    const std::array<double, 3> weights = {1.0 - hits_.u[ray] - hits_.v[ray], hits_.u[ray], hits_.v[ray]};
    std::array<Vec3, 3> p;
    Place place{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = vec3(mesh.positions[corners[i]]);
      place.position += weights[i] * p[i];
      place.normal += weights[i] * vec3(mesh.normals[corners[i]]);
    }
    const double side = hits_.back_face[ray] != 0 ? -1 : 1;
    place.facet = side * (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    place.normal = place.normal.norm() > 0 ? Vec3(side * place.normal.normalized()) : place.facet;
    return place;
  }

 private:
  const Setting& setting_;
  std::size_t coefficients_;
  transport::HitBundle hits_;
};

// A row of texels towards one view.
class RowOfTexels {
 public:
  RowOfTexels(const Setting& setting, const Responses& responses)
      : setting_(setting),
        responses_(responses),
        views_(setting, responses.coefficients),
        mirrored_(setting, responses.coefficients),
        next_(setting, responses.coefficients) {}

  ViewFigures render(int index, int y) {
    const Vec3 view =
        transport::hemisphereCell(responses_.views, index % responses_.views, index / responses_.views);
    const int supersampling = setting_.options.supersampling;
    views_.rays.clear();
    const Vec3 looked_along = setting_.options.masking ? view : Vec3(0, 0, 1);
    rowOfViewRays(setting_.geometry, setting_.scene, looked_along,
                  {responses_.width, responses_.height, supersampling}, y, views_.rays);
    views_.trace();
    ViewFigures figures{.rays = views_.rays.size()};
    const std::size_t samples = static_cast<std::size_t>(supersampling) * supersampling;
    for (int x = 0; x < responses_.width; ++x) {
      const std::size_t texel = responses_.number(index, x, y);
      const std::span<float> response =
          responses_.values.subspan(texel * responses_.size(), responses_.size());
      startPaths();
      auto highest = static_cast<float>(setting_.scene.lowest());
      for (std::size_t s = 0; s < samples; ++s) {
        const std::size_t ray = static_cast<std::size_t>(x) * samples + s;
        if (views_.met(ray)) highest = std::max(highest, views_.heightMet(ray));
        if (!views_.met(ray)) {
          ++figures.through;
        } else if (!views_.addDiffuse(ray, {1, 1, 1}, response)) {
          ++figures.inside;
        } else if (setting_.glossy_samples > 0) {
          mirror(views_, ray, view, setting_.glossy_samples, {1, 1, 1}, texel * samples + s);
        }
      }
      if (!responses_.heights.empty()) responses_.heights[texel] = highest;
      figures.glossy_rays += followPaths(response);
      for (float& value : response) value /= static_cast<float>(samples);
      for (std::size_t c = 0; c < 3; ++c)
        figures.weighted_sums[c] += view.z() * response[c * responses_.coefficients];
    }
    return figures;
  }

 private:
  struct Path {
    Float3 weight;
    Vec3 direction;
    std::uint64_t element;
  };

  // `count` paths that go on from where a ray met the surface.
  void mirror(const Looks& looks, std::size_t ray, const Vec3& view, int count, const Float3& weight,
              std::uint64_t element) {
    const Looks::Place place = looks.placeOf(ray);
    found_.clear();
    setting_.reflection.sample(place.normal, view, count, element, found_);
    for (const GlossySample& sample : found_) {
      if (sample.incoming.dot(place.facet) <= 0 || sample.weight.isZero()) continue;
      const Vec3 all = vec3(weight).cwiseProduct(sample.weight) / count;
      next_.rays.push(place.position + setting_.offset * place.facet, sample.incoming);
      next_paths_.push_back(
          {transport::float3(all), sample.incoming, transport::scrambled(element + next_paths_.size())});
    }
  }

  void startPaths() { next_.rays.clear(), next_paths_.clear(); }

  // Until all paths have left; how many rays that took.
  std::uint64_t followPaths(std::span<float> response) {
    std::uint64_t rays = 0;
    for (int depth = 0; !next_paths_.empty() && depth <= setting_.options.most_mirrorings; ++depth) {
      std::swap(next_.rays, mirrored_.rays), std::swap(next_paths_, paths_);
      startPaths();
      if (setting_.options.shadows) mirrored_.trace(), rays += paths_.size();
      for (std::size_t i = 0; i < paths_.size(); ++i) {
        const Path& path = paths_[i];
        if (setting_.options.shadows && mirrored_.met(i)) {
          if (depth == setting_.options.most_mirrorings) continue;
          mirrored_.addDiffuse(i, path.weight, response);
          mirror(mirrored_, i, -path.direction, 1, path.weight, path.element);
        } else if (path.direction.z() > 0) {
          addSky(path, response);
        }
      }
    }
    return rays;
  }

  void addSky(const Path& path, std::span<float> response) {
    const LightBasis::Values values = setting_.basis.at(path.direction, room_);
    addTinted(values.some.data(), 0, values.some.size(), path.weight.data(), &response[values.first],
              responses_.coefficients);
  }

  const Setting& setting_;
  const Responses& responses_;
  Looks views_, mirrored_, next_;
  std::vector<GlossySample> found_;
  std::vector<Path> paths_, next_paths_;
  LightBasis::Room room_;
};

}  // namespace

ViewFigures renderViews(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                        const SurfaceLight& light, const ViewOptions& options, const LightBasis& basis,
                        const std::function<void()>& progress, const Responses& responses) {
  const Setting setting = settingOf(geometry, scene, light, options, basis);
  const auto rows = static_cast<std::size_t>(responses.height);
  std::vector<ViewFigures> parts(static_cast<std::size_t>(responses.views) * responses.views * rows);
  tbb::enumerable_thread_specific<RowOfTexels> workspaces([&] { return RowOfTexels(setting, responses); });
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
    const int view = static_cast<int>(part / rows), y = static_cast<int>(part % rows);
    parts[part] = workspaces.local().render(view, y);
    if (y == 0) progress();
  });
  ViewFigures figures;
  for (const ViewFigures& part : parts) {
    figures.rays += part.rays, figures.through += part.through, figures.inside += part.inside;
    figures.glossy_rays += part.glossy_rays;
    for (std::size_t c = 0; c < 3; ++c) figures.weighted_sums[c] += part.weighted_sums[c];
  }
  return figures;
}

}  // namespace bakelight::rtt
