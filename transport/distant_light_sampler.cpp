#include "transport/distant_light_sampler.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "transport/light_backdrop.h"
#include "transport/lights.h"
#include "transport/random.h"
#include "transport/sky.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;

double luminanceOf(const Rgb& radiance) {
  return 0.2126 * radiance[0] + 0.7152 * radiance[1] + 0.0722 * radiance[2];
}

}  // namespace

DistantLightSampler::Texels::Texels(formats::Image image, double intensity,
                                    const Eigen::Matrix3d& world_from_image)
    : image_(std::move(image)), world_from_image_(world_from_image), intensity_(intensity) {
  const auto width = static_cast<std::size_t>(image_.width), height = static_cast<std::size_t>(image_.height);
  rows_.resize(height + 1);
  columns_.resize(height * (width + 1));
  std::vector<double> row_weights(height), weights(width);
  for (int y = 0; y < image_.height; ++y) {
    solid_angle_sr_.push_back(latLongTexelSolidAngle(y, image_.width, image_.height));
    for (int x = 0; x < image_.width; ++x) {
      const float* texel = image_.texel(x, y);
      weights[x] = std::max(0.0, intensity_ * luminance({texel[0], texel[1], texel[2]}));
    }
    row_weights[y] =
        solid_angle_sr_.back() *
        accumulateProbabilities(weights, std::span(columns_).subspan(y * (width + 1), width + 1));
  }
  power_ = accumulateProbabilities(row_weights, rows_);
}

double DistantLightSampler::Texels::sineAbove(int y) const {
  return std::sin(kPi * (0.5 - static_cast<double>(y) / image_.height));
}

DistantLightSampler::Incident DistantLightSampler::Texels::at(int x, int y) const {
  const float* texel = image_.texel(x, y);
  const double* columns = &columns_[static_cast<std::size_t>(y) * (image_.width + 1)];
  const double probability = (rows_[y + 1] - rows_[y]) * (columns[x + 1] - columns[x]);
  return {intensity_ * Rgb(texel[0], texel[1], texel[2]), probability / solid_angle_sr_[y]};
}

DistantLightSampler::Incident DistantLightSampler::Texels::towards(const Vec3& direction) const {
  const auto [u, v] = latLongOfDirection(world_from_image_.transpose() * direction);
  return at(std::min(static_cast<int>(u * image_.width), image_.width - 1),
            std::min(static_cast<int>(v * image_.height), image_.height - 1));
}

DistantLightSampler::Sample DistantLightSampler::Texels::sample(double u, double v) const {
  const DrawnInterval row = drawInterval(rows_, u);
  const auto row_size = static_cast<std::size_t>(image_.width) + 1;
  const DrawnInterval column = drawInterval(std::span(columns_).subspan(row.index * row_size, row_size), v);
  const int x = static_cast<int>(column.index), y = static_cast<int>(row.index);
  // Uniform in solid angle: uniform in longitude and in the sine of latitude.
  const double above = sineAbove(y), sine = above + row.rest * (sineAbove(y + 1) - above);
  const double cosine = std::sqrt(std::max(0.0, 1 - sine * sine));
  const double longitude = kPi * (1 - 2 * (x + column.rest) / image_.width);
  const Vec3 direction(cosine * std::sin(longitude), sine, cosine * std::cos(longitude));
  return {world_from_image_ * direction, at(x, y)};
}

DistantLightSampler::Cone::Cone(const Vec3& axis, double half_angle_rad, const Rgb& radiance)
    : axis_(axis.normalized()), half_chord_squared_(std::sin(half_angle_rad / 2)), radiance_(radiance) {
  half_chord_squared_ *= half_chord_squared_;
  right_ = axis_.unitOrthogonal();
  up_ = axis_.cross(right_);
}

double DistantLightSampler::Cone::power() const {
  return std::max(0.0, luminanceOf(radiance_)) * 4 * kPi * half_chord_squared_;
}

DistantLightSampler::Incident DistantLightSampler::Cone::towards(const Vec3& direction) const {
  if ((direction - axis_).squaredNorm() > 4 * half_chord_squared_) return {};
  return {radiance_, 1 / (4 * kPi * half_chord_squared_)};
}

DistantLightSampler::Sample DistantLightSampler::Cone::sample(double u, double v) const {
  const double half_chord = u * half_chord_squared_;  // (1 − cosine) / 2
  const double sine = 2 * std::sqrt(half_chord * (1 - half_chord)), turn = 2 * kPi * v;
  const Vec3 direction =
      (1 - 2 * half_chord) * axis_ + sine * (std::cos(turn) * right_ + std::sin(turn) * up_);
  return {direction, {radiance_, 1 / (4 * kPi * half_chord_squared_)}};
}

namespace {

// Sky above the horizon and ground below it, without the sun's disk. A texel is the mean of its middle's
// neighbourhood; the horizon lies between two rows.
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

// Sorts the lights of a rig by how they are sampled.
struct DistantLightSampler::Collector {
  DistantLightSampler& result;
  const Eigen::Matrix3d& world_from_light;
  formats::LightRig drawn;

  void operator()(const formats::EnvironmentLight& light) {
    if (light.image.width != 2 * light.image.height) return drawn.distant.emplace_back(light), void();
    result.texels_.emplace_back(rgbImage(light.image, light.path.string()), light.intensity,
                                world_from_light * worldFromEnvironment(light));
  }
  void operator()(const formats::DiskLight& light) {
    cone(vec3(light.direction), light.half_angle_deg * kPi / 180, vec3(light.radiance));
  }
  void operator()(const formats::PolygonLight& light) { drawn.distant.emplace_back(light); }
  void operator()(const formats::DirectionalLight& light) {
    result.directional_.push_back(
        {world_from_light * vec3(light.direction).normalized(), vec3(light.irradiance)});
  }
  void operator()(const formats::SkyLight& light) {
    const Sky sky(light);
    if (sky.sunRadiance().maxCoeff() > 0) cone(sky.sunDirection(), kSunHalfAngle_rad, sky.sunRadiance());
    result.texels_.emplace_back(imageOf(sky), 1, world_from_light);
  }
  void cone(const Vec3& axis, double half_angle_rad, const Rgb& radiance) {
    result.cones_.emplace_back(world_from_light * axis, half_angle_rad, radiance);
  }
};

DistantLightSampler::DistantLightSampler(const formats::LightRig& rig,
                                         const Eigen::Matrix3d& world_from_light) {
  Collector collector{*this, world_from_light, {}};
  if (rig.distant.empty() && rig.emitters.empty()) {
    const DefaultLight light;
    collector.cone(light.key_direction, light.key_half_angle_rad, vec3(light.key_radiance));
    collector.cone(Vec3::UnitY(), kPi, vec3(light.sky_radiance));
  }
  for (const formats::DistantLight& light : rig.distant) std::visit(collector, light);
  if (!collector.drawn.distant.empty())
    texels_.emplace_back(drawBackdrop(collector.drawn), 1, world_from_light);

  std::vector<double> powers;
  for (const Texels& texels : texels_) powers.push_back(texels.power());
  for (const Cone& cone : cones_) powers.push_back(cone.power());
  cumulative_power_.resize(powers.size() + 1);
  accumulateProbabilities(powers, cumulative_power_);
}

double DistantLightSampler::shareOf(std::size_t source) const {
  return cumulative_power_[source + 1] - cumulative_power_[source];
}

DistantLightSampler::Incident DistantLightSampler::towards(const Vec3& direction) const {
  Incident sum;
  const auto add = [&](std::size_t source, const Incident& incident) {
    sum.radiance += incident.radiance;
    sum.density_per_sr += shareOf(source) * incident.density_per_sr;
  };
  for (std::size_t i = 0; i < texels_.size(); ++i) add(i, texels_[i].towards(direction));
  for (std::size_t i = 0; i < cones_.size(); ++i) add(texels_.size() + i, cones_[i].towards(direction));
  return sum;
}

DistantLightSampler::Sample DistantLightSampler::sample(double u, double v) const {
  const DrawnInterval source = drawInterval(cumulative_power_, u);
  Sample sample = source.index < texels_.size()
                      ? texels_[source.index].sample(source.rest, v)
                      : cones_[source.index - texels_.size()].sample(source.rest, v);
  if (texels_.size() + cones_.size() > 1) sample.incident = towards(sample.direction);
  return sample;
}

}  // namespace bakelight::transport
