#include "tools/transfer/pixel_transfer.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "tools/transfer/buried.h"
#include "transport/cube_map.h"
#include "transport/hemisphere_grid.h"
#include "transport/morton.h"
#include "transport/multiversioned.h"

namespace bakelight::transfer {

using formats::Float4;
using formats::TriangleMesh;
using transport::float3;
using transport::Vec3;
using transport::vec3;

namespace {

constexpr std::size_t kVerticesPerTask = 16;

void requireRange(int value, int greatest, const char* name) {
  if (value < 1 || value > greatest)
    throw std::invalid_argument(std::string(name) + " must be 1 to " + std::to_string(greatest));
}

// Every direction is written and the end moves on only past those above, as the branch would be mispredicted too often.
BAKELIGHT_MULTIVERSIONED std::size_t collectAbove(const transport::RayBundle& directions,
                                                  const std::uint16_t* texels, const Float3& normal,
                                                  transport::RayBundle& above, std::uint16_t* texels_above) {
  const float* const x = directions.x.data();
  const float* const y = directions.y.data();
  const float* const z = directions.z.data();
  std::size_t end = 0;
  for (std::size_t d = 0; d < directions.size(); ++d) {
    above.x[end] = x[d];
    above.y[end] = y[d];
    above.z[end] = z[d];
    texels_above[end] = texels[d];
    end += normal[0] * x[d] + normal[1] * y[d] + normal[2] * z[d] > 0 ? 1 : 0;
  }
  return end;
}

}  // namespace

void PixelFigures::add(const PixelFigures& other) {
  rays += other.rays;
  blocked_rays += other.blocked_rays;
  fully_blocked_vertices += other.fully_blocked_vertices;
  buried_vertices += other.buried_vertices;
  filled_vertices += other.filled_vertices;
}

// Those of all subsamples, face by face along Morton curves: packets of rays stay together.
struct PixelBaker::Directions {
  transport::RayBundle rays;
  std::vector<std::uint16_t> texel_of_ray;
  std::vector<Vec3> texels;  // middles

  Directions(int cube_side, int subsamples) {
    const int side = cube_side * subsamples;
    std::vector<std::array<std::uint16_t, 2>> order;
    order.reserve(static_cast<std::size_t>(side) * side);
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x)
        order.push_back({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
    std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
      return transport::mortonCode(a[0], a[1]) < transport::mortonCode(b[0], b[1]);
    });
    for (int face = 0; face < transport::kCubeFaces; ++face) {
      for (const auto& [x, y] : order) {
        rays.push(float3(transport::directionOfCubeFace(face, (x + 0.5) / side, (y + 0.5) / side)));
        texel_of_ray.push_back(
            static_cast<std::uint16_t>((face * cube_side + y / subsamples) * cube_side + x / subsamples));
      }
      for (int y = 0; y < cube_side; ++y)
        for (int x = 0; x < cube_side; ++x)
          texels.push_back(
              transport::directionOfCubeFace(face, (x + 0.5) / cube_side, (y + 0.5) / cube_side));
    }
  }
};

struct PixelBaker::Workspace {
  explicit Workspace(const Directions& directions, std::size_t cells)
      : rays(directions.rays.size()),
        texels_above(directions.rays.size()),
        blocked(directions.rays.size()),
        counts(directions.texels.size()),
        cell_of_entry(directions.texels.size()),
        entries(directions.texels.size()),
        cell_ends(cells) {}

  transport::RayBundle rays;
  std::vector<std::uint16_t> texels_above;
  std::vector<std::uint8_t> blocked;
  std::vector<std::uint8_t> counts;  // a texel: rays that pass
  std::vector<std::uint32_t> cell_of_entry;
  std::vector<std::uint16_t> entries;
  std::vector<std::uint64_t> cell_ends;
};

PixelBaker::PixelBaker(const TriangleMesh& mesh, const PixelOptions& options)
    : mesh_(mesh), options_(options) {
  requireRange(options.cube_side, formats::kMostCubeSide, "cube_side");
  requireRange(options.local_side, formats::kMostLocalSide, "local_side");
  requireRange(options.subsamples, formats::kMostSubsamples, "subsamples");
  if (mesh.normals.size() != mesh.vertexCount()) throw std::invalid_argument("the mesh has no normals");
  if (options_.tangents.empty()) options_.tangents = vertexTangents(mesh);
  if (options_.tangents.size() != mesh.vertexCount())
    throw std::invalid_argument("there must be a tangent a vertex, or none");
  directions_ = std::make_unique<const Directions>(options.cube_side, options.subsamples);
  points_ = frontPoints(mesh, options.bias);
  origins_.resize(mesh.vertexCount());
  std::iota(origins_.begin(), origins_.end(), 0U);
  buried_.assign(mesh.vertexCount(), 0);
  if (!options.shadows) return;
  scene_ = std::make_unique<const transport::RayScene>(mesh);
  findBuried();
}

PixelBaker::~PixelBaker() = default;

std::size_t PixelBaker::vertexCount() const {
  return mesh_.vertexCount();
}

std::span<const Float4> PixelBaker::tangents() const {
  return options_.tangents;
}

// A few rays tell which vertices may be buried, all of their rays whether they see no light at all.
void PixelBaker::findBuried() {
  tbb::enumerable_thread_specific<Workspace> workspaces([&] { return Workspace(*directions_, 1); });
  tbb::parallel_for(std::size_t{0}, points_.size(), [&](std::size_t v) {
    if (!isBuried(*scene_, points_[v].origin, points_[v].normal)) return;
    std::uint32_t rays = 0;
    buried_[v] = traceVisible(v, workspaces.local(), rays) == 0 && rays > 0 ? 1 : 0;
  });
  // Integers have no mean: a buried vertex sees what one of the neighbors sees that come before it from where the surface
  // comes out, in the other's place and under its own horizon.
  std::vector<std::uint8_t> open = buried_;
  if (std::find(open.begin(), open.end(), 1) == open.end()) return;
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  for (bool found = true; found;) {
    std::vector<std::uint32_t> source(mesh_.vertexCount(), kNone);
    std::vector<double> likeness(mesh_.vertexCount(), 0);
    for (const formats::Triangle& triangle : mesh_.triangles)
      for (const std::uint32_t v : triangle)
        for (const std::uint32_t neighbor : triangle) {
          if (open[v] == 0 || open[neighbor] != 0) continue;
          const double cosine = vec3(points_[v].normal).dot(vec3(points_[neighbor].normal));
          if (source[v] != kNone &&
              (cosine < likeness[v] || (cosine == likeness[v] && neighbor >= source[v])))
            continue;
          source[v] = neighbor;
          likeness[v] = cosine;
        }
    found = false;
    for (std::size_t v = 0; v < source.size(); ++v) {
      if (source[v] == kNone) continue;
      origins_[v] = origins_[source[v]];
      open[v] = 0;
      found = true;
    }
  }
}

// Counts, a texel, the rays that pass into work.counts; their sum.
std::uint32_t PixelBaker::traceVisible(std::size_t vertex, Workspace& work, std::uint32_t& rays) const {
  std::fill(work.counts.begin(), work.counts.end(), 0);
  const std::size_t count = collectAbove(directions_->rays, directions_->texel_of_ray.data(),
                                         points_[vertex].normal, work.rays, work.texels_above.data());
  rays = static_cast<std::uint32_t>(count);
  const std::span<std::uint8_t> blocked = std::span(work.blocked).first(count);
  if (scene_ != nullptr)
    scene_->occluded(points_[origins_[vertex]].origin, work.rays, 0, blocked);
  else
    std::fill(blocked.begin(), blocked.end(), 0);
  std::uint32_t passing = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto passes = static_cast<std::uint8_t>(1 - blocked[i]);
    work.counts[work.texels_above[i]] = static_cast<std::uint8_t>(work.counts[work.texels_above[i]] + passes);
    passing += passes;
  }
  return passing;
}

std::uint32_t PixelBaker::cellOf(std::size_t texel, const Eigen::Matrix3d& local_from_object) const {
  const int side = options_.local_side;
  const transport::SquarePoint place =
      transport::squareFromHemisphere(local_from_object * directions_->texels[texel]);
  const auto step = [side](double at) { return std::clamp(static_cast<int>(at * side), 0, side - 1); };
  return static_cast<std::uint32_t>(step(place.b) * side + step(place.a));
}

void PixelBaker::bakeVertex(std::size_t vertex, Workspace& work, PixelBlock& block) const {
  std::uint32_t rays = 0;
  const std::uint32_t passing = traceVisible(vertex, work, rays);
  const bool is_filled = origins_[vertex] != vertex;
  block.figures.add(
      {rays, rays - passing, passing == 0 && !is_filled ? 1U : 0U, buried_[vertex], is_filled ? 1U : 0U});

  const Eigen::Matrix3d local_from_object =
      localFromObject(points_[vertex].normal, options_.tangents[vertex]);
  std::fill(work.cell_ends.begin(), work.cell_ends.end(), 0);
  std::size_t count = 0;
  for (std::size_t texel = 0; texel < work.counts.size(); ++texel) {
    if (work.counts[texel] == 0) continue;
    const std::uint32_t cell = cellOf(texel, local_from_object);
    work.entries[count] = static_cast<std::uint16_t>(texel);
    work.cell_of_entry[count++] = cell;
    ++work.cell_ends[cell];
  }
  formats::PixelRows& rows = block.rows;
  std::uint64_t end = rows.columns.size();
  rows.columns.resize(end + count);
  rows.codes.resize(end + count);
  for (std::uint64_t& cell : work.cell_ends) {  // now where its next entry goes
    const std::uint64_t size = cell;
    cell = end;
    end += size;
    rows.row_offsets.push_back(end);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t at = work.cell_ends[work.cell_of_entry[i]]++;
    rows.columns[at] = work.entries[i];
    rows.codes[at] = work.counts[work.entries[i]];
  }
}

PixelBlock PixelBaker::bake(PointRange range, stage::Progress* progress) const {
  const std::size_t tasks = (range.size() + kVerticesPerTask - 1) / kVerticesPerTask;
  PixelBlock empty;
  empty.rows.cube_side = options_.cube_side;
  empty.rows.local_side = options_.local_side;
  empty.rows.subsamples = options_.subsamples;
  std::vector<PixelBlock> blocks(tasks, empty);
  tbb::enumerable_thread_specific<Workspace> workspaces([&] {
    return Workspace(*directions_, static_cast<std::size_t>(options_.local_side) * options_.local_side);
  });
  tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
    const std::size_t first = range.first + task * kVerticesPerTask,
                      end = std::min(first + kVerticesPerTask, range.end);
    for (std::size_t v = first; v < end; ++v) bakeVertex(v, workspaces.local(), blocks[task]);
    if (progress != nullptr) progress->advance(end - first);
  });
  PixelBlock whole = empty;
  std::size_t entries = 0;
  for (const PixelBlock& block : blocks) entries += block.rows.columns.size();
  whole.rows.columns.reserve(entries);
  whole.rows.codes.reserve(entries);
  for (PixelBlock& block : blocks) {
    whole.rows.append(block.rows);
    whole.figures.add(block.figures);
    block = {};
  }
  return whole;
}

PixelBlock bakePixelTransfer(const TriangleMesh& mesh, const PixelOptions& options) {
  return PixelBaker(mesh, options).bake({0, mesh.vertexCount()});
}

}  // namespace bakelight::transfer
