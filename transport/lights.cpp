#include "transport/lights.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/error.h"
#include "transport/polygon_light.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;

// Indices of the red, green and blue channels. A layer prefix ("Combined.R") is allowed; one channel serves
// all three.
std::array<std::size_t, 3> colorChannels(const formats::Image& image, const std::string& file) {
  if (image.channelCount() == 1) return {0, 0, 0};
  static const std::vector<std::string> kPlain = {"R", "G", "B"};
  if (image.channel_names == kPlain) return {0, 1, 2};
  std::array<std::size_t, 3> found{};
  const std::array<std::string, 3> names = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto matches = [&](const std::string& name) {
      return name == names[c] || name.ends_with("." + names[c]);
    };
    const auto it = std::find_if(image.channel_names.begin(), image.channel_names.end(), matches);
    if (it == image.channel_names.end())
      throw badInput({file, "channel " + names[c], ""}, "is missing", "channels R, G and B, or a single one",
                     "save the probe as an RGB image");
    found[c] = static_cast<std::size_t>(it - image.channel_names.begin());
  }
  return found;
}

void checkLatLong(const formats::Image& image, const std::string& file) {
  if (image.width != 2 * image.height || image.height < 1)
    throw badInput({file, "", ""},
                   "is " + std::to_string(image.width) + " × " + std::to_string(image.height) +
                       " pixels, so it is no lat-long probe",
                   "an image twice as wide as high",
                   "convert the probe to the equirectangular (lat-long) layout");
}

std::vector<double> rowSums(const formats::Image& image, int row, int order,
                            const std::array<std::size_t, 3>& channels) {
  const int count = coefficientCount(order);
  std::vector<double> sums(3 * static_cast<std::size_t>(count), 0.0), basis(count);
  for (int x = 0; x < image.width; ++x) {
    evaluateSh(order, directionOfLatLong((x + 0.5) / image.width, (row + 0.5) / image.height), basis);
    const float* texel = image.texel(x, row);
    for (int c = 0; c < 3; ++c) {
      const double radiance = texel[channels[c]];
      for (int i = 0; i < count; ++i) sums[c * count + i] += radiance * basis[i];
    }
  }
  const double solid_angle_sr = latLongTexelSolidAngle(row, image.width, image.height);
  for (double& sum : sums) sum *= solid_angle_sr;
  return sums;
}

ShLight tinted(std::span<const double> coefficients, const Float3& color) {
  ShLight light(coefficients.size());
  for (std::size_t i = 0; i < light.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) light[i][c] = static_cast<float>(color[c] * coefficients[i]);
  return light;
}

}  // namespace

Vec3 directionOfLatLong(double u, double v) {
  const double longitude = kPi * (1 - 2 * u), latitude = kPi * (0.5 - v);
  const double horizontal = std::cos(latitude);
  return {horizontal * std::sin(longitude), std::sin(latitude), horizontal * std::cos(longitude)};
}

double latLongTexelSolidAngle(int row, int width, int height) {
  const double top = kPi * (0.5 - static_cast<double>(row) / height);
  return 2 * kPi / width * (std::sin(top) - std::sin(top - kPi / height));
}

std::array<double, 2> latLongOfDirection(const Vec3& direction) {
  const double longitude = std::atan2(direction.x(), direction.z());
  const double latitude = std::atan2(direction.y(), std::hypot(direction.x(), direction.z()));
  return {0.5 - longitude / (2 * kPi), 0.5 - latitude / kPi};
}

ShLight projectLatLong(const formats::Image& image, int order, const std::string& file) {
  checkLatLong(image, file);
  const auto channels = colorChannels(image, file);
  std::vector<std::vector<double>> rows(image.height);
  tbb::parallel_for(0, image.height, [&](int row) { rows[row] = rowSums(image, row, order, channels); });

  return lightFromParts(rows, order);
}

ShLight lightFromParts(std::span<const std::vector<double>> parts, int order) {
  const int count = coefficientCount(order);
  std::vector<double> total(3 * static_cast<std::size_t>(count), 0.0);
  for (const auto& part : parts)
    for (std::size_t i = 0; i < total.size(); ++i) total[i] += part[i];
  ShLight light(count);
  for (int i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) light[i][c] = static_cast<float>(total[c * count + i]);
  return light;
}

formats::Image rgbImage(const formats::Image& image, const std::string& file) {
  const auto channels = colorChannels(image, file);
  formats::Image rgb(image.width, image.height, {"R", "G", "B"});
  for (std::size_t texel = 0; 3 * texel < rgb.values.size(); ++texel)
    for (std::size_t c = 0; c < 3; ++c)
      rgb.values[3 * texel + c] = image.values[texel * image.channelCount() + channels[c]];
  return rgb;
}

Float3 lookUpLatLong(const formats::Image& image, const Vec3& direction) {
  const auto [u, v] = latLongOfDirection(direction);
  const double x = u * image.width - 0.5, y = std::clamp(v * image.height - 0.5, 0.0, image.height - 1.0);
  const int column = static_cast<int>(std::floor(x)), row = std::min(static_cast<int>(y), image.height - 1);
  const int left = (column + image.width) % image.width, right = (left + 1) % image.width;
  const int below = std::min(row + 1, image.height - 1);
  const auto across = static_cast<float>(x - column), down = static_cast<float>(y - row);

  const std::array<std::size_t, 3> channels = colorChannels(image, "environment");
  Float3 radiance;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto at = [&](int tx, int ty) { return image.texel(tx, ty)[channels[c]]; };
    const float upper = at(left, row) + across * (at(right, row) - at(left, row));
    const float lower = at(left, below) + across * (at(right, below) - at(left, below));
    radiance[c] = upper + down * (lower - upper);
  }
  return radiance;
}

ShLight diskLight(int order, const Vec3& axis, double half_angle_rad, const Float3& radiance) {
  return tinted(orientZonal(diskLightZonal(order, half_angle_rad), axis), radiance);
}

ShLight directionalLight(int order, const Vec3& direction, const Float3& irradiance) {
  return tinted(evaluateSh(order, direction), irradiance);
}

ShLight polygonLight(int order, std::span<const Vec3> vertices, const Float3& radiance) {
  return tinted(polygonSh(order, vertices), radiance);
}

ShLight uniformLight(int order, const Float3& radiance) {
  ShLight light(coefficientCount(order), Float3{0, 0, 0});
  for (std::size_t c = 0; c < 3; ++c) light[0][c] = static_cast<float>(std::sqrt(4 * kPi) * radiance[c]);
  return light;
}

ShLight sum(const ShLight& a, const ShLight& b) {
  ShLight total = a;
  for (std::size_t i = 0; i < total.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) total[i][c] += b.at(i)[c];
  return total;
}

ShLight scaled(const ShLight& light, double factor) {
  ShLight product = light;
  for (Float3& coefficient : product)
    for (float& value : coefficient) value = static_cast<float>(value * factor);
  return product;
}

double luminance(const Float3& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

ShLight defaultLight(int order) {
  const DefaultLight light;
  return sum(diskLight(order, light.key_direction, light.key_half_angle_rad, light.key_radiance),
             uniformLight(order, light.sky_radiance));
}

}  // namespace bakelight::transport
