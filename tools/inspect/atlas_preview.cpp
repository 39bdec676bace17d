#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "formats/error.h"
#include "formats/materials.h"
#include "tools/inspect/atlas_figures.h"
#include "tools/inspect/colormap.h"
#include "tools/inspect/preview.h"
#include "tools/inspect/render.h"
#include "transport/color.h"
#include "transport/texture_stretch.h"

namespace bakelight::inspect {

using formats::Float3;
using formats::Image;
using formats::TriangleMesh;
using transport::Vec2;

namespace {

constexpr double kLineWidth_px = 1.5;  // of chart borders
constexpr double kInk = 0.9;           // of chart borders: the share of light that they take
constexpr double kWireInk = 0.35;      // of triangles' edges
constexpr double kWireHalfWidth_px = 0.4;
constexpr double kLeastWired_px = 3,
                 kFullyWired_px = 10;               // height of triangles, so that small ones are no grey
constexpr float kPaper = 0.04f, kUnpainted = 0.6f;  // linear
constexpr double kRangeShare = 0.99;                // of the area: stretch beyond the range has full colour
constexpr double kLeastRange = 0.05;                // binary logarithm

float linear(float display) {
  return transport::linearFromSrgb(display);
}

Float3 linearColor(const DisplayColor& color) {
  return {linear(color[0]), linear(color[1]), linear(color[2])};
}

// The least value that `share` of the area stays below in absolute terms.
double rangeOf(const TriangleMesh& mesh, const std::vector<double>& values) {
  std::vector<std::pair<double, double>> weighted;  // value, area
  double whole = 0;
  for (std::size_t t = 0; t < values.size(); ++t) {
    const formats::Triangle& triangle = mesh.triangles[t];
    const transport::Vec3 a = transport::vec3(mesh.positions[triangle[0]]);
    const auto edgeTo = [&](std::size_t k) {
      return transport::Vec3(transport::vec3(mesh.positions[triangle[k]]) - a);
    };
    weighted.emplace_back(std::abs(values[t]), edgeTo(1).cross(edgeTo(2)).norm());
    whole += weighted.back().second;
  }
  std::sort(weighted.begin(), weighted.end());
  double sum = 0, range = kLeastRange;
  for (const auto& [value, area] : weighted) {
    if (std::isfinite(value)) range = std::max(range, value);
    sum += area;
    if (sum >= kRangeShare * whole) break;
  }
  return range;
}

struct Painting {
  std::vector<Float3> colors;  // of triangles, linear
  std::string caption;
};

Painting paintCharts(const TriangleMesh& mesh, const AtlasFigures& figures) {
  Painting painting;
  const std::vector<std::uint32_t> numbers = alternateNumbers(mesh, figures, kChartColors);
  for (const std::uint32_t chart : figures.triangle_charts)
    painting.colors.push_back(linearColor(chartColor(numbers[chart])));
  painting.caption = std::to_string(figures.charts) + (figures.charts == 1 ? " chart" : " charts") +
                     ", neighbours in different colours";
  return painting;
}

Painting paintStretch(const TriangleMesh& mesh, const AtlasFigures& figures) {
  Painting painting;
  std::vector<double> values;
  for (const double stretch : figures.triangle_stretch) values.push_back(std::log2(stretch));
  const double range = rangeOf(mesh, values);
  for (const double value : values) painting.colors.push_back(linearColor(divergingColor(value / range)));
  painting.caption = fmt::format(
      "L2 stretch of triangles at the mean scale: white is 1, red is {:.3g} (less or uneven texture), "
      "blue is {:.3g} (more texture); colour grows with the square root; magenta has none",
      std::exp2(range), std::exp2(-range));
  return painting;
}

Painting paintMaterials(const TriangleMesh& mesh, const std::string& file) {
  if (mesh.triangle_materials.empty())
    throw badInput({file, "", ""}, "has no materials to paint", "a mesh whose triangles have materials",
                   "leave out --paint");
  Painting painting;
  for (const std::uint32_t material : mesh.triangle_materials)
    painting.colors.push_back(linearColor(chartColor(material)));
  const std::size_t count = formats::usedMaterials(mesh);
  painting.caption = std::to_string(count) + (count == 1 ? " material" : " materials") +
                     " in different colours, each twelfth in the same one";
  return painting;
}

Painting paint(const TriangleMesh& mesh, const AtlasFigures& figures, Paint kind, const std::string& file) {
  if (kind == Paint::kMaterials) return paintMaterials(mesh, file);
  if (kind == Paint::kCharts) return paintCharts(mesh, figures);
  if (kind == Paint::kStretch) return paintStretch(mesh, figures);
  return {std::vector<Float3>(mesh.triangleCount(), {kUnpainted, kUnpainted, kUnpainted}), "charts"};
}

// --- on the model ---

// Each triangle with vertices of its own, so that its colour ends where it ends.
TriangleMesh takenApart(const TriangleMesh& mesh) {
  TriangleMesh apart;
  for (const auto& triangle : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(apart.vertexCount());
    for (const std::uint32_t v : triangle) apart.positions.push_back(mesh.positions[v]);
    apart.triangles.push_back({first, first + 1, first + 2});
  }
  return apart;
}

// Darkens the pixels along the lines on which the charts, or materials, that subsamples see change.
void drawBorders(transport::CpuPicture& picture, const std::vector<std::uint32_t>& triangle_regions) {
  const int width = picture.linear.width * kSupersampling, height = picture.linear.height * kSupersampling;
  constexpr int kReach = static_cast<int>(kLineWidth_px * kSupersampling / 2);
  const auto regionAt = [&](int x, int y) -> std::int64_t {
    if (x < 0 || y < 0 || x >= width || y >= height) return -1;
    const transport::SubsampleHit& hit =
        picture.hits[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                     static_cast<std::size_t>(x)];
    return hit.valid() ? triangle_regions[hit.triangle] : -1;
  };
  const auto isBorder = [&](int x, int y) {
    const std::int64_t own = regionAt(x, y);
    if (own < 0) return false;
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const std::int64_t other = regionAt(x + dx, y + dy);
        if (dx * dx + dy * dy <= kReach * kReach && other >= 0 && other != own) return true;
      }
    return false;
  };
  for (int y = 0; y < picture.linear.height; ++y)
    for (int x = 0; x < picture.linear.width; ++x) {
      int count = 0;
      for (int j = 0; j < kSupersampling; ++j)
        for (int i = 0; i < kSupersampling; ++i)
          count += isBorder(x * kSupersampling + i, y * kSupersampling + j);
      const double share = static_cast<double>(count) / (kSupersampling * kSupersampling);
      for (std::size_t c = 0; c < 3; ++c)
        picture.linear.texel(x, y)[c] *= static_cast<float>(1 - kInk * share);
    }
}

Image drawModel(const TriangleMesh& mesh, const std::vector<std::uint32_t>& triangle_regions,
                const Painting& painting, const PreviewOptions& options, const std::string& file) {
  const transport::OrbitCamera camera = cameraFor(mesh, options, file);
  const std::vector<Float3> clay = clayRadiance(mesh);
  std::vector<Float3> radiance;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) {
      Float3 color = clay[v];
      for (std::size_t c = 0; c < 3; ++c) color[c] *= painting.colors[t][c] / kClayAlbedo;
      radiance.push_back(color);
    }
  const double exposure = defaultExposure();
  const formats::TriangleMesh apart = takenApart(mesh);
  transport::CpuPicture picture =
      takePicture(apart, transport::interpolated(apart.triangles, radiance), camera, exposure, options);
  drawBorders(picture, triangle_regions);
  return transport::encodeForDisplay(picture.linear, static_cast<float>(exposure));
}

// --- in the unit square ---

// A triangle in pixels, x right and y down.
struct PixelTriangle {
  std::array<Vec2, 3> corners;
  std::array<double, 3> heights;     // over edge k
  std::array<double, 3> line_width;  // half, along edge k
  std::array<double, 3> ink;         // along edge k
  double cross;                      // twice the signed area

  PixelTriangle(const TriangleMesh& mesh, std::size_t t, const std::array<std::uint8_t, 3>& borders,
                int size_px) {
    for (std::size_t k = 0; k < 3; ++k) {
      const formats::Float2& texcoord = mesh.texcoords[mesh.triangles[t][k]];
      corners[k] = size_px * Vec2(texcoord[0], 1 - static_cast<double>(texcoord[1]));
    }
    cross = transport::crossOf(corners[0], corners[1], corners[2]);
    double least = INFINITY;
    for (std::size_t k = 0; k < 3; ++k) {
      heights[k] = std::abs(cross) / (corners[(k + 1) % 3] - corners[k]).norm();
      least = std::min(least, heights[k]);
    }
    const double wired = std::clamp((least - kLeastWired_px) / (kFullyWired_px - kLeastWired_px), 0.0, 1.0);
    for (std::size_t k = 0; k < 3; ++k) {
      line_width[k] = borders[k] ? kLineWidth_px / 2 : kWireHalfWidth_px;
      ink[k] = borders[k] ? kInk : kWireInk * wired;
    }
  }

  // Light that the lines leave at a point, or −1 if it lies outside.
  double lightAt(const Vec2& p) const {
    double light = 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const double share = transport::crossOf(corners[k], corners[(k + 1) % 3], p) / cross;
      if (share < 0) return -1;
      if (share * heights[k] < line_width[k]) light = std::min(light, 1 - ink[k]);
    }
    return light;
  }
};

// One row of pixels with its subsamples at a time, so that large pictures need little memory.
class SquareRow {
 public:
  explicit SquareRow(int size_px)
      : width_(size_px * kSupersampling), colors_(static_cast<std::size_t>(width_ * kSupersampling)) {}

  void clear() { std::fill(colors_.begin(), colors_.end(), Float3{kPaper, kPaper, kPaper}); }

  void draw(int row, const PixelTriangle& triangle, const Float3& color) {
    const auto [left, right] =
        std::minmax({triangle.corners[0].x(), triangle.corners[1].x(), triangle.corners[2].x()});
    const int begin = static_cast<int>(std::clamp(left * kSupersampling - 1, 0.0, double(width_)));
    const int end = static_cast<int>(std::clamp(right * kSupersampling + 1, 0.0, double(width_)));
    for (int j = 0; j < kSupersampling; ++j)
      for (int i = begin; i < end; ++i) {
        const double light =
            triangle.lightAt(Vec2((i + 0.5) / kSupersampling, row + (j + 0.5) / kSupersampling));
        if (light < 0) continue;
        for (std::size_t c = 0; c < 3; ++c) colors_[sampleAt(i, j)][c] = static_cast<float>(light) * color[c];
      }
  }

  void resolve(int row, Image& image) const {
    for (int x = 0; x < image.width; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        float sum = 0;
        for (int j = 0; j < kSupersampling; ++j)
          for (int i = 0; i < kSupersampling; ++i) sum += colors_[sampleAt(x * kSupersampling + i, j)][c];
        image.texel(x, row)[c] = transport::srgbFromLinear(sum / (kSupersampling * kSupersampling));
      }
  }

 private:
  std::size_t sampleAt(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(i);
  }

  int width_;
  std::vector<Float3> colors_;  // kSupersampling rows
};

Image drawSquare(const TriangleMesh& mesh, const AtlasFigures& figures, const Painting& painting,
                 int size_px) {
  // The triangles that reach into each row.
  std::vector<PixelTriangle> triangles;
  std::vector<std::vector<std::uint32_t>> rows(static_cast<std::size_t>(size_px));
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
    triangles.emplace_back(mesh, t, figures.chart_borders[t], size_px);
    const auto& c = triangles.back().corners;
    const auto [top, bottom] = std::minmax({c[0].y(), c[1].y(), c[2].y()});
    if (triangles.back().cross == 0 || bottom < 0 || top >= size_px) continue;
    const auto last = static_cast<std::size_t>(std::min(bottom, size_px - 1.0));
    for (auto row = static_cast<std::size_t>(std::max(top, 0.0)); row <= last; ++row) rows[row].push_back(t);
  }
  Image image(size_px, size_px, {"R", "G", "B"});
  SquareRow square(size_px);
  for (int row = 0; row < size_px; ++row) {
    square.clear();
    for (const std::uint32_t t : rows[static_cast<std::size_t>(row)])
      square.draw(row, triangles[t], painting.colors[t]);
    square.resolve(row, image);
  }
  return image;
}

}  // namespace

Preview previewMaterials(const TriangleMesh& mesh, const PreviewOptions& options, const std::string& file) {
  const Painting painting = paintMaterials(mesh, file);
  return {drawModel(mesh, mesh.triangle_materials, painting, options, file),
          painting.caption + "; on clay without shadows, dark lines between materials"};
}

Preview previewAtlas(const TriangleMesh& mesh, const PreviewOptions& options, const std::string& file) {
  if (mesh.texcoords.empty())
    throw badInput({file, "", ""}, "has no texture coordinates, so there are no charts to draw",
                   "a mesh with texture coordinates",
                   "run the atlas tool on it, or draw it with --paint none");
  const AtlasFigures figures = measureAtlas(mesh);
  const Paint kind = options.paint == Paint::kAutomatic ? Paint::kCharts : options.paint;
  Painting painting = paint(mesh, figures, kind, file);
  if (options.layout == Layout::kModel)
    return {drawModel(mesh, figures.triangle_charts, painting, options, file),
            painting.caption + "; on clay without shadows, dark lines between charts"};
  std::string caption = painting.caption + "; the unit square, u to the right and v upwards";
  if (figures.triangles_outside > 0)
    caption += ", without what lies outside of " + std::to_string(figures.triangles_outside) + " triangles";
  return {drawSquare(mesh, figures, painting, options.size_px), std::move(caption)};
}

}  // namespace bakelight::inspect
