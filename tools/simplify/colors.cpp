#include "tools/simplify/colors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/error.h"
#include "tools/simplify/surface_query.h"
#include "transport/color.h"

namespace bakelight::simplify {

using formats::Float3;
using formats::Image;
using formats::TriangleMesh;
using transport::vec3;

namespace {

// Samples sit at the centroids of kSplits² congruent parts of each triangle.
constexpr int kSplits = 4;

std::vector<Vec3> sampleWeights() {
  std::vector<Vec3> weights;
  for (int i = 0; i < kSplits; ++i)
    for (int j = 0; i + j < kSplits; ++j) {
      const auto at = [&](double u, double v) { weights.push_back(Vec3(1 - u - v, u, v)); };
      at((i + 1.0 / 3) / kSplits, (j + 1.0 / 3) / kSplits);
      if (i + j + 1 < kSplits) at((i + 2.0 / 3) / kSplits, (j + 2.0 / 3) / kSplits);
    }
  return weights;
}

// Texture coordinates have their origin at the lower left; the image repeats.
Vec3 lookUp(const Image& texture, double u, double v) {
  const double x = (u - std::floor(u)) * texture.width - 0.5;
  const double y = (1 - (v - std::floor(v))) * texture.height - 0.5;
  const auto wrapped = [](int i, int size) { return (i % size + size) % size; };
  const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
  Vec3 color = Vec3::Zero();
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      const double weight = (dx == 1 ? x - column : 1 - (x - column)) * (dy == 1 ? y - row : 1 - (y - row));
      const float* texel =
          texture.texel(wrapped(column + dx, texture.width), wrapped(row + dy, texture.height));
      color += weight * Vec3(texel[0], texel[1], texel[2]);
    }
  return color;
}

// The texture and its halves, so that a sample takes the mean of what it stands for.
std::vector<Image> halvings(const Image* texture) {
  std::vector<Image> levels;
  if (texture == nullptr) return levels;
  levels.push_back(*texture);
  while (levels.back().width > 1 || levels.back().height > 1) {
    const Image& fine = levels.back();
    Image coarse(std::max(fine.width / 2, 1), std::max(fine.height / 2, 1), fine.channel_names);
    for (int y = 0; y < coarse.height; ++y)
      for (int x = 0; x < coarse.width; ++x)
        for (std::size_t c = 0; c < 3; ++c) {
          const int right = std::min(2 * x + 1, fine.width - 1), below = std::min(2 * y + 1, fine.height - 1);
          coarse.texel(x, y)[c] = (fine.texel(2 * x, 2 * y)[c] + fine.texel(right, 2 * y)[c] +
                                   fine.texel(2 * x, below)[c] + fine.texel(right, below)[c]) /
                                  4;
        }
    levels.push_back(std::move(coarse));
  }
  return levels;
}

// The level at which a sample that stands for `area` of a source triangle covers about one texel.
const Image& levelFor(const std::vector<Image>& levels, const TriangleMesh& source, const WorkingMesh& shape,
                      std::uint32_t triangle, double area) {
  const auto& [a, b, c] = source.triangles[triangle];
  const auto &s = source.texcoords[a], &t = source.texcoords[b], &u = source.texcoords[c];
  const double across = (t[0] - s[0]) * (u[1] - s[1]) - (t[1] - s[1]) * (u[0] - s[0]);
  const double texels = std::abs(across) * levels.front().width * levels.front().height;
  const double surface = shape.areaVector(triangle).norm();
  const double covered = surface > 0 ? texels * area / surface : 0;
  const int level = covered > 1 ? static_cast<int>(std::lround(0.5 * std::log2(covered))) : 0;
  return levels[std::min<std::size_t>(level, levels.size() - 1)];
}

// `texture` is null if the source's own colours count.
Vec3 colorAt(const TriangleMesh& source, const Image* texture, const SurfacePoint& point) {
  const auto& corners = source.triangles[point.triangle];
  if (texture == nullptr) {
    Vec3 color = Vec3::Zero();
    for (int k = 0; k < 3; ++k) color += point.barycentric[k] * vec3(source.colors[corners[k]]);
    return color;
  }
  double u = 0, v = 0;
  for (int k = 0; k < 3; ++k) {
    u += point.barycentric[k] * source.texcoords[corners[k]][0];
    v += point.barycentric[k] * source.texcoords[corners[k]][1];
  }
  return lookUp(*texture, u, v);
}

}  // namespace

Image readAlbedoTexture(const std::filesystem::path& path) {
  const Image image = formats::readImage(path);
  std::array<int, 3> channels = {image.channelIndex("R"), image.channelIndex("G"), image.channelIndex("B")};
  if (image.channelCount() <= 2) channels = {0, 0, 0};
  if (image.channelCount() == 0 || *std::min_element(channels.begin(), channels.end()) < 0)
    throw badInput({path.string(), "", ""}, "has no colour", "channels R, G and B, or a single one");
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c + ('a' - 'A') : c); });
  const bool linear = ending == ".exr" || ending == ".hdr";
  Image albedo(image.width, image.height, {"R", "G", "B"});
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        const float value = image.texel(x, y)[channels[c]];
        albedo.texel(x, y)[c] = linear ? value : transport::linearFromSrgb(value);
      }
  return albedo;
}

std::vector<Float3> carryAlbedo(const TriangleMesh& source, const Image* texture,
                                const TriangleMesh& simplified, const std::string& file) {
  if (texture == nullptr && source.colors.empty()) return {};
  if (texture != nullptr && source.texcoords.empty())
    throw badInput({file, "", ""}, "has no texture coordinates, so a texture cannot be put on it",
                   "a mesh with texture coordinates", "leave the texture out, or unwrap the mesh");

  const SurfaceQuery original(workingMesh(source));
  const WorkingMesh target = workingMesh(simplified);
  const std::vector<Vec3> weights = sampleWeights();
  const std::vector<Image> levels = halvings(texture);
  std::vector<std::array<Vec3, 3>> shares(target.triangles.size());  // of each triangle, for its corners
  std::vector<double> areas(target.triangles.size());
  tbb::parallel_for(std::size_t{0}, target.triangles.size(), [&](std::size_t t) {
    const Vec3 area = target.areaVector(t);
    areas[t] = area.norm() / 2;
    shares[t].fill(Vec3::Zero());
    for (const Vec3& w : weights) {
      const Vec3 position =
          w[0] * target.corner(t, 0) + w[1] * target.corner(t, 1) + w[2] * target.corner(t, 2);
      SurfacePoint point = original.closestFacing(position, area);
      if (!point.valid) point = original.closest(position);  // the source is inside out here
      const double sample_area = areas[t] / static_cast<double>(weights.size());
      const Image* level = texture == nullptr
                               ? nullptr
                               : &levelFor(levels, source, original.mesh(), point.triangle, sample_area);
      const Vec3 color = colorAt(source, level, point) / static_cast<double>(weights.size());
      for (int k = 0; k < 3; ++k) shares[t][k] += w[k] * color;
    }
  });

  std::vector<Vec3> sum(simplified.vertexCount(), Vec3::Zero());
  std::vector<double> weight(simplified.vertexCount(), 0.0);
  for (std::size_t t = 0; t < target.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = target.triangles[t][k];
      sum[v] += areas[t] * shares[t][k];
      weight[v] += areas[t] / 3;
    }
  std::vector<Float3> albedo(simplified.vertexCount(), Float3{0, 0, 0});
  for (std::size_t v = 0; v < albedo.size(); ++v)
    if (weight[v] > 0) albedo[v] = transport::float3((sum[v] / weight[v]).cwiseMax(0.0).cwiseMin(1.0));
  return albedo;
}

}  // namespace bakelight::simplify
