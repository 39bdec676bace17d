#include "tools/transfer/sample_phase.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "tools/transfer/stopwatch.h"
#include "transport/surface_query.h"
#include "transport/vertex_fit.h"

namespace bakelight::transfer {

namespace {

using transport::FitSample;
using transport::Vec3;
using transport::vec3;
using transport::VertexFit;

// Fixed sets of directions, in turn from sample to sample: errors of one set are like each other all over a smooth
// surface, those of different sets cancel.
constexpr std::uint32_t kTurns = 16;
constexpr int kLeastDirections = 256;
// Little enough to cost nothing (docs/NUMERICS.md), enough that no vertex is free.
constexpr double kSmoothness = 0.1;
constexpr std::size_t kTrianglesPerBlock = 1024;
// Cosine of the angle between the normals of a sample and of the original where it is looked at.
constexpr double kFacing = 0.2;
// Of what uniform light shows: limits that are passed by no more count for nothing.
constexpr double kRounding = 1e-6;

// Where samples gather light.
class SampledSurface {
 public:
  explicit SampledSurface(const BakeSetup& setup) : mesh_(setup.mesh), original_(setup.options.original) {
    const formats::TriangleMesh& traced = original_ != nullptr ? *original_ : mesh_;
    offset_ = surfaceOffset(traced, setup.options.bias);
    if (original_ != nullptr) {
      transport::SurfaceMesh surface;
      for (const Float3& position : original_->positions) surface.positions.push_back(vec3(position));
      surface.triangles = original_->triangles;
      query_.emplace(std::move(surface));
    }
    if (setup.options.transport == Transport::kUnshadowed) {
      formats::TriangleMesh nothing;
      nothing.positions = mesh_.positions;
      own_scene_.emplace(nothing);
    } else if (original_ != nullptr) {
      own_scene_.emplace(*original_);
    }
    scene_ = own_scene_ ? &*own_scene_ : setup.scene.get();
  }

  const transport::RayScene& scene() const { return *scene_; }

  // None where the original has nothing near that faces the same way.
  std::optional<SurfacePoint> at(std::uint32_t triangle, const Vec3& weights) const {
    const transport::SmoothPoint own = transport::smoothPoint(mesh_, triangle, weights[1], weights[2]);
    if (original_ == nullptr) return off(own);
    const transport::ClosestPoint foot = query_->closestFacing(own.position, own.normal);
    if (!foot.valid || foot.distance > longestEdge(triangle)) return std::nullopt;
    const transport::SmoothPoint there =
        transport::smoothPoint(*original_, foot.triangle, foot.barycentric[1], foot.barycentric[2]);
    if (there.normal.dot(own.normal) < kFacing) return std::nullopt;
    return off(there);
  }

 private:
  SurfacePoint off(const transport::SmoothPoint& point) const {
    return {transport::float3(point.lifted + offset_ * point.normal), transport::float3(point.normal)};
  }
  double longestEdge(std::uint32_t triangle) const {
    double longest = 0;
    for (std::size_t i = 0; i < 3; ++i)
      longest = std::max(longest, (vec3(mesh_.positions[mesh_.triangles[triangle][i]]) -
                                   vec3(mesh_.positions[mesh_.triangles[triangle][(i + 1) % 3]]))
                                      .norm());
    return longest;
  }

  const formats::TriangleMesh& mesh_;
  const formats::TriangleMesh* original_;
  float offset_ = 0;
  std::optional<transport::SurfaceQuery> query_;
  std::optional<transport::RayScene> own_scene_;
  const transport::RayScene* scene_ = nullptr;
};

// What the samples of one triangle found.
struct TracedTriangle {
  VertexFit::Element element;
  std::uint64_t rays = 0, buried = 0, strayed = 0;
  double residual_squares = 0, squares = 0;
};

class SamplePhase {
 public:
  SamplePhase(const BakeSetup& setup, const transport::TransferField* exit,
              std::span<const std::uint32_t> row_of_side, Transfer& result)
      : setup_(setup),
        exit_(exit),
        row_of_side_(row_of_side),
        result_(result),
        channels_(static_cast<std::size_t>(setup.channels)),
        set_width_(channels_ * setup.coefficients),
        fit_(setup.mesh, (setup.sphere ? 2 : 1) * set_width_, kSmoothness),
        surface_(setup) {
    const ShadowOptions options{.order = setup.options.order,
                                .sphere = setup.sphere,
                                .record_hits = exit != nullptr,
                                .entered_ior = setup.options.entered_ior};
    for (std::uint32_t turn = 0; turn < kTurns; ++turn)
      passes_.push_back(std::make_unique<ShadowPass>(setup.mesh, surface_.scene(), options,
                                                     std::max(setup.options.directions / 8, kLeastDirections),
                                                     turn));
  }

  void run(stage::Progress* progress) {
    FitFigures& figures = result_.fit;
    double residual_squares = 0, squares = 0;
    tbb::enumerable_thread_specific<ShadowPass::Workspace> workspaces(
        [&] { return ShadowPass::Workspace(*passes_.front()); });
    const std::size_t count = setup_.mesh.triangleCount();
    std::vector<TracedTriangle> block;
    for (std::size_t first = 0; first < count; first += kTrianglesPerBlock) {
      block.resize(std::min(kTrianglesPerBlock, count - first));
      tbb::parallel_for(std::size_t{0}, block.size(), [&](std::size_t i) {
        block[i] = trace(static_cast<std::uint32_t>(first + i), workspaces.local());
        if (progress != nullptr) progress->advance(1);
      });
      for (std::size_t i = 0; i < block.size(); ++i) {
        fit_.add(static_cast<std::uint32_t>(first + i), block[i].element);
        figures.rays += block[i].rays;
        figures.buried_samples += block[i].buried;
        figures.strayed_samples += block[i].strayed;
        residual_squares += block[i].residual_squares;
        squares += block[i].squares;
      }
    }
    figures.samples = count * static_cast<std::uint64_t>(setup_.options.samples);
    const std::vector<std::uint32_t> first_copy = firstCopies();
    const VertexFit::Corrections corrections = fit_.solve();
    figures.iterations = corrections.iterations;
    if (squares > 0) {
      figures.error_at_vertices = std::sqrt(residual_squares / squares);
      figures.error = std::sqrt(std::max(0.0, residual_squares - corrections.squares_removed) / squares);
    }
    correct(first_copy, corrections.rows);
  }

 private:
  std::vector<std::uint32_t> firstCopies() const {
    std::vector<std::uint32_t> first;
    for (std::uint32_t v = 0; v < setup_.vertexCount(); ++v) first.push_back(fit_.firstCopy(v));
    return first;
  }

  TracedTriangle trace(std::uint32_t triangle, ShadowPass::Workspace& work) const {
    const int count = setup_.options.samples;
    const std::size_t size = setup_.coefficients, columns = fit_.columns();
    std::vector<FitSample> samples = transport::samplesOn(setup_.mesh, triangle, count);
    std::vector<float> rows(samples.size() * columns, 0.0F);
    std::vector<float> vector(size), near_vector(setup_.sphere ? size : 0);
    TracedTriangle result;
    for (std::size_t s = 0; s < samples.size(); ++s) {
      const std::optional<SurfacePoint> point = surface_.at(triangle, samples[s].weights);
      if (!point) {
        samples[s].area = 0;
        ++result.strayed;
        continue;
      }
      const std::size_t number = static_cast<std::size_t>(triangle) * samples.size() + s;
      const TracedPoint traced =
          passes_[number % kTurns]->trace(*point, setup_.sides_from_behind, {vector, near_vector, {}}, work);
      if (setup_.options.transport != Transport::kUnshadowed) result.rays += traced.rays;
      if (traced.buried) {
        samples[s].area = 0;
        ++result.buried;
        continue;
      }
      const auto row = std::span(rows).subspan(s * columns, columns);
      for (std::size_t c = 0; c < channels_; ++c) {
        std::copy(vector.begin(), vector.end(), row.begin() + static_cast<std::ptrdiff_t>(c * size));
        std::copy(near_vector.begin(), near_vector.end(),
                  row.begin() + static_cast<std::ptrdiff_t>(set_width_ + c * size));
      }
      addBounces(traced.seen, row);
      for (std::size_t c = 0; c < columns; ++c) {
        const double sampled = row[c];
        row[c] -= interpolated(triangle, samples[s].weights, c);
        result.squares += samples[s].area * sampled * sampled;
        result.residual_squares += samples[s].area * static_cast<double>(row[c]) * row[c];
      }
    }
    result.element = fit_.element(samples, rows);
    return result;
  }

  void addBounces(std::span<const transport::SeenVertex> seen, std::span<float> row) const {
    for (const transport::SeenVertex& each : seen) {
      const std::uint32_t point = row_of_side_[each.side];
      if (point == kDarkSide) continue;
      const auto exit = exit_->row(point);
      for (std::size_t c = 0; c < row.size(); ++c) row[c] += each.weight * exit[c];
    }
  }

  // In float, as the three equal values of a constant must give that value.
  float interpolated(std::uint32_t triangle, const Vec3& weights, std::size_t column) const {
    std::array<float, 3> values{};
    for (std::size_t i = 0; i < 3; ++i)
      values[i] = value(fit_.firstCopy(setup_.mesh.triangles[triangle][i]), column);
    return values[0] +
           static_cast<float>(weights[1] * (values[1] - values[0]) + weights[2] * (values[2] - values[0]));
  }
  float& value(std::uint32_t vertex, std::size_t column) const {
    return column < set_width_ ? result_.vectors[vertex * set_width_ + column]
                               : result_.near_vectors[vertex * set_width_ + column - set_width_];
  }

  // Adds the corrections. Where a surface that is all in the light borders on shadow they overshoot: uniform light shows
  // neither less than nothing nor more than all of it.
  void correct(std::span<const std::uint32_t> first_copy, const std::vector<float>& corrections) {
    FitFigures& figures = result_.fit;
    const std::size_t size = setup_.coefficients, columns = fit_.columns();
    const double constant = std::sqrt(4 * std::numbers::pi);  // coefficient of a uniform light of 1
    const double open = cosineFactors(1, setup_.options.entered_ior).front() / std::numbers::pi;
    // Copies come before the first one, whose value they take.
    for (std::size_t v = setup_.vertexCount(); v-- > 0;) {
      const std::uint32_t first = first_copy[v];
      bool limited = false;
      for (std::size_t column = 0; column < columns; ++column) {
        float& corrected = value(static_cast<std::uint32_t>(v), column);
        corrected = value(first, column) + corrections[first * columns + column];
        if (column % size != 0) continue;
        const double shown = constant * corrected;
        const bool distant = column < set_width_;
        if (distant) {
          figures.least_shown = std::min(figures.least_shown, shown);
          figures.most_shown = std::max(figures.most_shown, shown);
        }
        if (shown < 0) corrected = 0;
        if (distant && shown > open) corrected = static_cast<float>(open / constant);
        limited = limited || shown < -kRounding || (distant && shown > open + kRounding);
      }
      figures.limited_vertices += limited ? 1 : 0;
    }
  }

  const BakeSetup& setup_;
  const transport::TransferField* exit_;
  std::span<const std::uint32_t> row_of_side_;
  Transfer& result_;
  std::size_t channels_, set_width_;  // of distant or near-field vectors
  VertexFit fit_;
  SampledSurface surface_;
  std::vector<std::unique_ptr<ShadowPass>> passes_;
};

}  // namespace

void fitToSamples(const BakeSetup& setup, const transport::TransferField* exit,
                  std::span<const std::uint32_t> row_of_side, Transfer& result, stage::Progress* progress) {
  const Stopwatch watch;
  SamplePhase(setup, exit, row_of_side, result).run(progress);
  result.fit.seconds = watch.seconds();
}

}  // namespace bakelight::transfer
