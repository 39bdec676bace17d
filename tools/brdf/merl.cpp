#include "tools/brdf/merl.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <numbers>

#include "formats/error.h"

namespace bakelight::brdf {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kValues =
    static_cast<std::size_t>(kMerlHalfAngles) * kMerlDifferenceAngles * kMerlAzimuths;
constexpr std::array<std::int32_t, 3> kSizes = {kMerlHalfAngles, kMerlDifferenceAngles, kMerlAzimuths};
constexpr std::size_t kHeader = sizeof(kSizes), kFileSize = kHeader + 3 * kValues * sizeof(double);
constexpr std::array<double, 3> kScale = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};

int cell(double position, int count) {
  return std::clamp(static_cast<int>(position), 0, count - 1);
}

// Rusinkiewicz's half and difference angles, as the database indexes them.
std::size_t indexOf(const Vec3& incident, const Vec3& outgoing) {
  const Vec3 half = (incident + outgoing).normalized();
  const double half_angle = std::acos(std::clamp(half.z(), -1.0, 1.0));
  const double azimuth = std::atan2(half.y(), half.x());
  const Vec3 difference =
      Eigen::AngleAxisd(-half_angle, Vec3::UnitY()) * (Eigen::AngleAxisd(-azimuth, Vec3::UnitZ()) * incident);
  const double difference_angle = std::acos(std::clamp(difference.z(), -1.0, 1.0));
  double turn = std::atan2(difference.y(), difference.x());
  if (turn < 0) turn += kPi;

  const int i = cell(std::sqrt(std::max(half_angle, 0.0) / (kPi / 2)) * kMerlHalfAngles, kMerlHalfAngles);
  const int j = cell(difference_angle / (kPi / 2) * kMerlDifferenceAngles, kMerlDifferenceAngles);
  const int k = cell(turn / kPi * kMerlAzimuths, kMerlAzimuths);
  return (static_cast<std::size_t>(i) * kMerlDifferenceAngles + j) * kMerlAzimuths + k;
}

}  // namespace

Brdf readMerl(std::span<const std::byte> bytes, const std::string& file) {
  std::array<std::int32_t, 3> sizes{};
  if (bytes.size() >= kHeader) std::memcpy(sizes.data(), bytes.data(), kHeader);
  if (sizes != kSizes)
    throw badInput({file, "header", ""}, "this is not an isotropic BRDF of the MERL database",
                   "the sizes 90, 90 and 180", "take a .binary file of that database");
  if (bytes.size() != kFileSize)
    throw badInput({file, "", ""}, "the file has " + std::to_string(bytes.size()) + " bytes",
                   std::to_string(kFileSize) + " bytes", "it may be cut off; fetch it again");
  const auto values = std::make_shared<std::vector<double>>(3 * kValues);
  std::memcpy(values->data(), bytes.data() + kHeader, 3 * kValues * sizeof(double));
  for (std::size_t v = 0; v < values->size(); ++v)
    if (!std::isfinite((*values)[v]))
      throw badInput({file, "value " + std::to_string(v), ""}, "it is not finite", "a number");
  return [values](const Vec3& incident, const Vec3& outgoing) -> Vec3 {
    const std::size_t index = indexOf(incident, outgoing);
    Vec3 value;
    for (std::size_t c = 0; c < 3; ++c) value[c] = std::max((*values)[c * kValues + index], 0.0) * kScale[c];
    return value;
  };
}

}  // namespace bakelight::brdf
