#include "tools/idmap/idmap.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "formats/error.h"
#include "formats/exr_rows.h"
#include "tools/idmap/nearest_points.h"
#include "transport/morton.h"
#include "transport/nearest_texel.h"

namespace bakelight::idmap {
namespace {

// Tiles are worked off along a Morton curve, as the search is quicker from one neighbor to the next.
constexpr int kTile = 16;
constexpr int kRowsAtOnce = 4 * kTile;

enum MapChannel : std::size_t {
  kCoverage,
  kTriangle,
  kPosition,
  kNormal = kPosition + 3,
  kMapChannels = kNormal + 3
};
enum IdChannel : std::size_t { kPatchU, kPatchV, kMaterial, kVertex, kIdCoverage, kIdChannels };

constexpr float kBorder = 3;  // coverage of texels beyond a chart's edge

std::uint32_t patchStep(float coordinate) {
  const double step = std::round(static_cast<double>(coordinate) * kPatchSteps);
  return static_cast<std::uint32_t>(std::clamp(step, 0.0, kPatchSteps - 1));
}

// Texels of a tile along the curve.
std::array<std::uint16_t, kTile * kTile> tileOrder() {
  std::array<std::uint16_t, kTile * kTile> order;
  std::iota(order.begin(), order.end(), std::uint16_t{0});
  std::sort(order.begin(), order.end(), [](std::uint16_t a, std::uint16_t b) {
    const auto code = [](std::uint16_t i) {
      return transport::mortonCode(static_cast<std::uint16_t>(i % kTile),
                                   static_cast<std::uint16_t>(i / kTile));
    };
    return code(a) < code(b);
  });
  return order;
}

class Mapper {
 public:
  Mapper(const MesoIndex& meso, const std::filesystem::path& maps, const IdMapOptions& options)
      : meso_(meso),
        options_(options),
        file_(maps.string()),
        maps_(maps, {"coverage", "triangle", "position.X", "position.Y", "position.Z", "normal.X", "normal.Y",
                     "normal.Z"}),
        shooting_(meso.surface, static_cast<std::size_t>(options.neighbors)) {
    result_.image = formats::IndexImage(maps_.width(), maps_.height(),
                                        {"patch.U", "patch.V", "material", "vertex", "coverage"});
    found_.resize(static_cast<std::size_t>(maps_.width()) * maps_.height());
  }

  IdMap make(const std::function<void(std::size_t)>& progress) {
    Rows rows = readRows(0);
    while (rows.count > 0) {
      Rows next;
      tbb::parallel_invoke([&] { next = readRows(rows.first + rows.count); }, [&] { mapRows(rows); });
      progress(static_cast<std::size_t>(rows.count));
      rows = std::move(next);
    }
    fill();
    return std::move(result_);
  }

 private:
  struct Tile {
    ShotFigures figures;
    std::int64_t covered = 0, moved = 0;
    std::optional<std::size_t> unanswered;  // texel of the surface
  };

  // A block of the maps; none at their end.
  struct Rows {
    int first = 0, count = 0;
    std::vector<float> values = {};
  };
  Rows readRows(int first) {
    Rows rows{first, std::min(kRowsAtOnce, maps_.height() - first)};
    rows.values.resize(kMapChannels * static_cast<std::size_t>(maps_.width()) * rows.count);
    if (rows.count > 0) maps_.read(first, rows.count, rows.values);
    return rows;
  }

  void mapRows(const Rows& rows) {
    const int across = (maps_.width() + kTile - 1) / kTile, down = (rows.count + kTile - 1) / kTile;
    std::vector<Tile> tiles(static_cast<std::size_t>(across) * down);
    tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t t) {
      const int x = static_cast<int>(t) % across * kTile, y = static_cast<int>(t) / across * kTile;
      tiles[t] = mapTile(x, rows.first + y, rows);
    });
    for (const Tile& tile : tiles) {
      if (tile.unanswered) refuse(*tile.unanswered);
      result_.figures.add(tile.figures);
      result_.covered += tile.covered;
      result_.moved += tile.moved;
    }
  }

  // Of the texels from (left, top) on.
  Tile mapTile(int left, int top, const Rows& rows) {
    static const std::array<std::uint16_t, kTile* kTile> order = tileOrder();
    std::vector<Shot> shots;
    std::vector<std::size_t> texels;
    std::vector<float> coverages;
    for (const std::uint16_t place : order) {
      const int x = left + place % kTile, y = top + place / kTile;
      if (x >= maps_.width() || y >= rows.first + rows.count) continue;
      const float* map =
          &rows.values[kMapChannels * (static_cast<std::size_t>(y - rows.first) * maps_.width() + x)];
      if (map[kCoverage] == 0) continue;
      texels.push_back(static_cast<std::size_t>(y) * maps_.width() + x);
      coverages.push_back(map[kCoverage]);
      shots.push_back({{map[kPosition], map[kPosition + 1], map[kPosition + 2]},
                       {map[kNormal], map[kNormal + 1], map[kNormal + 2]},
                       materialOf(map[kTriangle], texels.back()),
                       map[kCoverage] != kBorder});
    }
    std::vector<std::uint32_t> vertices(shots.size());
    Tile tile;
    tile.figures = shooting_.shoot(shots, vertices);
    for (std::size_t i = 0; i < tile.figures.shots; ++i) {
      if (vertices[i] != NormalShooting::kNone) {
        write(texels[i], vertices[i], coverages[i]);
        ++tile.covered;
      } else if (shots[i].required) {
        tile.unanswered = texels[i];
      } else {
        ++tile.moved;
      }
    }
    return tile;
  }

  std::optional<std::uint32_t> materialOf(float triangle, std::size_t texel) const {
    if (options_.triangle_materials.empty()) return {};
    const auto t = static_cast<std::size_t>(std::max(triangle, 0.0F));
    if (t >= options_.triangle_materials.size())
      throw badInput(
          {file_, texelName(texel), ""}, "it names triangle " + std::to_string(t),
          "one of the " + std::to_string(options_.triangle_materials.size()) + " triangles of the mesh",
          "give the mesh that the maps were made of");
    return options_.triangle_materials[t];
  }

  void write(std::size_t texel, std::uint32_t vertex, float coverage) {
    std::uint32_t* id = &result_.image.values[texel * kIdChannels];
    id[kPatchU] = patchStep(meso_.patch[vertex][0]);
    id[kPatchV] = patchStep(meso_.patch[vertex][1]);
    id[kMaterial] = meso_.surface.materials.empty() ? 0 : meso_.surface.materials[vertex];
    id[kVertex] = vertex;
    id[kIdCoverage] = static_cast<std::uint32_t>(coverage);
    found_[texel] = 1;
  }

  std::string texelName(std::size_t texel) const {
    const auto width = static_cast<std::size_t>(maps_.width());
    return "texel (" + std::to_string(texel % width) + ", " + std::to_string(texel / width) + ")";
  }

  [[noreturn]] void refuse(std::size_t texel) const {
    throw badInput({file_, texelName(texel), ""}, "no vertex of the meso-mesh near it faces the same way",
                   "a meso-mesh of the surface that the maps are of, with normals to the same side",
                   "make both from one mesh");
  }

  // Copies: an average of two indices is a third one.
  void fill() {
    if (result_.covered == 0)
      throw badInput({file_, "channel coverage", ""}, "no texel is covered", "one at least");
    const std::vector<std::uint32_t> nearest =
        transport::nearestTexels(found_, result_.image.width, result_.image.height);
    std::vector<std::uint32_t>& values = result_.image.values;
    tbb::parallel_for(std::size_t{0}, found_.size(), [&](std::size_t texel) {
      if (found_[texel] != 0) return;
      std::copy_n(&values[nearest[texel] * kIdChannels], kIdCoverage, &values[texel * kIdChannels]);
    });
    result_.filled = static_cast<std::int64_t>(found_.size()) - result_.covered;
  }

  const MesoIndex& meso_;
  const IdMapOptions& options_;
  std::string file_;
  formats::ExrRows maps_;
  NormalShooting shooting_;
  IdMap result_;
  std::vector<std::uint8_t> found_;
};

}  // namespace

std::string warningOf(const IdMap& map, const formats::TriangleMesh& meso) {
  constexpr double kUsualShare = 0.02;  // what simplification takes away is some thousandths at most
  formats::Float3 low = meso.positions.at(0), high = low;
  for (const formats::Float3& p : meso.positions)
    for (std::size_t c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
  const double diagonal = std::sqrt(squaredDistance(low, high));
  const double offset = map.figures.offset_sum / static_cast<double>(map.covered);
  // A mesh of few vertices has none near.
  const double spacing = diagonal / std::sqrt(static_cast<double>(meso.vertexCount()));
  if (offset <= kUsualShare * diagonal + spacing) return "";
  return "texels lie " + std::to_string(offset) +
         " from the vertices that they take, where the meso-mesh is " + std::to_string(diagonal) +
         " large: the maps are hardly of its surface";
}

std::size_t rowsOf(const std::filesystem::path& maps) {
  return static_cast<std::size_t>(formats::ExrRows(maps, {}).height());
}

IdMap makeIdMap(const MesoIndex& meso, const std::filesystem::path& maps, const IdMapOptions& options,
                const std::function<void(std::size_t)>& progress) {
  return Mapper(meso, maps, options).make(progress);
}

}  // namespace bakelight::idmap
