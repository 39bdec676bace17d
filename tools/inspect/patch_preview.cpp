#include "tools/inspect/patch_preview.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/error.h"
#include "tools/inspect/direction_strokes.h"
#include "tools/inspect/render.h"
#include "transport/color.h"
#include "transport/vector_types.h"

namespace bakelight::inspect {

using formats::Float2;
using formats::Float3;
using formats::Image;
using formats::IndexImage;
using formats::MesoMesh;
using formats::TriangleMesh;
using transport::Vec3;
using transport::vec3;

namespace {

constexpr double kPatchSteps = 65536;  // docs/FORMATS.md, id maps
constexpr float kGutterLight = 1.0F / 3;
constexpr float kPatchBlue = 0.15F;
enum IdChannel : std::size_t { kPatchU, kPatchV, kMaterial, kVertex, kCoverage };
const std::vector<std::string> kIdChannels = {"patch.U", "patch.V", "material", "vertex", "coverage"};

Float3 patchColor(double u, double v) {
  return {static_cast<float>(u), static_cast<float>(v), kPatchBlue};
}

Image onModel(const TriangleMesh& mesh, const std::vector<Float3>& colors, const PreviewOptions& options,
              const std::string& file) {
  const transport::OrbitCamera camera = cameraFor(mesh, options, file);
  std::vector<Float3> radiance = clayRadiance(mesh);
  for (std::size_t v = 0; v < radiance.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c) radiance[v][c] *= colors[v][c] / kClayAlbedo;
  return render(mesh, transport::interpolated(mesh.triangles, radiance), camera, defaultExposure(), options);
}

// In which direction neighbors lie in the patch, per unit of length along the surface.
class PatchScale {
 public:
  explicit PatchScale(const MesoMesh& meso) : meso_(meso) {
    std::vector<double> widths;
    forEachEdge([&](std::uint32_t a, std::uint32_t b) {
      const Float2 step = stepInPatch(a, b);
      const double length = std::hypot(step[0], step[1]);
      if (length > 0)
        widths.push_back((vec3(meso.mesh.positions[a]) - vec3(meso.mesh.positions[b])).norm() / length);
    });
    if (widths.empty()) return;
    // Where neighbors continue each other all say the same width, else anything: the densest tenth.
    std::sort(widths.begin(), widths.end());
    const std::size_t span = std::max<std::size_t>(widths.size() / 10, 1);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i + span < widths.size() + 1 && i + span - 1 < widths.size(); ++i) {
      const double spread = widths[i + span - 1] / widths[i];
      if (spread < least) least = spread, width_ = widths[i + span / 2];
    }
  }

  double width() const { return width_; }

  template <class Visit>
  void forEachEdge(const Visit& visit) const {
    for (const formats::Triangle& t : meso_.mesh.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k], b = t[(k + 1) % 3];
        if (meso_.materials[a] == meso_.materials[b]) visit(a, b);
      }
  }

  // From a to b, the short way around.
  Float2 stepInPatch(std::uint32_t a, std::uint32_t b) const {
    Float2 step;
    for (std::size_t c = 0; c < 2; ++c)
      step[c] =
          static_cast<float>(std::remainder(static_cast<double>(meso_.patch[b][c]) - meso_.patch[a][c], 1.0));
    return step;
  }

  bool continues(std::uint32_t a, std::uint32_t b) const {
    const double length = (vec3(meso_.mesh.positions[a]) - vec3(meso_.mesh.positions[b])).norm();
    const Float2 step = stepInPatch(a, b);
    return std::abs(std::hypot(step[0], step[1]) * width_ - length) <= length / 2;
  }

 private:
  const MesoMesh& meso_;
  double width_ = 0;
};

}  // namespace

std::vector<float> coherenceOf(const MesoMesh& meso) {
  const PatchScale scale(meso);
  if (!(scale.width() > 0)) return {};
  std::vector<float> same(meso.mesh.vertexCount(), 0), all(meso.mesh.vertexCount(), 0);
  scale.forEachEdge([&](std::uint32_t a, std::uint32_t b) {
    const float share = scale.continues(a, b) ? 1 : 0;
    same[a] += share, same[b] += share;
    ++all[a], ++all[b];
  });
  for (std::size_t v = 0; v < same.size(); ++v) same[v] = all[v] > 0 ? same[v] / all[v] : 1;
  return same;
}

Preview previewMesoMesh(const MesoMesh& meso, const PreviewOptions& options, const std::string& file) {
  const TriangleMesh& mesh = meso.mesh;
  switch (options.paint) {
    case Paint::kAutomatic:
    case Paint::kColors:
      if (mesh.colors.empty() && options.paint == Paint::kAutomatic) return previewMesh(mesh, options, file);
      return previewColors(mesh, options, file);
    case Paint::kPatch: {
      std::vector<Float3> colors;
      for (const Float2& place : meso.patch) colors.push_back(patchColor(place[0], place[1]));
      return {onModel(mesh, colors, options, file), "place in the patch: red grows with u, green with v"};
    }
    case Paint::kCoherence: {
      const std::vector<float> shares = coherenceOf(meso);
      if (shares.empty())
        throw badInput({file, "", ""}, "no two vertices are at different places of the patch",
                       "a meso-mesh that a texture was laid out on", "give mesomesh a material with a patch");
      std::vector<Float3> colors;
      for (const float share : shares) colors.push_back({share, share, share});
      return {onModel(mesh, colors, options, file),
              "white where neighbors continue each other in the patch, black where none does"};
    }
    case Paint::kTangents:
      return drawDirections(meso, options, file);
    default:
      throw badInput({file, "", ""}, "a meso-mesh has no texture coordinates to paint",
                     "--paint colors, patch, tangents or coherence");
  }
}

IndexImage readIdMap(const std::filesystem::path& path) {
  return formats::readIndexExr(path, kIdChannels);
}

bool isIdMap(const std::filesystem::path& path) {
  const std::vector<std::string> channels = formats::exrChannels(path);
  return std::all_of(kIdChannels.begin(), kIdChannels.end(), [&](const std::string& name) {
    return std::find(channels.begin(), channels.end(), name) != channels.end();
  });
}

Preview previewIdMap(const IndexImage& ids, const PreviewOptions& options) {
  Image image(options.size_px, options.size_px, {"R", "G", "B"});
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::uint32_t* id = ids.texel(static_cast<int>(std::int64_t{x} * ids.width / image.width),
                                          static_cast<int>(std::int64_t{y} * ids.height / image.height));
      const Float3 color = patchColor(id[kPatchU] / kPatchSteps, id[kPatchV] / kPatchSteps);
      for (std::size_t c = 0; c < 3; ++c)
        image.texel(x, y)[c] =
            transport::srgbFromLinear(color[c] * (id[kCoverage] == 0 ? kGutterLight : 1.0F));
    }
  return {std::move(image),
          "place in the patch: red grows with u, green with v; darker where copies fill the gutters"};
}

Preview previewThroughIdMap(const TriangleMesh& mesh, const IndexImage& ids,
                            const std::optional<Image>& exemplar, const PreviewOptions& options,
                            const std::string& file) {
  if (mesh.texcoords.empty())
    throw badInput({file, "", ""}, "has no texture coordinates, so an id map cannot be put on it",
                   "the mesh of the atlas that the id map was made with");
  const auto texelOf = [](double place, int side) {
    return std::clamp(static_cast<int>(place * side), 0, side - 1);
  };
  const auto colorAt = [&](const Float2& texcoord) {
    const std::uint32_t* id =
        ids.texel(texelOf(texcoord[0], ids.width), texelOf(1 - static_cast<double>(texcoord[1]), ids.height));
    const double u = id[kPatchU] / kPatchSteps, v = id[kPatchV] / kPatchSteps;
    if (!exemplar) return patchColor(u, v);
    const float* texel =
        exemplar->texel(texelOf(u, exemplar->width), exemplar->height - 1 - texelOf(v, exemplar->height));
    return Float3{texel[0], texel[1], texel[2]};
  };
  const transport::OrbitCamera camera = cameraFor(mesh, options, file);
  const std::vector<Float3> clay = clayRadiance(mesh);
  const transport::RadianceAtHits lit = transport::interpolated(mesh.triangles, clay);
  const auto shade = [&](std::span<const transport::SurfaceHit> hits, std::span<Float3> radiance) {
    lit(hits, radiance);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const formats::Triangle& t = mesh.triangles[hits[i].triangle];
      const std::array<float, 3> weights = {1 - hits[i].u - hits[i].v, hits[i].u, hits[i].v};
      Float2 texcoord = {0, 0};
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t c = 0; c < 2; ++c) texcoord[c] += weights[k] * mesh.texcoords[t[k]][c];
      const Float3 color = colorAt(texcoord);
      for (std::size_t c = 0; c < 3; ++c) radiance[i][c] *= color[c] / kClayAlbedo;
    }
  };
  return {render(mesh, shade, camera, defaultExposure(), options),
          exemplar ? "the exemplar through the id map, on clay without shadows"
                   : "place in the patch through the id map: red grows with u, green with v"};
}

}  // namespace bakelight::inspect
