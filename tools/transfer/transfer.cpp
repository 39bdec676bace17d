#include "tools/transfer/transfer.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <numbers>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "formats/error.h"
#include "tools/transfer/area_transfer.h"
#include "tools/transfer/buried.h"
#include "tools/transfer/matrices.h"
#include "tools/transfer/outliers.h"
#include "tools/transfer/shadow_pass.h"
#include "tools/transfer/surface_points.h"
#include "transport/camera.h"
#include "transport/sh.h"

namespace bakelight::transfer {

using formats::Float3;
using formats::TriangleMesh;
using transport::coefficientCount;
using transport::Vec3;
using transport::vec3;

namespace {

constexpr std::size_t kPointsPerTask = 64;
using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

bool isGray(const Float3& color) {
  return color[0] == color[1] && color[1] == color[2];
}

// One a thread.
using Workspaces = tbb::enumerable_thread_specific<ShadowPass::Workspace>;

// What the several passes of one bake share.
class Baker {
 public:
  Baker(const TriangleMesh& mesh, std::span<const Float3> albedo, const TransferOptions& options,
        stage::Progress& progress)
      : mesh_(mesh),
        options_(options),
        progress_(progress),
        vertex_count_(mesh.vertexCount()),
        coefficients_(coefficientCount(options.order)),
        albedo_(albedo.begin(), albedo.end()),
        points_(frontPoints(mesh, options.bias)) {
    if (albedo_.empty()) albedo_.assign(1, {1, 1, 1});
    if (albedo_.size() == 1) albedo_.assign(vertex_count_, Float3(albedo_.front()));
    const bool interreflected = options.transport == Transport::kInterreflected;
    if (albedo_.size() != vertex_count_)
      throw std::invalid_argument("one albedo, or one a vertex, is needed");
    if (interreflected && options.glossy == Glossy::kVisibility)
      throw std::invalid_argument("a visibility vector cannot hold interreflection");
    if (options.sphere_radius != 0 && options.sphere_radius <= 1)
      throw std::invalid_argument("the virtual sphere must enclose the object");
    result_.channels = interreflected && !std::all_of(albedo_.begin(), albedo_.end(), isGray) ? 3 : 1;
    if (options.sphere_radius > 0) {
      const transport::BoundingSphere bounds = transport::boundingSphere(mesh);
      if (bounds.radius == 0)
        throw badInput({"", "mesh", "/near_field"},
                       "the mesh has no extent, so no virtual sphere is around it",
                       "vertices at two places or more", "leave near_field out");
      result_.sphere = {bounds.center, options.sphere_radius * bounds.radius};
    }
  }

  Transfer bake() {
    if (options_.transport == Transport::kUnshadowed) {
      bakeUnshadowed();
    } else {
      const transport::RayScene scene(mesh_);
      const bool interreflected = options_.transport == Transport::kInterreflected;
      const ShadowOptions shadow{options_.order, visibilityOrder(), sphere(), interreflected,
                                 interreflected && options_.glossy == Glossy::kMatrices};
      const ShadowPass pass(mesh_, scene, shadow, options_.directions);
      Workspaces workspaces([&] { return ShadowPass::Workspace(pass); });
      const auto start = Clock::now();
      traceFronts(pass, workspaces);
      result_.shadow_s = secondsSince(start);
      if (interreflected) bounce(pass, workspaces);
      finishVectors();
      if (options_.glossy == Glossy::kMatrices) bakeMatrices(pass, workspaces);
    }
    if (options_.glossy != Glossy::kNone) result_.tangents = vertexTangents(mesh_);
    return std::move(result_);
  }

 private:
  std::optional<VirtualSphere> sphere() const {
    return options_.sphere_radius > 0 ? std::optional(result_.sphere) : std::nullopt;
  }
  int visibilityOrder() const {
    return options_.glossy == Glossy::kNone ? 0 : options_.row_order + options_.order - 1;
  }
  std::size_t visibilitySize() const { return coefficientCount(visibilityOrder()); }
  std::size_t matrixSize() const { return coefficientCount(options_.row_order) * coefficients_; }

  // Runs body(point index, workspace) over [first, points_.size()).
  template <class Body>
  void forPoints(Workspaces& workspaces, std::size_t first, const Body& body) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(first, points_.size(), kPointsPerTask),
                      [&](const auto& range) {
                        ShadowPass::Workspace& work = workspaces.local();
                        for (std::size_t p = range.begin(); p < range.end(); ++p) body(p, work);
                        if (range.begin() < vertex_count_) progress_.advance(range.size());
                      });
  }

  // With vectors of this size.
  TransferRows rowsOf(std::size_t vector_size) {
    return {result_.vectors,
            result_.near_vectors,
            result_.visibility,
            {vector_size, sphere() ? coefficients_ : 0, visibilitySize()}};
  }

  // Traces points_ from `first` on; grows the tables to hold them, with rows of `vector_size` in
  // result_.vectors.
  void tracePoints(const ShadowPass& pass, Workspaces& workspaces, std::size_t first,
                   std::size_t vector_size) {
    result_.vectors.resize(points_.size() * vector_size);
    if (sphere()) result_.near_vectors.resize(points_.size() * coefficients_);
    result_.visibility.resize(points_.size() * visibilitySize());
    figures_.resize(points_.size());
    const TransferRows rows = rowsOf(vector_size);
    forPoints(workspaces, first, [&](std::size_t p, ShadowPass::Workspace& work) {
      figures_[p] = pass.trace(points_[p], sides_from_behind_, rows.of(p), work);
    });
  }

  void traceFronts(const ShadowPass& pass, Workspaces& workspaces) {
    sides_from_behind_ = sidesFromBehind(mesh_);
    tracePoints(pass, workspaces, 0, judgedSize());
    std::vector<std::uint8_t> buried;
    for (const PointFigures& point : figures_) {
      buried.push_back(point.buried ? 1 : 0);
      result_.buried_vertices += point.buried ? 1 : 0;
      result_.rays += point.rays;
      result_.blocked_rays += point.blocked;
      result_.inside_hits += point.inside_hits;
      result_.fully_blocked_vertices += point.rays > 0 && point.blocked == point.rays ? 1 : 0;
      result_.quadrature_error = std::max<double>(result_.quadrature_error, point.quadrature_error);
    }
    Resampling resampling = resampleOutliers(
        mesh_, pass, sides_from_behind_, buried, surfaceOffset(mesh_, options_.bias), kResamplingShare,
        rowsOf(judgedSize()), figures_, [&]() -> ShadowPass::Workspace& { return workspaces.local(); });
    result_.outlying_vertices = resampling.outlying;
    result_.resampled_vertices = resampling.replaced.size();
    areas_ = std::move(resampling.replaced);
    dropJudgedBands();
    fill_ = BuriedFill(mesh_, buried);
    result_.filled_vertices = fill_.filledVertices();
  }

  // Coefficients of a vector while outliers are looked for.
  std::size_t judgedSize() const {
    return std::max<std::size_t>(coefficients_, coefficientCount(kJudgedOrder));
  }
  void dropJudgedBands() {
    const std::size_t size = judgedSize();
    if (size == coefficients_) return;
    for (std::size_t v = 1; v < vertex_count_; ++v)
      std::copy_n(&result_.vectors[v * size], coefficients_, &result_.vectors[v * coefficients_]);
    result_.vectors.resize(vertex_count_ * coefficients_);
  }

  // Traces the back sides that are seen, and those that these see, until no new one turns up.
  void traceBacks(const ShadowPass& pass, Workspaces& workspaces) {
    row_of_side_.assign(2 * vertex_count_, kDarkSide);
    std::iota(row_of_side_.begin(), row_of_side_.begin() + static_cast<std::ptrdiff_t>(vertex_count_), 0u);
    for (std::size_t first = 0; first < points_.size();) {
      std::vector<std::uint32_t> wanted;
      for (std::size_t p = first; p < points_.size(); ++p)
        for (const SeenVertex& seen : figures_[p].seen)
          if (row_of_side_[seen.side] == kDarkSide)
            row_of_side_[seen.side] = 0,
            wanted.push_back(seen.side - static_cast<std::uint32_t>(vertex_count_));
      std::sort(wanted.begin(), wanted.end());
      first = points_.size();
      for (const std::uint32_t vertex : wanted) {
        row_of_side_[vertex + vertex_count_] = static_cast<std::uint32_t>(points_.size());
        points_.push_back(backPoint(mesh_, points_[vertex], vertex));
        albedo_.push_back(Float3(albedo_[vertex]));
      }
      if (!wanted.empty()) tracePoints(pass, workspaces, first, coefficients_);
    }
    result_.back_points = points_.size() - vertex_count_;
  }

  FormFactors formFactors() {
    FormFactors factors;
    std::size_t count = 0;
    for (const PointFigures& point : figures_) count += point.seen.size();
    factors.columns.reserve(count);
    factors.weights.reserve(count);
    for (PointFigures& point : figures_) {
      for (const SeenVertex& seen : point.seen) {
        factors.columns.push_back(row_of_side_[seen.side]);
        factors.weights.push_back(seen.weight);
      }
      factors.row_begin.push_back(factors.columns.size());
      point.seen = {};
    }
    result_.form_factors = factors.columns.size();
    return factors;
  }

  // x0 of the interreflection: the direct vectors once a channel, then the near-field ones.
  TransferField directField(std::vector<std::uint8_t>& channel_of_column) const {
    const std::size_t sets = result_.near_vectors.empty() ? 1 : 2;
    const auto channels = static_cast<std::size_t>(result_.channels);
    TransferField field(points_.size(), sets * channels * coefficients_);
    for (std::size_t p = 0; p < points_.size(); ++p) {
      if (figures_[p].buried) continue;
      for (std::size_t block = 0; block < sets * channels; ++block) {
        const std::vector<float>& table = block < channels ? result_.vectors : result_.near_vectors;
        std::copy_n(&table[p * coefficients_], coefficients_, field.row(p).begin() + block * coefficients_);
      }
    }
    for (std::size_t column = 0; column < field.columns; ++column)
      channel_of_column.push_back(static_cast<std::uint8_t>(column / coefficients_ % channels));
    return field;
  }

  void bounce(const ShadowPass& pass, Workspaces& workspaces) {
    const auto start = Clock::now();
    traceBacks(pass, workspaces);
    const FormFactors factors = formFactors();
    std::vector<std::uint8_t> channel_of_column;
    TransferField field = directField(channel_of_column);
    result_.interreflection =
        solveInterreflection(factors, albedo_, channel_of_column, fill_, options_.interreflection, field);

    const std::size_t width = result_.channels * coefficients_;
    result_.vectors.resize(vertex_count_ * width);
    if (sphere()) result_.near_vectors.resize(vertex_count_ * width);
    for (std::size_t v = 0; v < vertex_count_; ++v) {
      const auto row = field.row(v);
      std::copy_n(row.begin(), width, &result_.vectors[v * width]);
      if (sphere()) std::copy_n(row.begin() + width, width, &result_.near_vectors[v * width]);
    }
    // From here on the field is exit radiance, for the matrices.
    for (std::size_t p = 0; p < field.pointCount(); ++p)
      for (std::size_t c = 0; c < field.columns; ++c) field.row(p)[c] *= albedo_[p][channel_of_column[c]];
    exit_ = std::move(field);
    result_.interreflection_s = secondsSince(start);
  }

  void finishVectors() {
    const std::size_t width = result_.channels * coefficients_;
    result_.vectors.resize(vertex_count_ * width);
    result_.visibility.resize(vertex_count_ * visibilitySize());
    fill_.apply(result_.vectors, width);
    if (sphere()) fill_.apply(result_.near_vectors, width);
    if (options_.glossy != Glossy::kNone) fill_.apply(result_.visibility, visibilitySize());
  }

  void bakeMatrices(const ShadowPass& pass, Workspaces& workspaces) {
    const auto start = Clock::now();
    const MatrixBaker baker(options_.row_order, options_.order);
    const std::vector<formats::Float4> tangents = vertexTangents(mesh_);
    const std::size_t size = matrixSize(), width = result_.channels * size;
    result_.matrices.resize(vertex_count_ * width);
    points_.resize(vertex_count_);
    const auto channel = [&](std::size_t v, int c) {
      return std::span(result_.matrices).subspan(v * width + c * size, size);
    };
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertex_count_, kPointsPerTask),
                      [&](const auto& range) {
                        for (std::size_t v = range.begin(); v < range.end(); ++v) {
                          for (int c = 0; c < result_.channels; ++c)
                            baker.fromVisibility(
                                std::span(result_.visibility).subspan(v * visibilitySize(), visibilitySize()),
                                channel(v, c));
                          if (exit_ && !figures_[v].buried)
                            addBounces(pass, static_cast<std::uint32_t>(v), workspaces.local(),
                                       std::span(result_.matrices).subspan(v * width, width));
                        }
                      });
    // Neighbours lend buried vertices what they have in the object's frame, before each turns to its own.
    fill_.apply(result_.matrices, width);
    turnMatrices(baker, tangents);
    result_.visibility.clear();
    result_.matrices_s = secondsSince(start);
  }

  void addBounces(const ShadowPass& pass, std::uint32_t vertex, ShadowPass::Workspace& work,
                  std::span<float> matrices) const {
    const auto add = [&](const SurfacePoint& point, const std::vector<bool>& blocked_rays, double share) {
      addBouncedLight(pass, point, blocked_rays, *exit_, sides_from_behind_, row_of_side_, result_.channels,
                      options_.row_order, options_.order, share, work, matrices);
    };
    const auto area = areas_.find(vertex);
    if (area == areas_.end()) return add(points_[vertex], figures_[vertex].blocked_rays, 1);
    const std::vector<SurfacePoint>& points = area->second.points;
    for (std::size_t i = 0; i < points.size(); ++i)
      add(points[i], area->second.blocked_rays[i], 1.0 / static_cast<double>(points.size()));
  }

  void turnMatrices(const MatrixBaker& baker, std::span<const formats::Float4> tangents) {
    tbb::parallel_for(std::size_t{0}, vertex_count_, [&](std::size_t v) {
      const Eigen::Matrix3d local = localFromObject(mesh_.normals[v], tangents[v]);
      for (int c = 0; c < result_.channels; ++c)
        baker.turnRows(
            local,
            std::span(result_.matrices).subspan((v * result_.channels + c) * matrixSize(), matrixSize()));
    });
  }

  void bakeUnshadowed() {
    const std::vector<double> factors = transport::clampedCosineFactors(options_.order);
    result_.vectors.resize(vertex_count_ * coefficients_);
    if (options_.glossy != Glossy::kNone) unshadowedVisibility();
    if (sphere()) result_.near_vectors.resize(vertex_count_ * coefficients_);
    const Quadrature quadrature(options_.order, sphere() ? options_.directions : 1);
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, vertex_count_, kPointsPerTask), [&](const auto& range) {
          Hemisphere hemisphere(quadrature.size());
          std::vector<double> difference(coefficients_);
          for (std::size_t v = range.begin(); v < range.end(); ++v) {
            const std::vector<double> basis = transport::evaluateSh(options_.order, vec3(mesh_.normals[v]));
            float* vector = &result_.vectors[v * coefficients_];
            for (int l = 0; l < options_.order; ++l)
              for (int i = l * l; i < (l + 1) * (l + 1); ++i)
                vector[i] = static_cast<float>(factors[l] / std::numbers::pi * basis[i]);
            if (!sphere()) continue;
            hemisphere.collect(quadrature, mesh_.normals[v]);
            nearFieldDifference(result_.sphere, vec3(mesh_.positions[v]), options_.order, quadrature,
                                hemisphere.usedDirections(), hemisphere.usedCosines(), difference);
            for (std::size_t i = 0; i < coefficients_; ++i)
              result_.near_vectors[v * coefficients_ + i] = static_cast<float>(vector[i] + difference[i]);
          }
          progress_.advance(range.size());
        });
  }

  void unshadowedVisibility() {
    const std::vector<double> zonal = transport::diskLightZonal(visibilityOrder(), std::numbers::pi / 2);
    result_.visibility.resize(vertex_count_ * visibilitySize());
    tbb::parallel_for(std::size_t{0}, vertex_count_, [&](std::size_t v) {
      const std::vector<double> hemisphere =
          transport::orientZonal(zonal, vec3(mesh_.normals[v]).normalized());
      std::copy(hemisphere.begin(), hemisphere.end(), &result_.visibility[v * visibilitySize()]);
    });
    if (options_.glossy == Glossy::kVisibility) return;
    const MatrixBaker baker(options_.row_order, options_.order);
    result_.matrices.resize(vertex_count_ * matrixSize());
    tbb::parallel_for(std::size_t{0}, vertex_count_, [&](std::size_t v) {
      baker.fromVisibility(std::span(result_.visibility).subspan(v * visibilitySize(), visibilitySize()),
                           std::span(result_.matrices).subspan(v * matrixSize(), matrixSize()));
    });
    turnMatrices(baker, vertexTangents(mesh_));
    result_.visibility.clear();
  }

  const TriangleMesh& mesh_;
  const TransferOptions& options_;
  stage::Progress& progress_;
  std::size_t vertex_count_, coefficients_;
  std::vector<Float3> albedo_;        // of each point
  std::vector<SurfacePoint> points_;  // fronts of all vertices, then backs
  std::vector<formats::Triangle> sides_from_behind_;
  std::vector<PointFigures> figures_;
  std::vector<std::uint32_t> row_of_side_;
  AreaTransfers areas_;
  BuriedFill fill_;
  std::optional<TransferField> exit_;
  Transfer result_;
};

}  // namespace

Transfer bakeTransfer(const TriangleMesh& mesh, std::span<const Float3> albedo,
                      const TransferOptions& options, stage::Progress& progress) {
  return Baker(mesh, albedo, options, progress).bake();
}

}  // namespace bakelight::transfer
