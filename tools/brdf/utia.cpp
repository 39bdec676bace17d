#include "tools/brdf/utia.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "formats/error.h"

namespace bakelight::brdf {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kPolar = kUtiaPolarAngles, kAround = kUtiaAzimuths, kDirections = kPolar * kAround;
constexpr std::size_t kPlane = kDirections * kDirections, kFileSize = 3 * kPlane * sizeof(double);
constexpr double kPolarStep_rad = 15 * kPi / 180, kAzimuthStep_rad = 2 * kPi / kUtiaAzimuths;

// Means by polar angles of light and view and the difference of azimuths.
struct Table {
  std::array<std::array<std::array<Vec3, kAround>, kPolar>, kPolar> values;
};

struct Between {
  std::size_t low, high;
  double share;  // of the high one
};
Between betweenPolar(double angle_rad) {
  const double at = std::min(angle_rad / kPolarStep_rad, static_cast<double>(kPolar - 1));
  const std::size_t low = std::min(static_cast<std::size_t>(at), kPolar - 2);
  return {low, low + 1, at - static_cast<double>(low)};
}
Between betweenAzimuths(double angle_rad) {
  double at = std::fmod(angle_rad / kAzimuthStep_rad, static_cast<double>(kAround));
  if (at < 0) at += static_cast<double>(kAround);
  const std::size_t low = static_cast<std::size_t>(at) % kAround;
  return {low, (low + 1) % kAround, at - std::floor(at)};
}

double polarOf(const Vec3& direction) {
  return std::atan2(std::hypot(direction.x(), direction.y()), direction.z());
}

Vec3 interpolated(const Table& table, const Vec3& incident, const Vec3& outgoing) {
  const Between light = betweenPolar(polarOf(incident)), view = betweenPolar(polarOf(outgoing));
  const Between turn =
      betweenAzimuths(std::atan2(outgoing.y(), outgoing.x()) - std::atan2(incident.y(), incident.x()));
  Vec3 sum = Vec3::Zero();
  for (const auto& [l, of_light] :
       {std::pair(light.low, 1 - light.share), std::pair(light.high, light.share)})
    for (const auto& [v, of_view] : {std::pair(view.low, 1 - view.share), std::pair(view.high, view.share)})
      for (const auto& [t, of_turn] : {std::pair(turn.low, 1 - turn.share), std::pair(turn.high, turn.share)})
        sum += of_light * of_view * of_turn * table.values[l][v][t];
  return sum;
}

}  // namespace

MeasuredBrdf readUtia(std::span<const std::byte> bytes, const std::string& file) {
  if (bytes.size() != kFileSize)
    throw badInput({file, "", ""}, "the file has " + std::to_string(bytes.size()) + " bytes",
                   std::to_string(kFileSize) + " bytes: three planes of 288 × 288 doubles",
                   "take a .bin file of the UTIA BRDF database, and check that it is whole");
  std::vector<double> values(3 * kPlane);
  std::memcpy(values.data(), bytes.data(), bytes.size());
  std::size_t negative = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i]))
      throw badInput({file, "value " + std::to_string(i), ""}, "it is not finite", "a number");
    if (values[i] < 0) ++negative, values[i] = 0;
  }
  const auto at = [&](std::size_t c, std::size_t l, std::size_t a, std::size_t v, std::size_t b) {
    return values[c * kPlane + kDirections * (kAround * l + a) + kAround * v + b];
  };
  const auto table = std::make_shared<Table>();
  double differences = 0, squares = 0;
  for (std::size_t l = 0; l < kPolar; ++l)
    for (std::size_t v = 0; v < kPolar; ++v) {
      for (std::size_t turn = 0; turn < kAround; ++turn)
        for (std::size_t c = 0; c < 3; ++c) {
          double sum = 0;
          for (std::size_t a = 0; a < kAround; ++a)
            sum += at(c, l, a, v, (a + turn) % kAround) + at(c, l, a, v, (a + kAround - turn) % kAround);
          table->values[l][v][turn][static_cast<Eigen::Index>(c)] = sum / (2 * kAround);
        }
      // By the solid angles that the polar angles stand for.
      const double weight = std::sin(static_cast<double>(l) * kPolarStep_rad + 0.05) *
                            std::sin(static_cast<double>(v) * kPolarStep_rad + 0.05);
      for (std::size_t turn = 0; turn < kAround; ++turn)
        for (std::size_t a = 0; a < kAround; ++a)
          for (std::size_t c = 0; c < 3; ++c) {
            const double value = at(c, l, a, v, (a + turn) % kAround);
            const double difference = value - table->values[l][v][turn][static_cast<Eigen::Index>(c)];
            differences += weight * difference * difference;
            squares += weight * value * value;
          }
    }
  MeasuredBrdf measured;
  measured.brdf = [table](const Vec3& incident, const Vec3& outgoing) -> Vec3 {
    return interpolated(*table, incident, outgoing);
  };
  measured.anisotropy = squares > 0 ? std::sqrt(differences / squares) : 0;
  if (negative > 0) measured.notes.push_back(std::to_string(negative) + " negative values count as 0");
  return measured;
}

}  // namespace bakelight::brdf
