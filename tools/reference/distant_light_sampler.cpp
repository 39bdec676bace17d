#include "tools/reference/distant_light_sampler.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "tools/reference/grid_distribution.h"
#include "transport/light_backdrop.h"
#include "transport/lights.h"
#include "transport/random.h"
#include "transport/sky.h"

namespace bakelight::reference {

using transport::accumulateProbabilities;
using transport::DefaultLight;
using transport::directionOfLatLong;
using transport::drawBackdrop;
using transport::drawInterval;
using transport::DrawnInterval;
using transport::float3;
using transport::kSunHalfAngle_rad;
using transport::latLongOfDirection;
using transport::latLongTexelSolidAngle;
using transport::luminance;
using transport::rgbImage;
using transport::Sky;
using transport::vec3;
using transport::worldFromEnvironment;
namespace {

constexpr double kPi = std::numbers::pi;

using Incident = DistantLightSampler::Incident;
using Sample = DistantLightSampler::Sample;

// Directions of normals, sorted into the cells of an octahedral map.
namespace normal_cells {

constexpr int kResolution = 24;
constexpr int kCount = kResolution * kResolution;

int indexOf(const Vec3& normal) {
  const Vec3 p = normal / normal.cwiseAbs().sum();
  double x = p.x(), y = p.y();
  if (p.z() < 0) {
    x = std::copysign(1 - std::abs(p.y()), p.x());
    y = std::copysign(1 - std::abs(p.x()), p.y());
  }
  const auto cell = [](double t) {
    return std::clamp(static_cast<int>((t + 1) / 2 * kResolution), 0, kResolution - 1);
  };
  return cell(y) * kResolution + cell(x);
}

// `across` and `down` in [0, 1] within the cell.
Vec3 directionIn(int cell, double across, double down) {
  const int column = cell % kResolution, row = cell / kResolution;
  const double x = 2 * (column + across) / kResolution - 1, y = 2 * (row + down) / kResolution - 1;
  const double z = 1 - std::abs(x) - std::abs(y);
  if (z >= 0) return Vec3(x, y, z).normalized();
  return Vec3(std::copysign(1 - std::abs(y), x), std::copysign(1 - std::abs(x), y), z).normalized();
}

// No normal of a cell is farther from its middle.
double radius_rad() {
  static const double kRadius = [] {
    double largest = 0;
    for (int cell = 0; cell < kCount; ++cell)
      for (const double x : {0.0, 0.5, 1.0})
        for (const double y : {0.0, 0.5, 1.0})
          largest = std::max(
              largest, std::acos(std::min(1.0, directionIn(cell, x, y).dot(directionIn(cell, 0.5, 0.5)))));
    return 1.01 * largest;
  }();
  return kRadius;
}

}  // namespace normal_cells

// A part of the sphere, all within `radius_rad` of an axis.
struct Patch {
  Vec3 axis;
  double radius_rad;

  // Cosine to the normals of a cell, on average; above 0 if any direction of the patch is above the surface
  // of any normal of the cell.
  double averageCosine(int cell) const {
    const double spread = std::min(radius_rad + normal_cells::radius_rad(), kPi);
    const double angle =
        std::acos(std::clamp(axis.dot(normal_cells::directionIn(cell, 0.5, 0.5)), -1.0, 1.0));
    double sum = 0;
    for (const double offset : {-1.0, -0.5, 0.0, 0.5, 1.0})
      sum += std::max(0.0, std::cos(std::clamp(angle + offset * spread, 0.0, kPi)));
    return sum / 5;
  }
};

// A lat-long image.
class Texels {
 public:
  // `image` has channels R, G, B.
  Texels(formats::Image image, double intensity, const Eigen::Matrix3d& world_from_image)
      : image_(std::move(image)),
        intensity_(intensity),
        world_from_image_(world_from_image),
        block_width_((image_.width + kBlocksAcross - 1) / kBlocksAcross),
        block_height_((image_.height + kBlocksDown - 1) / kBlocksDown),
        blocks_across_((image_.width + block_width_ - 1) / block_width_),
        blocks_down_((image_.height + block_height_ - 1) / block_height_) {
    for (int y = 0; y < image_.height; ++y)
      solid_angle_sr_.push_back(latLongTexelSolidAngle(y, image_.width, image_.height));
    std::vector<Patch> patches;
    for (int row = 0; row < blocks_down_; ++row)
      for (int column = 0; column < blocks_across_; ++column) addBlock(column, row, patches);
    for (int cell = 0; cell < normal_cells::kCount; ++cell) cells_.emplace_back(0, 0, std::span<double>());
    tbb::parallel_for(0, normal_cells::kCount, [&](int cell) {
      std::vector<double> weights;
      for (std::size_t i = 0; i < blocks_.size(); ++i)
        weights.push_back(blocks_[i].total() > 0 ? blocks_[i].total() * patches[i].averageCosine(cell) : 0);
      cells_[cell] = GridDistribution(blocks_across_, blocks_down_, weights);
    });
  }

  double weight(int cell) const { return cells_[cell].total(); }

  Rgb radiance(const Vec3& direction) const {
    const auto [x, y] = texelTowards(direction);
    return radianceOf(x, y);
  }

  Incident towards(const Vec3& direction, int cell) const {
    const auto [x, y] = texelTowards(direction);
    return {radianceOf(x, y), density(x, y, cell)};
  }

  Sample sample(int cell, double u, double v) const {
    const GridDistribution::Cell block = cells_[cell].draw(u, v);
    const GridDistribution::Cell texel = blocks_[blockIndex(block.x, block.y)].draw(block.down, block.across);
    const int x = block.x * block_width_ + texel.x, y = block.y * block_height_ + texel.y;
    // Uniform in solid angle: uniform in longitude and in the sine of latitude.
    const double above = sineAbove(y), sine = above + texel.down * (sineAbove(y + 1) - above);
    const double cosine = std::sqrt(std::max(0.0, 1 - sine * sine));
    const double longitude = kPi * (1 - 2 * (x + texel.across) / image_.width);
    const Vec3 direction(cosine * std::sin(longitude), sine, cosine * std::cos(longitude));
    return {world_from_image_ * direction, {radianceOf(x, y), density(x, y, cell)}};
  }

 private:
  static constexpr int kBlocksAcross = 64, kBlocksDown = 32;

  std::size_t blockIndex(int column, int row) const {
    return static_cast<std::size_t>(row) * blocks_across_ + column;
  }

  // Texel weights of the block, and where it lies: around the mean direction of its light.
  void addBlock(int column, int row, std::vector<Patch>& patches) {
    const int left = column * block_width_, top = row * block_height_;
    const int width = std::min(block_width_, image_.width - left);
    const int height = std::min(block_height_, image_.height - top);
    std::vector<double> weights;
    Vec3 mean = Vec3::Zero();
    for (int y = top; y < top + height; ++y)
      for (int x = left; x < left + width; ++x) {
        const float* texel = image_.texel(x, y);
        weights.push_back(solid_angle_sr_[y] *
                          std::max(0.0, intensity_ * luminance({texel[0], texel[1], texel[2]})));
        mean += weights.back() * cornerDirection(x + 0.5, y + 0.5);
      }
    blocks_.emplace_back(width, height, weights);
    Patch patch{mean.norm() > 0 ? Vec3(mean.normalized()) : Vec3::UnitY(), 0};
    double least_cosine = 1;
    for (int y = top; y <= top + height; ++y)
      for (int x = left; x <= left + width; ++x)
        least_cosine = std::min(least_cosine, patch.axis.dot(cornerDirection(x, y)));
    patch.radius_rad = 1.01 * std::acos(std::max(least_cosine, -1.0)) + kPi / image_.height;
    patch.axis = world_from_image_ * patch.axis;
    patches.push_back(patch);
  }

  Vec3 cornerDirection(double x, double y) const {
    return directionOfLatLong(x / image_.width, y / image_.height);
  }
  double sineAbove(int y) const { return std::sin(kPi * (0.5 - static_cast<double>(y) / image_.height)); }

  std::array<int, 2> texelTowards(const Vec3& direction) const {
    const auto [u, v] = latLongOfDirection(world_from_image_.transpose() * direction);
    return {std::min(static_cast<int>(u * image_.width), image_.width - 1),
            std::min(static_cast<int>(v * image_.height), image_.height - 1)};
  }
  Rgb radianceOf(int x, int y) const {
    const float* texel = image_.texel(x, y);
    return intensity_ * Rgb(texel[0], texel[1], texel[2]);
  }
  double density(int x, int y, int cell) const {
    const int column = x / block_width_, row = y / block_height_;
    const double of_block = cells_[cell].probability(column, row);
    if (of_block == 0) return 0;
    return of_block * blocks_[blockIndex(column, row)].probability(x % block_width_, y % block_height_) /
           solid_angle_sr_[y];
  }

  formats::Image image_;
  double intensity_;
  Eigen::Matrix3d world_from_image_;
  int block_width_, block_height_, blocks_across_, blocks_down_;
  std::vector<double> solid_angle_sr_;    // of a texel in each row
  std::vector<GridDistribution> blocks_;  // texels of each
  std::vector<GridDistribution> cells_;   // blocks, for each cell of normals
};

class Cone {
 public:
  Cone(const Vec3& axis, double half_angle_rad, const Rgb& radiance)
      : axis_(axis.normalized()),
        right_(axis_.unitOrthogonal()),
        up_(axis_.cross(right_)),
        half_angle_rad_(half_angle_rad),
        half_drop_(std::pow(std::sin(half_angle_rad / 2), 2)),
        radiance_(radiance) {}

  double weight(int cell) const {
    const double power = std::max(0.0, luminance(float3(radiance_.matrix()))) / densityPerSr();
    return power * Patch{axis_, half_angle_rad_}.averageCosine(cell);
  }

  Rgb radiance(const Vec3& direction) const { return contains(direction) ? radiance_ : Rgb(Rgb::Zero()); }
  Incident towards(const Vec3& direction) const {
    if (!contains(direction)) return {};
    return {radiance_, densityPerSr()};
  }

  Sample sample(double u, double v) const {
    const double half_drop = u * half_drop_;
    const double sine = 2 * std::sqrt(half_drop * (1 - half_drop)), turn = 2 * kPi * v;
    return {(1 - 2 * half_drop) * axis_ + sine * (std::cos(turn) * right_ + std::sin(turn) * up_),
            {radiance_, densityPerSr()}};
  }

 private:
  double densityPerSr() const { return 1 / (4 * kPi * half_drop_); }
  bool contains(const Vec3& direction) const { return (direction - axis_).squaredNorm() <= 4 * half_drop_; }

  Vec3 axis_, right_, up_;
  double half_angle_rad_;
  double half_drop_;  // (1 − cosine) / 2 at the rim, without the cancellation of a small cone
  Rgb radiance_;
};

// Sky above the horizon and ground below it, without the sun's disk. A texel is the mean over itself; the
// horizon lies between two rows.
formats::Image imageOf(const Sky& sky) {
  constexpr int kHeight_px = 512, kSubsamples = 2;
  formats::Image image(2 * kHeight_px, kHeight_px, {"R", "G", "B"});
  tbb::parallel_for(0, image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      Rgb sum = Rgb::Zero();
      for (int j = 0; j < kSubsamples; ++j)
        for (int i = 0; i < kSubsamples; ++i)
          sum += sky.radiance(directionOfLatLong((x + (i + 0.5) / kSubsamples) / image.width,
                                                 (y + (j + 0.5) / kSubsamples) / image.height));
      const Float3 mean = float3((sum / (kSubsamples * kSubsamples)).matrix());
      std::copy(mean.begin(), mean.end(), image.texel(x, y));
    }
  });
  return image;
}

}  // namespace

struct DistantLightSampler::Implementation {
  std::vector<Texels> texels;
  std::vector<Cone> cones;
  std::vector<Directional> directional;
  std::size_t sources = 0;
  std::vector<double> shares;  // (sources + 1) a cell: cumulative probabilities of texels, then cones

  std::span<const double> sharesOf(int cell) const {
    return std::span(shares).subspan(cell * (sources + 1), sources + 1);
  }

  void finish() {
    sources = texels.size() + cones.size();
    shares.resize(normal_cells::kCount * (sources + 1));
    for (int cell = 0; cell < normal_cells::kCount; ++cell) {
      std::vector<double> weights;
      for (const Texels& image : texels) weights.push_back(image.weight(cell));
      for (const Cone& cone : cones) weights.push_back(cone.weight(cell));
      accumulateProbabilities(weights, std::span(shares).subspan(cell * (sources + 1), sources + 1));
    }
  }

  Incident towards(const Vec3& direction, int cell) const {
    const std::span<const double> cumulative = sharesOf(cell);
    Incident sum;
    const auto add = [&](std::size_t source, const Incident& incident) {
      sum.radiance += incident.radiance;
      sum.density_per_sr += (cumulative[source + 1] - cumulative[source]) * incident.density_per_sr;
    };
    for (std::size_t i = 0; i < texels.size(); ++i) add(i, texels[i].towards(direction, cell));
    for (std::size_t i = 0; i < cones.size(); ++i) add(texels.size() + i, cones[i].towards(direction));
    return sum;
  }
};

namespace {

// Sorts the lights of a rig by how they are sampled.
template <class Implementation>
struct Collector {
  Implementation& result;
  const Eigen::Matrix3d& world_from_light;
  formats::LightRig drawn;

  void operator()(const formats::EnvironmentLight& light) {
    if (light.image.width == 2 * light.image.height)
      result.texels.emplace_back(rgbImage(light.image, light.path.string()), light.intensity,
                                 world_from_light * worldFromEnvironment(light));
    else
      drawn.distant.emplace_back(light);
  }
  void operator()(const formats::DiskLight& light) {
    cone(vec3(light.direction), light.half_angle_deg * kPi / 180, vec3(light.radiance));
  }
  void operator()(const formats::PolygonLight& light) { drawn.distant.emplace_back(light); }
  void operator()(const formats::DirectionalLight& light) {
    result.directional.push_back(
        {world_from_light * vec3(light.direction).normalized(), vec3(light.irradiance)});
  }
  void operator()(const formats::SkyLight& light) {
    const Sky sky(light);
    if (sky.sunRadiance().maxCoeff() > 0) cone(sky.sunDirection(), kSunHalfAngle_rad, sky.sunRadiance());
    result.texels.emplace_back(imageOf(sky), 1, world_from_light);
  }
  void cone(const Vec3& axis, double half_angle_rad, const Rgb& radiance) {
    result.cones.emplace_back(world_from_light * axis, half_angle_rad, radiance);
  }
};

}  // namespace

DistantLightSampler::DistantLightSampler(const formats::LightRig& rig,
                                         const Eigen::Matrix3d& world_from_light)
    : implementation_(std::make_unique<Implementation>()) {
  Collector<Implementation> collector{*implementation_, world_from_light, {}};
  if (rig.empty()) {
    const DefaultLight light;
    collector.cone(light.key_direction, light.key_half_angle_rad, vec3(light.key_radiance));
    collector.cone(Vec3::UnitY(), kPi, vec3(light.sky_radiance));
  }
  for (const formats::DistantLight& light : rig.distant) std::visit(collector, light);
  if (!collector.drawn.distant.empty())
    implementation_->texels.emplace_back(drawBackdrop(collector.drawn), 1, world_from_light);
  implementation_->finish();
}

DistantLightSampler::~DistantLightSampler() = default;

const std::vector<DistantLightSampler::Directional>& DistantLightSampler::directional() const {
  return implementation_->directional;
}

Rgb DistantLightSampler::radiance(const Vec3& direction) const {
  Rgb sum = Rgb::Zero();
  for (const Texels& image : implementation_->texels) sum += image.radiance(direction);
  for (const Cone& cone : implementation_->cones) sum += cone.radiance(direction);
  return sum;
}

DistantLightSampler::Incident DistantLightSampler::towards(const Vec3& direction, const Vec3& normal) const {
  return implementation_->towards(direction, normal_cells::indexOf(normal));
}

DistantLightSampler::Sample DistantLightSampler::sample(const Vec3& normal, double u, double v) const {
  const int cell = normal_cells::indexOf(normal);
  const std::span<const double> shares = implementation_->sharesOf(cell);
  if (!(shares.back() > 0)) return {};
  const DrawnInterval source = drawInterval(shares, u);
  const std::vector<Texels>& texels = implementation_->texels;
  Sample sample = source.index < texels.size()
                      ? texels[source.index].sample(cell, source.rest, v)
                      : implementation_->cones[source.index - texels.size()].sample(source.rest, v);
  if (implementation_->sources > 1) sample.incident = implementation_->towards(sample.direction, cell);
  return sample;
}

}  // namespace bakelight::reference
