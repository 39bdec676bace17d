#include "tools/kernels/texels.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "formats/error.h"
#include "formats/exr_rows.h"

namespace bakelight::kernels {
namespace {

enum Channel : std::size_t {
  kCoverage,
  kChart,
  kTriangle,
  kU,
  kV,
  kPosition,
  kNormal = kPosition + 3,
  kArea = kNormal + 3,
  kChannels
};
constexpr int kRowsAtOnce = 64;
// Coverages of the maps.
constexpr float kAtEdge = 2, kBeyondEdge = 3;

std::string nameOf(std::size_t place, int width) {
  const auto w = static_cast<std::size_t>(width);
  return "texel (" + std::to_string(place % w) + ", " + std::to_string(place / w) + ")";
}

// Over the surface for one texel: derivatives of position by column and by row, from texture coordinates.
struct Step {
  Eigen::Vector3f across = Eigen::Vector3f::Zero(), down = Eigen::Vector3f::Zero();
};
Step stepOf(const formats::TriangleMesh& mesh, const formats::Triangle& t, int resolution) {
  const auto at = [&](int k) { return transport::vec3(mesh.positions[t[static_cast<std::size_t>(k)]]); };
  const auto uv = [&](int k) -> Eigen::Vector2d {
    const auto& c = mesh.texcoords[t[static_cast<std::size_t>(k)]];
    return Eigen::Vector2d(static_cast<double>(c[0]), 1 - static_cast<double>(c[1])) *
           resolution;  // rows from the top
  };
  const Eigen::Vector2d e1 = uv(1) - uv(0), e2 = uv(2) - uv(0);
  const double det = e1.x() * e2.y() - e1.y() * e2.x();
  if (det == 0) return {};
  const Vec3 p1 = at(1) - at(0), p2 = at(2) - at(0);
  const Vec3 across = (p1 * e2.y() - p2 * e1.y()) / det, down = (p2 * e1.x() - p1 * e2.x()) / det;
  return {across.cast<float>(), down.cast<float>()};
}

// Whether two triangles that share an edge lie in different charts.
bool hasSeams(const formats::TriangleMesh& mesh, const Knots& knots) {
  std::map<std::array<std::uint32_t, 2>, std::array<std::uint32_t, 2>> edges;  // by knots: the vertices
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<std::uint32_t, 2> ends = {mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]};
      if (knots.of_vertex[ends[0]] > knots.of_vertex[ends[1]]) std::swap(ends[0], ends[1]);
      const auto [found, is_new] =
          edges.try_emplace({knots.of_vertex[ends[0]], knots.of_vertex[ends[1]]}, ends);
      if (is_new) continue;
      for (std::size_t e = 0; e < 2; ++e)
        if (mesh.texcoords[found->second[e]] != mesh.texcoords[ends[e]]) return true;
    }
  return false;
}

// How far, in rows and columns, texels beyond the edge of a chart are from it at most; up to kBorder.
int borderOf(const Texels& texels, const std::vector<std::uint8_t>& coverages) {
  const int side = texels.resolution;
  const auto isWithin = [&](std::size_t i, int reach) {
    const int x = static_cast<int>(texels.places[i]) % side, y = static_cast<int>(texels.places[i]) / side;
    for (int v = std::max(y - reach, 0); v <= std::min(y + reach, side - 1); ++v)
      for (int u = std::max(x - reach, 0); u <= std::min(x + reach, side - 1); ++u) {
        const std::int32_t other = texels.index_of[static_cast<std::size_t>(v) * side + u];
        if (other >= 0 && texels.charts[static_cast<std::size_t>(other)] == texels.charts[i] &&
            static_cast<float>(coverages[static_cast<std::size_t>(other)]) != kBeyondEdge)
          return true;
      }
    return false;
  };
  int border = 0;
  for (std::size_t i = 0; i < texels.count() && border < kBorder; ++i) {
    if (static_cast<float>(coverages[i]) != kBeyondEdge) continue;
    while (border < kBorder && !isWithin(i, border)) ++border;
  }
  return border;
}

}  // namespace

Texels texelsOf(const std::filesystem::path& maps, const formats::TriangleMesh& mesh, const Knots& knots) {
  const std::string file = maps.string();
  formats::ExrRows rows(
      maps, {"coverage", "chart", "triangle", "barycentric.U", "barycentric.V", "position.X", "position.Y",
             "position.Z", "normal.X", "normal.Y", "normal.Z", "area"});
  if (rows.width() != rows.height())
    throw badInput({file, "", ""}, "it is no square", "the geometry maps that atlas wrote");
  if (mesh.texcoords.empty())
    throw badInput({file, "", ""}, "the mesh has no texture coordinates", "the mesh that atlas wrote",
                   "give --mesh atlas.ply");

  Texels texels;
  const int side = rows.width();
  texels.resolution = side;
  texels.index_of.assign(static_cast<std::size_t>(side) * side, -1);
  std::vector<Step> steps;
  for (const formats::Triangle& t : mesh.triangles) steps.push_back(stepOf(mesh, t, side));

  std::vector<std::uint8_t> coverages;
  std::vector<float> values;
  for (int first = 0; first < side; first += kRowsAtOnce) {
    const int count = std::min(kRowsAtOnce, side - first);
    values.resize(kChannels * static_cast<std::size_t>(side) * count);
    rows.read(first, count, values);
    for (std::size_t i = 0; i < static_cast<std::size_t>(side) * count; ++i) {
      const float* map = &values[kChannels * i];
      if (map[kCoverage] == 0) continue;
      const std::size_t place = static_cast<std::size_t>(first) * side + i;
      const auto triangle = static_cast<std::size_t>(std::max(map[kTriangle], 0.0F));
      if (map[kTriangle] < 0 || triangle >= mesh.triangles.size())
        throw badInput({file, nameOf(place, side), ""},
                       "it names triangle " + std::to_string(static_cast<long>(map[kTriangle])),
                       "one of the " + std::to_string(mesh.triangles.size()) + " of the mesh",
                       "give the mesh that the maps are of");
      texels.index_of[place] = static_cast<std::int32_t>(texels.places.size());
      texels.places.push_back(static_cast<std::uint32_t>(place));
      texels.triangles.push_back(static_cast<std::uint32_t>(triangle));
      texels.weights.emplace_back(1 - map[kU] - map[kV], map[kU], map[kV]);
      texels.positions.emplace_back(map[kPosition], map[kPosition + 1], map[kPosition + 2]);
      texels.normals.emplace_back(map[kNormal], map[kNormal + 1], map[kNormal + 2]);
      texels.charts.push_back(static_cast<std::uint32_t>(map[kChart]));
      texels.areas.push_back(map[kCoverage] == kBeyondEdge ? 0 : map[kArea]);
      coverages.push_back(static_cast<std::uint8_t>(map[kCoverage]));
    }
  }
  if (texels.count() == 0)
    throw badInput({file, "channel coverage", ""}, "no texel is covered", "one at least");

  // Positions must be the mesh's: other maps would pass for these in silence.
  const double scale = knots.meanSpacing();
  for (std::size_t i = 0; i < texels.count(); ++i) {
    const auto& t = knots.triangles[texels.triangles[i]];
    Vec3 at = Vec3::Zero();
    for (int k = 0; k < 3; ++k)
      at += static_cast<double>(texels.weights[i][k]) * knots.positions[t[static_cast<std::size_t>(k)]];
    if (!((at - texels.positions[i].cast<double>()).norm() < 0.05 * scale + 1e-5 * at.norm()))
      throw badInput({file, nameOf(texels.places[i], side), ""},
                     "it lies elsewhere than its triangle of the mesh", "the maps of this mesh",
                     "give the mesh that atlas wrote with them");
  }

  if (hasSeams(mesh, knots)) {
    const int border = borderOf(texels, coverages);
    if (border < kBorder)
      throw badInput({file, "channel coverage", ""},
                     "charts show " + (border == 0 ? "nothing" : std::to_string(border) + " texels") +
                         " of the surface beyond their edges",
                     std::to_string(kBorder) + " texels, which kernels see over",
                     "run atlas with --border 4");
  }

  // Areas of whole texels: of the triangle's own map, or, where another chart's surface is shown beyond an edge, the chart's mean.
  std::map<std::uint32_t, std::array<double, 2>> chart_means;
  for (std::size_t i = 0; i < texels.count(); ++i) {
    const Step& step = steps[texels.triangles[i]];
    texels.across.push_back(step.across), texels.down.push_back(step.down);
    texels.cells.push_back(step.across.cross(step.down).norm());
    texels.sides.push_back(std::sqrt(texels.cells.back()));
    if (coverages[i] != 1) continue;
    auto& mean = chart_means[texels.charts[i]];
    mean[0] += static_cast<double>(texels.cells[i]), mean[1] += 1;
  }
  for (std::size_t i = 0; i < texels.count(); ++i) {
    if (coverages[i] == 1 && texels.cells[i] > 0) continue;
    const auto mean = chart_means.find(texels.charts[i]);
    const float cell =
        mean == chart_means.end() ? texels.areas[i] : static_cast<float>(mean->second[0] / mean->second[1]);
    texels.sides[i] = std::max(std::sqrt(cell), 1e-3F * static_cast<float>(scale));
    // Where the surface ends at the edge of the chart, there is no more of it than that.
    bool goes_on = coverages[i] == static_cast<std::uint8_t>(kBeyondEdge);
    const int x = static_cast<int>(texels.places[i]) % side, y = static_cast<int>(texels.places[i]) / side;
    for (int dy = -1; dy <= 1 && !goes_on; ++dy)
      for (int dx = -1; dx <= 1 && !goes_on; ++dx) {
        if (x + dx < 0 || y + dy < 0 || x + dx >= side || y + dy >= side) continue;
        const std::int32_t other = texels.index_of[static_cast<std::size_t>(y + dy) * side + x + dx];
        goes_on = other >= 0 &&
                  coverages[static_cast<std::size_t>(other)] == static_cast<std::uint8_t>(kBeyondEdge);
      }
    texels.cells[i] = goes_on || coverages[i] != static_cast<std::uint8_t>(kAtEdge)
                          ? cell
                          : std::min(texels.areas[i], cell);
    // Neighbours of another chart have axes of their own, turned; only lengths are taken from here.
    if (coverages[i] == static_cast<std::uint8_t>(kBeyondEdge)) {
      const float length = std::sqrt(cell);
      const Eigen::Vector3f n = texels.normals[i];
      Eigen::Vector3f along = texels.across[i] - texels.across[i].dot(n) * n;
      along = along.norm() > 0 ? along.normalized() : n.unitOrthogonal();
      texels.across[i] = length * along, texels.down[i] = length * n.cross(along);
    }
  }
  return texels;
}

void takeSurroundings(const transport::MediumField& field, const formats::TriangleMesh& mesh, Knots& knots,
                      Texels& texels) {
  if (!field.isOfSurface()) return;
  const auto colorOf = [&](std::size_t vertex) {
    return Eigen::Map<const Eigen::Array3f>(mesh.colors[vertex].data());
  };
  const auto around = [&](const Vec3& position, const Eigen::Array3f& color) {
    return field.surroundings(position, {color[0], color[1], color[2]});
  };
  // Of vertices at the same place the mean.
  std::vector<Eigen::Array4f> sums(knots.count(), Eigen::Array4f::Zero());
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    sums[knots.of_vertex[v]].head<3>() += colorOf(v);
    sums[knots.of_vertex[v]][3] += 1;
  }
  knots.surroundings.resize(knots.count());
  tbb::parallel_for(std::size_t{0}, knots.count(), [&](std::size_t k) {
    knots.surroundings[k] = around(knots.positions[k], sums[k].head<3>() / sums[k][3]);
  });
  texels.surroundings.resize(texels.count());
  tbb::parallel_for(std::size_t{0}, texels.count(), [&](std::size_t i) {
    Eigen::Array3f color = Eigen::Array3f::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      color +=
          texels.weights[i][static_cast<Eigen::Index>(k)] * colorOf(mesh.triangles[texels.triangles[i]][k]);
    texels.surroundings[i] = around(texels.positions[i].cast<double>(), color);
  });
}

}  // namespace bakelight::kernels
