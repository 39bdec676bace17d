#include "tools/btf/projection.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <Eigen/Dense>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "tools/btf/scattered_directions.h"
#include "transport/directions.h"
#include "transport/gauss_legendre.h"
#include "transport/hemisphere_grid.h"
#include "transport/sh.h"

namespace bakelight::btf {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kBlock = 256;  // texels
constexpr double kLeastCosine = 0.05;
using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Light {
  Vec3 direction;
  std::vector<double> weights;  // of reflectance under it, for each coefficient
};

// w_k y_i(l_k) cos θ_k
std::vector<Light> quadratureLights(const ProjectionOptions& options) {
  std::vector<Light> lights;
  for (const auto& [x, weight] : transport::gaussLegendreRule(options.polar_lights))
    for (int a = 0; a < options.azimuthal_lights; ++a) {
      const double z = (x + 1) / 2, azimuth = 2 * kPi * (a + 0.5) / options.azimuthal_lights;
      const double flat = std::sqrt(1 - z * z);
      Light light{{flat * std::cos(azimuth), flat * std::sin(azimuth), z}, {}};
      light.weights = transport::evaluateSh(options.order, light.direction);
      for (double& value : light.weights) value *= weight / 2 * (2 * kPi / options.azimuthal_lights) * z;
      lights.push_back(std::move(light));
    }
  return lights;
}

// Of each cell: places of a Gauss rule in its square, as rtt has them; every point of it has the same solid angle. Their cosines are scaled to the cell's
// mean, so that a Lambertian is exact.
std::vector<Light> cellLights(const GridLights& grid) {
  const int side = grid.lights;
  const std::vector<transport::QuadratureNode> nodes = transport::gaussLegendreRule(grid.light_samples);
  std::vector<Light> lights;
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      const auto at = [side](int place, double node) { return (place + (1 + node) / 2) / side; };
      const auto cell =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(side) + static_cast<std::size_t>(column);
      const std::size_t first = lights.size();
      double sum = 0;
      for (const auto& up : nodes)
        for (const auto& across : nodes) {
          Light light{
              transport::hemisphereFromSquare(at(column, across.x), at(row, up.x)),
              std::vector<double>(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 0.0)};
          light.weights[cell] = up.weight * across.weight / 4 * light.direction.z();
          sum += light.weights[cell];
          lights.push_back(std::move(light));
        }
      const double mean = transport::hemisphereCellCosine(side, column, row);
      for (std::size_t i = first; i < lights.size(); ++i) lights[i].weights[cell] *= mean / sum;
    }
  return lights;
}

// Directions whose share goes to a view of the texture.
struct GridView {
  Vec3 direction;
  std::size_t target;
  double share;
};

std::vector<GridView> gridViews(int side) {
  constexpr int kAveraged = 8;
  const int cells = side == 1 ? kAveraged : side;
  std::vector<GridView> views;
  for (int row = 0; row < cells; ++row)
    for (int column = 0; column < cells; ++column)
      views.push_back({transport::hemisphereCell(cells, column, row), side == 1 ? 0 : views.size(),
                       side == 1 ? 1.0 / (cells * cells) : 1.0});
  return views;
}

// What a view's pictures add to a view of the grid: coefficients × lights that the view has.
struct Use {
  std::size_t target;
  Eigen::MatrixXd weights;
};
using Uses = std::vector<std::vector<Use>>;  // of each measured view

struct Directions {
  std::vector<Vec3> views, lights;
  std::vector<std::vector<int>> lights_of_view;
};

Directions directionsOf(const formats::Btf& btf, bool clockwise) {
  Directions directions;
  for (const formats::BtfDirection& view : btf.info().views) directions.views.push_back(vectorOf(view));
  for (const formats::BtfDirection& light : btf.info().lights) directions.lights.push_back(vectorOf(light));
  for (std::size_t v = 0; v < directions.views.size(); ++v)
    directions.lights_of_view.push_back(btf.lightsOf(static_cast<int>(v)));
  if (clockwise)
    for (auto* list : {&directions.views, &directions.lights})
      for (Vec3& direction : *list) direction.y() = -direction.y();
  return directions;
}

// The share of the lights that a view must have pictures under to count.
bool isSeen(const Directions& directions, std::size_t view) {
  return 2 * directions.lights_of_view[view].size() >= directions.lights.size();
}

Uses usesByView(const Directions& directions, const std::vector<Light>& lights,
                const std::vector<GridView>& grid) {
  std::vector<int> present;
  std::vector<Vec3> present_views;
  std::vector<Eigen::MatrixXd> projections;
  for (std::size_t v = 0; v < directions.views.size(); ++v) {
    const std::vector<int>& own = directions.lights_of_view[v];
    if (!isSeen(directions, v)) continue;
    present.push_back(static_cast<int>(v));
    present_views.push_back(directions.views[v]);
    std::vector<Vec3> own_lights;
    for (const int l : own) own_lights.push_back(directions.lights[static_cast<std::size_t>(l)]);
    const ScatteredDirections between(own_lights);
    Eigen::MatrixXd projection = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(lights[0].weights.size()),
                                                       static_cast<Eigen::Index>(own.size()));
    for (const Light& light : lights)
      for (const auto& [index, weight] : between.shares(light.direction))
        projection.col(index) +=
            weight * Eigen::Map<const Eigen::VectorXd>(light.weights.data(), projection.rows());
    projections.push_back(std::move(projection));
  }
  Uses uses(directions.views.size());
  const ScatteredDirections between(present_views);
  for (const GridView& view : grid)
    for (const auto& [index, weight] : between.shares(view.direction)) {
      std::vector<Use>& of_view = uses[static_cast<std::size_t>(present[static_cast<std::size_t>(index)])];
      const Eigen::MatrixXd added = view.share * weight * projections[static_cast<std::size_t>(index)];
      if (!of_view.empty() && of_view.back().target == view.target)
        of_view.back().weights += added;
      else
        of_view.push_back({view.target, added});
    }
  return uses;
}

using Place = Eigen::Vector4d;  // of a pair of directions: both in the stereographic plane
Place placeOf(const Vec3& view, const Vec3& light) {
  return {view.x() / (1 + view.z()), view.y() / (1 + view.z()), light.x() / (1 + light.z()),
          light.y() / (1 + light.z())};
}

// Weights of all pairs for the value at `place`: a linear function fitted around it. They sum to 1.
Eigen::VectorXd fittedWeights(const std::vector<Place>& pairs, const Place& place) {
  constexpr std::size_t kNear = 8;  // pairs within the Gaussian's width
  constexpr double kSteepness = 0.05;
  std::vector<double> squares;
  for (const Place& pair : pairs) squares.push_back((pair - place).squaredNorm());
  std::vector<double> sorted = squares;
  const std::size_t near = std::min(kNear, sorted.size()) - 1;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(near), sorted.end());
  const double width_square = std::max(sorted[near], 1e-12);
  const auto count = static_cast<Eigen::Index>(pairs.size());
  Eigen::Matrix<double, Eigen::Dynamic, 5> terms(count, 5);
  Eigen::VectorXd gauss(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    gauss[i] = std::exp(-squares[static_cast<std::size_t>(i)] / width_square);
    terms.row(i) << 1, ((pairs[static_cast<std::size_t>(i)] - place) / std::sqrt(width_square)).transpose();
  }
  Eigen::Matrix<double, 5, 5> normal = terms.transpose() * gauss.asDiagonal() * terms;
  // Slopes that few pairs can tell stay small: far beyond all of them the mean is taken.
  for (int k = 1; k < 5; ++k) normal(k, k) += kSteepness * gauss.sum();
  const Eigen::Matrix<double, 5, 1> first = normal.ldlt().solve(Eigen::Matrix<double, 5, 1>::Unit(0));
  return gauss.asDiagonal() * (terms * first);
}

Uses usesByPair(const Directions& directions, const std::vector<Light>& lights,
                const std::vector<GridView>& grid) {
  std::vector<Place> pairs;
  std::vector<std::pair<std::size_t, Eigen::Index>> at;  // view, and light of those that the view has
  for (std::size_t v = 0; v < directions.views.size(); ++v)
    for (std::size_t i = 0; i < directions.lights_of_view[v].size(); ++i) {
      const int light = directions.lights_of_view[v][i];
      pairs.push_back(placeOf(directions.views[v], directions.lights[static_cast<std::size_t>(light)]));
      at.emplace_back(v, static_cast<Eigen::Index>(i));
    }
  const auto coefficients = static_cast<Eigen::Index>(lights[0].weights.size());
  std::vector<Eigen::MatrixXd> of_targets(grid.size());  // coefficients × pairs
  tbb::parallel_for(std::size_t{0}, grid.size(), [&](std::size_t target) {
    Eigen::MatrixXd& weights = of_targets[target];
    weights = Eigen::MatrixXd::Zero(coefficients, static_cast<Eigen::Index>(pairs.size()));
    for (const Light& light : lights)
      weights += grid[target].share * Eigen::Map<const Eigen::VectorXd>(light.weights.data(), coefficients) *
                 fittedWeights(pairs, placeOf(grid[target].direction, light.direction)).transpose();
  });
  Uses uses(directions.views.size());
  for (std::size_t v = 0; v < uses.size(); ++v)
    for (std::size_t target = 0; target <= grid.back().target; ++target)
      uses[v].push_back(
          {target, Eigen::MatrixXd::Zero(coefficients,
                                         static_cast<Eigen::Index>(directions.lights_of_view[v].size()))});
  for (std::size_t p = 0; p < pairs.size(); ++p)
    for (std::size_t g = 0; g < grid.size(); ++g)
      uses[at[p].first][grid[g].target].weights.col(at[p].second) +=
          of_targets[g].col(static_cast<Eigen::Index>(p));
  return uses;
}

bool isJoint(const Directions& directions) {
  std::size_t pictures = 0;
  for (const auto& lights : directions.lights_of_view) pictures += lights.size();
  return 4 * pictures < 3 * directions.views.size() * directions.lights.size();
}

// From values as they stand to reflectance.
void divideByCosines(Uses& uses, const Directions& directions) {
  for (std::size_t v = 0; v < uses.size(); ++v)
    for (Use& use : uses[v])
      for (std::size_t i = 0; i < directions.lights_of_view[v].size(); ++i)
        use.weights.col(static_cast<Eigen::Index>(i)) /= std::max(
            directions.lights[static_cast<std::size_t>(directions.lights_of_view[v][i])].z(), kLeastCosine);
}

// [view][texel][color][coefficient]
struct Target {
  std::span<float> values;
  std::size_t texels = 0, coefficients = 0;
};

void addView(const formats::Btf& btf, int v, const std::vector<int>& lights, const std::vector<Use>& uses,
             double scale, const Target& target) {
  std::vector<Rows> weights;
  for (const Use& use : uses) weights.push_back((scale * use.weights).cast<float>());
  const std::size_t texels = target.texels, coefficients = target.coefficients;
  const auto view = btf.view(v);
  tbb::parallel_for(std::size_t{0}, (texels + kBlock - 1) / kBlock, [&](std::size_t block) {
    const std::size_t first = block * kBlock, count = std::min(kBlock, texels - first);
    std::vector<float> rgb(3 * lights.size() * count);
    view->decode(lights, {first, count}, rgb);
    Rows added(static_cast<Eigen::Index>(coefficients), static_cast<Eigen::Index>(count));
    for (std::size_t u = 0; u < uses.size(); ++u)
      for (std::size_t c = 0; c < 3; ++c) {
        added.noalias() = weights[u] * Eigen::Map<const Rows>(rgb.data() + c * lights.size() * count,
                                                              static_cast<Eigen::Index>(lights.size()),
                                                              static_cast<Eigen::Index>(count));
        for (std::size_t t = 0; t < count; ++t) {
          float* response =
              &target.values[(uses[u].target * texels + first + t) * 3 * coefficients + c * coefficients];
          for (std::size_t i = 0; i < coefficients; ++i)
            response[i] += added(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(t));
        }
      }
  });
}

double degrees(double radians) {
  return radians * 180 / kPi;
}

void measureRadiance(const formats::RadianceTransferTexture& texture, ProjectionFigures& figures) {
  const std::size_t texels = texture.texelCount(), coefficients = texture.coefficientCount();
  const double uniform_sky = std::sqrt(4 * kPi);
  for (std::size_t v = 0; v < texture.viewCount(); ++v)
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = 0;
      for (std::size_t t = 0; t < texels; ++t)
        sum += static_cast<double>(texture.values[((v * texels + t) * 3 + c) * coefficients]);
      const double mean = uniform_sky * sum / static_cast<double>(texels);
      figures.mean_radiance[c] += mean / static_cast<double>(texture.viewCount());
      figures.largest_view_radiance = std::max(figures.largest_view_radiance, mean);
    }
}

double viewDependence(const formats::RadianceTransferTexture& texture) {
  const std::size_t a_view = texture.texelCount() * texture.responseSize(), views = texture.viewCount();
  double squares = 0, differences = 0;
  for (std::size_t i = 0; i < a_view; ++i) {
    double mean = 0;
    for (std::size_t v = 0; v < views; ++v) mean += texture.values[v * a_view + i];
    mean /= static_cast<double>(views);
    for (std::size_t v = 0; v < views; ++v) {
      const double value = texture.values[v * a_view + i];
      squares += value * value, differences += (value - mean) * (value - mean);
    }
  }
  return squares > 0 ? std::sqrt(differences / squares) : 0;
}

}  // namespace

namespace {

// Adds up what each measured view gives to each of the grid. Returns whether views and lights were interpolated together.
bool addViews(const formats::Btf& btf, const ProjectionOptions& options, const Directions& directions,
              const std::vector<Light>& lights, const std::function<void()>& advance, const Target& target) {
  const std::vector<GridView> grid = gridViews(options.views);
  const bool is_joint = isJoint(directions);
  Uses uses = is_joint ? usesByPair(directions, lights, grid) : usesByView(directions, lights, grid);
  const bool inside = options.cosine == Cosine::kInside ||
                      (options.cosine == Cosine::kAsFileSays && btf.info().cosine_inside);
  if (inside) divideByCosines(uses, directions);
  for (std::size_t v = 0; v < directions.views.size(); ++v) {
    if (!uses[v].empty() && !directions.lights_of_view[v].empty())
      addView(btf, static_cast<int>(v), directions.lights_of_view[v], uses[v], options.scale, target);
    if (advance) advance();
  }
  return is_joint;
}

}  // namespace

Projected project(const formats::Btf& btf, const ProjectionOptions& options,
                  const std::function<void()>& advance) {
  const formats::BtfInfo& info = btf.info();
  const Directions directions = directionsOf(btf, options.clockwise);
  Projected result;
  result.texture.order = options.order, result.texture.views = options.views;
  result.texture.width = info.width, result.texture.height = info.height;
  result.texture.allocate();
  result.figures.view_gap_deg = degrees(transport::largestGap(directions.views).angle_rad);
  result.figures.light_gap_deg = degrees(transport::largestGap(directions.lights).angle_rad);
  result.figures.is_joint =
      addViews(btf, options, directions, quadratureLights(options), advance,
               {result.texture.values, result.texture.texelCount(), result.texture.coefficientCount()});
  if (!result.figures.is_joint)
    for (std::size_t v = 0; v < directions.views.size(); ++v)
      result.figures.views_left_out += !isSeen(directions, v);
  measureRadiance(result.texture, result.figures);
  result.figures.view_dependence = viewDependence(result.texture);
  return result;
}

std::vector<float> resample(const formats::Btf& btf, const ProjectionOptions& options, const GridLights& grid,
                            const std::function<void()>& advance) {
  const std::size_t cells = static_cast<std::size_t>(grid.lights) * grid.lights;
  std::vector<float> values(static_cast<std::size_t>(options.views) * options.views * btf.texelCount() * 3 *
                            cells);
  addViews(btf, options, directionsOf(btf, options.clockwise), cellLights(grid), advance,
           {values, btf.texelCount(), cells});
  return values;
}

}  // namespace bakelight::btf
