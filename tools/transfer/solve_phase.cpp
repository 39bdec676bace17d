#include "tools/transfer/solve_phase.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

#include "tools/transfer/buried.h"
#include "tools/transfer/matrices.h"
#include "tools/transfer/outliers.h"
#include "tools/transfer/sample_phase.h"
#include "tools/transfer/stopwatch.h"

namespace bakelight::transfer {

namespace {

// One a thread.
using Workspaces = tbb::enumerable_thread_specific<ShadowPass::Workspace>;

Workspaces workspacesOf(const BakeSetup& setup) {
  return Workspaces([&setup] { return ShadowPass::Workspace(*setup.pass); });
}

void addUp(std::span<const PointFigures> figures, Transfer& result) {
  for (const PointFigures& point : figures) {
    result.buried_vertices += point.buried ? 1 : 0;
    result.rays += point.rays;
    result.blocked_rays += point.blocked;
    result.inside_hits += point.inside_hits;
    result.fully_blocked_vertices += point.rays > 0 && point.blocked == point.rays ? 1 : 0;
    result.quadrature_error = std::max<double>(result.quadrature_error, point.quadrature_error);
  }
}

AreaTransfers resample(const BakeSetup& setup, std::span<const std::uint8_t> buried, TracedPoints& fronts,
                       Transfer& result) {
  Workspaces workspaces = workspacesOf(setup);
  Resampling resampling =
      resampleOutliers(setup.mesh, *setup.pass, setup.sides_from_behind, buried,
                       surfaceOffset(setup.mesh, setup.options.bias), kResamplingShare, fronts.rows(),
                       fronts.seen, [&]() -> ShadowPass::Workspace& { return workspaces.local(); });
  result.outlying_vertices = resampling.outlying;
  result.resampled_vertices = resampling.replaced.size();
  return std::move(resampling.replaced);
}

// Coefficients that served for judging only.
void dropJudgedBands(std::size_t coefficients, TracedPoints& fronts) {
  const std::size_t size = fronts.sizes.vector, count = fronts.figures.size();
  if (size == coefficients) return;
  for (std::size_t v = 1; v < count; ++v)
    std::copy_n(&fronts.vectors[v * size], coefficients, &fronts.vectors[v * coefficients]);
  fronts.vectors.resize(count * coefficients);
  fronts.sizes.vector = coefficients;
}

// Fronts of all vertices, then the backs that are seen.
struct BouncePoints {
  std::vector<std::uint32_t> row_of_side;  // kDarkSide for backs that are not
  std::vector<Float3> albedo;
};

// Backs that samples may see.
std::vector<std::uint32_t> allBacks(const BakeSetup& setup) {
  const auto vertex_count = static_cast<std::uint32_t>(setup.vertexCount());
  std::vector<std::uint32_t> backs;
  for (const formats::Triangle& sides : setup.sides_from_behind)
    for (const std::uint32_t side : sides)
      if (side != kDarkSide && side >= vertex_count) backs.push_back(side);
  std::sort(backs.begin(), backs.end());
  backs.erase(std::unique(backs.begin(), backs.end()), backs.end());
  return backs;
}

// Traces the back sides that are seen, and those that these see, until no new one turns up.
BouncePoints addSeenBacks(const BakeSetup& setup, TracedPoints& points) {
  const auto vertex_count = static_cast<std::uint32_t>(setup.vertexCount());
  BouncePoints all{std::vector<std::uint32_t>(2 * setup.vertexCount(), kDarkSide), setup.albedo};
  std::iota(all.row_of_side.begin(), all.row_of_side.begin() + vertex_count, 0U);
  for (std::size_t first = 0; first < points.seen.blockCount();) {
    std::vector<std::uint32_t> wanted;
    const auto want = [&](std::uint32_t side) {
      if (all.row_of_side[side] != kDarkSide) return;
      all.row_of_side[side] = 0;
      wanted.push_back(side - vertex_count);
    };
    if (first == 0 && setup.fitted())
      for (const std::uint32_t side : allBacks(setup)) want(side);
    for (std::size_t b = first; b < points.seen.blockCount(); ++b)
      for (const std::uint32_t side : points.seen.block(b).columns) want(side);
    first = points.seen.blockCount();
    std::sort(wanted.begin(), wanted.end());
    std::vector<SurfacePoint> backs;
    for (const std::uint32_t vertex : wanted) {
      all.row_of_side[vertex + vertex_count] =
          static_cast<std::uint32_t>(points.figures.size() + backs.size());
      backs.push_back(backPoint(setup.mesh, setup.fronts[vertex], vertex));
      all.albedo.push_back(Float3(setup.albedo[vertex]));
    }
    if (!backs.empty()) points.append(traceBacks(setup, backs));
  }
  return all;
}

// Columns of the equations: sets (distant, near) × channels blocks of the coefficients of a vector. Blocks
// don't know of each other, so as many are solved at once as there is memory for.
class BlockSolver {
 public:
  BlockSolver(const BakeSetup& setup, const TracedPoints& points, const BouncePoints& bounce,
              const transport::BuriedFill& fill, Transfer& result)
      : setup_(setup),
        points_(points),
        bounce_(bounce),
        fill_(fill),
        result_(result),
        channels_(static_cast<std::size_t>(setup.channels)),
        blocks_((setup.sphere ? 2 : 1) * channels_) {}

  // Exit radiance, if it is wanted: of distant light, and of near light, too, for samples.
  std::optional<transport::TransferField> solve(bool exit_wanted) {
    const std::size_t rows = points_.figures.size();
    std::optional<transport::TransferField> exit;
    if (exit_wanted) exit.emplace(rows, (setup_.fitted() ? blocks_ : channels_) * setup_.coefficients);
    const std::size_t room = roomForFields(setup_, rows, points_.seen.bytes());
    const std::size_t at_once = blocksAtOnce(rows, room);
    for (std::size_t first = 0; first < blocks_; first += at_once) {
      solveBlocks(first, std::min(first + at_once, blocks_), room, exit);
      result_.interreflection_parts += 1;
    }
    return exit;
  }

 private:
  std::size_t blocksAtOnce(std::size_t rows, std::size_t room) const {
    for (std::size_t parts = 1; parts < blocks_; ++parts) {
      const std::size_t blocks = (blocks_ + parts - 1) / parts;
      if (kLeastFields * fieldBytes(rows, blocks * setup_.coefficients) <= room) return blocks;
    }
    return 1;
  }

  void solveBlocks(std::size_t first, std::size_t end, std::size_t room,
                   std::optional<transport::TransferField>& exit) {
    const std::size_t size = setup_.coefficients;
    std::vector<std::uint8_t> channel_of_column;
    for (std::size_t column = first * size; column < end * size; ++column)
      channel_of_column.push_back(static_cast<std::uint8_t>(column / size % channels_));
    transport::TransferField field(points_.figures.size(), channel_of_column.size());
    transport::InterreflectionOptions options = setup_.options.interreflection;
    options.field_bytes = room;
    const transport::InterreflectionReport report = transport::solveInterreflection(
        points_.seen, bounce_.albedo, channel_of_column, fill_, options,
        [&](transport::TransferField& direct) { putDirect(first, end, direct); }, field);
    result_.interreflection = first == 0 ? report : together(result_.interreflection, report);
    for (std::size_t block = first; block < end; ++block)
      takeBlock(field, block, (block - first) * size, exit);
  }

  void putDirect(std::size_t first, std::size_t end, transport::TransferField& field) const {
    const std::size_t size = setup_.coefficients;
    for (std::size_t p = 0; p < field.pointCount(); ++p) {
      const auto row = field.row(p);
      if (points_.figures[p].buried) {
        std::fill(row.begin(), row.end(), 0.0F);
        continue;
      }
      for (std::size_t block = first; block < end; ++block) {
        const std::vector<float>& table = block < channels_ ? points_.vectors : points_.near_vectors;
        std::copy_n(&table[p * size], size,
                    row.begin() + static_cast<std::ptrdiff_t>((block - first) * size));
      }
    }
  }

  void takeBlock(const transport::TransferField& field, std::size_t block, std::size_t column,
                 std::optional<transport::TransferField>& exit) {
    const std::size_t size = setup_.coefficients, channel = block % channels_, width = channels_ * size;
    std::vector<float>& table = block < channels_ ? result_.vectors : result_.near_vectors;
    table.resize(setup_.vertexCount() * width);
    for (std::size_t v = 0; v < setup_.vertexCount(); ++v)
      std::copy_n(&field.row(v)[column], size, &table[v * width + channel * size]);
    if (!exit || (block + 1) * size > exit->columns) return;
    for (std::size_t p = 0; p < field.pointCount(); ++p)
      for (std::size_t i = 0; i < size; ++i)
        exit->row(p)[block * size + i] = field.row(p)[column + i] * bounce_.albedo[p][channel];
  }

  const BakeSetup& setup_;
  const TracedPoints& points_;
  const BouncePoints& bounce_;
  const transport::BuriedFill& fill_;
  Transfer& result_;
  std::size_t channels_, blocks_;
};

struct BouncedLight {
  BouncePoints points;
  std::optional<transport::TransferField> exit;  // for matrices and samples
};

BouncedLight bounce(BakeSetup& setup, TracedPoints& points, const transport::BuriedFill& fill,
                    Transfer& result) {
  const Stopwatch watch;
  BouncedLight bounced{addSeenBacks(setup, points), std::nullopt};
  points.seen.renumber(bounced.points.row_of_side);
  result.back_points = points.figures.size() - setup.vertexCount();
  result.form_factors = points.seen.shareCount();
  result.form_factor_bytes = points.seen.bytes();
  const bool exit_wanted = setup.needsMatrices() || setup.fitted();
  // The tree makes place for the fields.
  if (!exit_wanted) {
    setup.pass.reset(), setup.scene.reset();
    setup.fronts = {}, setup.sides_from_behind = {};
  }
  BlockSolver solver(setup, points, bounced.points, fill, result);
  bounced.exit = solver.solve(exit_wanted);
  points.seen = transport::FormFactors();
  result.interreflection_s = watch.seconds();
  return bounced;
}

// Matrices of all vertices, from their visibility and what bounced.
class MatrixPhase {
 public:
  MatrixPhase(const BakeSetup& setup, const TracedPoints& points, const AreaTransfers& areas,
              const BouncedLight& bounced)
      : setup_(setup),
        points_(points),
        areas_(areas),
        bounced_(bounced),
        baker_(setup.options.row_order, setup.options.order),
        workspaces_(workspacesOf(setup)),
        channels_(static_cast<std::size_t>(setup.channels)) {}

  std::vector<float> bake(const transport::BuriedFill& fill, std::span<const formats::Float4> tangents) {
    const std::size_t width = channels_ * setup_.matrixSize();
    std::vector<float> matrices(setup_.vertexCount() * width);
    tbb::parallel_for(std::size_t{0}, setup_.vertexCount(), [&](std::size_t v) {
      const auto own = std::span(matrices).subspan(v * width, width);
      const auto visibility =
          std::span(points_.visibility).subspan(v * setup_.visibility_size, setup_.visibility_size);
      baker_.fromVisibility(visibility, own.first(setup_.matrixSize()));
      for (std::size_t c = 1; c < channels_; ++c)
        std::copy_n(own.begin(), setup_.matrixSize(),
                    own.begin() + static_cast<std::ptrdiff_t>(c * setup_.matrixSize()));
      if (bounced_.exit && !points_.figures[v].buried) addBounces(static_cast<std::uint32_t>(v), own);
    });
    // Neighbours lend buried vertices what they have in the object's frame, before each turns to its own.
    fill.apply(matrices, width);
    tbb::parallel_for(std::size_t{0}, setup_.vertexCount(), [&](std::size_t v) {
      const Eigen::Matrix3d local = localFromObject(setup_.mesh.normals[v], tangents[v]);
      for (std::size_t c = 0; c < channels_; ++c)
        baker_.turnRows(
            local, std::span(matrices).subspan(v * width + c * setup_.matrixSize(), setup_.matrixSize()));
    });
    return matrices;
  }

 private:
  void addBounces(std::uint32_t vertex, std::span<float> matrices) {
    const auto add = [&](const SurfacePoint& point, const std::vector<bool>& blocked_rays, double share) {
      addBouncedLight(*setup_.pass, point, blocked_rays, *bounced_.exit, setup_.sides_from_behind,
                      bounced_.points.row_of_side, setup_.channels, setup_.options.row_order,
                      setup_.options.order, share, workspaces_.local(), matrices);
    };
    const auto area = areas_.find(vertex);
    if (area == areas_.end()) return add(setup_.fronts[vertex], points_.blocked_rays[vertex], 1);
    const std::vector<SurfacePoint>& points = area->second.points;
    for (std::size_t i = 0; i < points.size(); ++i)
      add(points[i], area->second.blocked_rays[i], 1.0 / static_cast<double>(points.size()));
  }

  const BakeSetup& setup_;
  const TracedPoints& points_;
  const AreaTransfers& areas_;
  const BouncedLight& bounced_;
  const MatrixBaker baker_;
  Workspaces workspaces_;
  std::size_t channels_;
};

}  // namespace

Transfer solve(BakeSetup setup, TracedPoints points, stage::Progress* progress) {
  Transfer result;
  result.channels = setup.channels;
  if (setup.sphere) result.sphere = *setup.sphere;
  addUp(points.figures, result);
  std::vector<std::uint8_t> buried;
  for (const PointFigures& point : points.figures) buried.push_back(point.buried ? 1 : 0);
  const Stopwatch watch;
  const AreaTransfers areas = resample(setup, buried, points, result);
  result.shadow_s = watch.seconds();
  dropJudgedBands(setup.coefficients, points);
  const transport::BuriedFill fill(setup.mesh, buried);
  result.filled_vertices = fill.filledVertices();

  BouncedLight bounced;
  if (setup.interreflected()) {
    bounced = bounce(setup, points, fill, result);
  } else {
    result.vectors = std::move(points.vectors);
    result.near_vectors = std::move(points.near_vectors);
  }
  const std::size_t width = static_cast<std::size_t>(setup.channels) * setup.coefficients;
  fill.apply(result.vectors, width);
  if (setup.sphere) fill.apply(result.near_vectors, width);
  if (setup.fitted())
    fitToSamples(setup, bounced.exit ? &*bounced.exit : nullptr, bounced.points.row_of_side, result,
                 progress);
  if (setup.options.glossy == Glossy::kNone) return result;

  fill.apply(points.visibility, setup.visibility_size);
  result.tangents = setup.tangents();
  if (setup.needsMatrices()) {
    const Stopwatch matrix_watch;
    result.matrices = MatrixPhase(setup, points, areas, bounced).bake(fill, result.tangents);
    result.matrices_s = matrix_watch.seconds();
  } else {
    result.visibility = std::move(points.visibility);
  }
  return result;
}

}  // namespace bakelight::transfer
