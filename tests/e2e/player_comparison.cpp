#include "tests/e2e/player_comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <Eigen/Geometry>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "formats/image.h"
#include "formats/pack.h"
#include "tools/player/picture_file.h"
#include "transport/cpu_renderer.h"
#include "transport/evaluator.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;
using transport::Vec3;

std::string quoted(const fs::path& path) {
  std::string text = "'";
  text += path.string();
  return text += "'";
}

void runPlayer(const fs::path& executable, const fs::path& pack_path, const fs::path& environment_path,
               const player::FrameSettings& settings, const fs::path& picture_path) {
  std::string command =
      quoted(executable) + " --pack " + quoted(pack_path) + " --image " + quoted(picture_path);
  if (!environment_path.empty()) command += " --environment " + quoted(environment_path);
  const auto option = [&](const std::string& name, const std::string& value) {
    command += " --" + name + "=" + value;
  };
  option("width", std::to_string(settings.width_px));
  option("height", std::to_string(settings.height_px));
  option("supersampling", std::to_string(settings.supersampling));
  option("yaw-deg", std::to_string(settings.yaw_deg));
  option("pitch-deg", std::to_string(settings.pitch_deg));
  option("distance", std::to_string(settings.distance));
  option("field-of-view-deg", std::to_string(settings.field_of_view_deg));
  option("light-yaw-deg", std::to_string(settings.light_yaw_deg));
  option("light-pitch-deg", std::to_string(settings.light_pitch_deg));
  option("auto-exposure", settings.auto_exposure ? "true" : "false");
  option("exposure-ev", std::to_string(settings.exposure_ev));
  option("background", player::backgroundNames()[static_cast<std::size_t>(settings.background)]);
  const int status = std::system(command.c_str());
  if (status != 0) throw std::runtime_error("failed (" + std::to_string(status) + "): " + command);
}

// All that the comparison needs of the CPU's picture.
struct CpuFrame {
  formats::Image display;
  std::vector<bool> silhouette;  // pixels
  std::vector<bool> object;      // pixels whose first subsample hits
};

// Marks the pixels of subsamples that lie across an edge of visibility from their right or lower neighbour.
class SilhouetteFinder {
 public:
  SilhouetteFinder(const formats::TriangleMesh& mesh, const transport::CpuPicture& picture,
                   const transport::OrbitCamera& camera, int supersampling)
      : mesh_(mesh),
        hits_(picture.hits),
        camera_(camera),
        supersampling_(supersampling),
        columns_(picture.linear.width * supersampling),
        rows_(picture.linear.height * supersampling),
        footprint_rad_(camera.field_of_view_deg * std::numbers::pi / 180 / rows_) {}

  std::vector<bool> silhouettePixels() const {
    const int width = columns_ / supersampling_, height = rows_ / supersampling_;
    std::vector<bool> silhouette(static_cast<std::size_t>(width) * height, false);
    const auto markAround = [&](int column, int row) {
      const int x = column / supersampling_, y = row / supersampling_;
      for (int j = std::max(y - 1, 0); j <= std::min(y + 1, height - 1); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, width - 1); ++i)
          silhouette[static_cast<std::size_t>(j) * width + i] = true;
    };
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column) {
        if (column + 1 < columns_ && edgeBetween(column, row, column + 1, row)) markAround(column, row);
        if (row + 1 < rows_ && edgeBetween(column, row, column, row + 1)) markAround(column, row);
      }
    return silhouette;
  }

 private:
  const transport::SubsampleHit& hit(int column, int row) const {
    return hits_[static_cast<std::size_t>(row) * columns_ + column];
  }
  Vec3 direction(int column, int row) const {
    return camera_.directionThrough(column + 0.5, row + 0.5, columns_, rows_);
  }
  Vec3 corner(std::uint32_t triangle, std::size_t k) const {
    return transport::vec3(mesh_.positions[mesh_.triangles[triangle][k]]);
  }
  // Unit, towards the viewer.
  Vec3 facingNormal(std::uint32_t triangle, const Vec3& towards) const {
    const Vec3 origin = corner(triangle, 0);
    const Vec3 normal = (corner(triangle, 1) - origin).cross(corner(triangle, 2) - origin).normalized();
    return normal.dot(towards) > 0 ? -normal : normal;
  }

  // A surface that goes on stays near its own tangent plane from one subsample to the next; a jump leaves the
  // plane of one of the two, or both are seen so flatly that the depth leaps.
  bool edgeBetween(int column_a, int row_a, int column_b, int row_b) const {
    const auto &a = hit(column_a, row_a), &b = hit(column_b, row_b);
    if (a.valid() != b.valid()) return true;
    if (!a.valid() || a.triangle == b.triangle) return false;
    const Vec3 direction_a = direction(column_a, row_a), direction_b = direction(column_b, row_b);
    const Vec3 step = b.distance * direction_b - a.distance * direction_a;
    const double footprint = footprint_rad_ * std::min(a.distance, b.distance);
    const double off_plane = std::max(std::abs(step.dot(facingNormal(a.triangle, direction_a))),
                                      std::abs(step.dot(facingNormal(b.triangle, direction_b))));
    return off_plane > kOffPlaneFootprints * footprint || step.norm() > kStepFootprints * footprint;
  }

  static constexpr double kOffPlaneFootprints = 1, kStepFootprints = 12;

  const formats::TriangleMesh& mesh_;
  const std::vector<transport::SubsampleHit>& hits_;
  const transport::OrbitCamera camera_;
  const int supersampling_, columns_, rows_;
  const double footprint_rad_;
};

transport::Backdrop backdropOf(const player::Environment& environment,
                               const player::FrameSettings& settings) {
  const Eigen::Matrix3d light_from_world = player::worldFromLight(settings).transpose();
  return [&environment, background = settings.background,
          light_from_world](const Vec3& direction) -> formats::Float4 {
    if (background == player::Background::kTransparent) return {0, 0, 0, 0};
    if (background == player::Background::kBlack) return {0, 0, 0, 1};
    const auto radiance = transport::lookUpLatLong(environment.image, light_from_world * direction);
    return {radiance[0], radiance[1], radiance[2], 1};
  };
}

CpuFrame renderFrameOnCpu(const formats::Pack& pack, const player::Environment& environment,
                          const player::FrameSettings& settings) {
  const transport::ShRotation rotation(pack.transfer.order, player::worldFromLight(settings));
  const auto light = rotation.apply(environment.light);
  auto radiance = transport::evaluateDiffuse(pack.transfer.vectors, pack.transfer.order, light);
  for (auto& vertex : radiance)
    for (std::size_t c = 0; c < 3; ++c) vertex[c] *= pack.base_color[c];

  const auto camera = player::frameCamera(settings, transport::boundingSphere(pack.mesh));
  const transport::RayScene scene(pack.mesh);
  const auto picture = transport::renderOnCpu(pack.mesh, scene, radiance, camera,
                                              {settings.width_px, settings.height_px, settings.supersampling},
                                              backdropOf(environment, settings));
  CpuFrame frame;
  const auto exposure = static_cast<float>(player::exposureFactor(settings, environment.light));
  frame.display = transport::encodeForDisplay(picture.linear, exposure);
  frame.silhouette = SilhouetteFinder(pack.mesh, picture, camera, settings.supersampling).silhouettePixels();
  const std::size_t columns = static_cast<std::size_t>(settings.width_px) * settings.supersampling;
  for (int y = 0; y < settings.height_px; ++y)
    for (int x = 0; x < settings.width_px; ++x)
      frame.object.push_back(picture
                                 .hits[y * settings.supersampling * columns +
                                       static_cast<std::size_t>(x) * settings.supersampling]
                                 .valid());
  return frame;
}

int largestCodeDifference(const float* a, const float* b) {
  int largest = 0;
  for (int c = 0; c < 4; ++c)
    largest =
        std::max(largest, static_cast<int>(std::abs(std::lround(255 * a[c]) - std::lround(255 * b[c]))));
  return largest;
}

}  // namespace

std::string PlayerComparison::summary() const {
  return "largest difference " + std::to_string(largest_difference) + "/255 at pixel " +
         std::to_string(worst_x) + ", " + std::to_string(worst_y) + "; " + std::to_string(differing_pixels) +
         " pixels differ; compared " + std::to_string(object_pixels) + " object and " +
         std::to_string(backdrop_pixels) + " backdrop pixels of " + std::to_string(pixels) + ", left out " +
         std::to_string(silhouette_pixels) + " silhouette pixels";
}

PlayerComparison comparePlayerWithCpu(const fs::path& player_executable, const fs::path& pack_path,
                                      const fs::path& environment_path, const player::FrameSettings& settings,
                                      const fs::path& folder) {
  const fs::path picture_path = folder / "player.png";
  runPlayer(player_executable, pack_path, environment_path, settings, picture_path);
  const formats::Image played = formats::readImage(picture_path);

  const formats::Pack pack = formats::readPack(pack_path);
  const player::Environment environment =
      environment_path.empty() ? player::defaultEnvironment(pack.transfer.order)
                               : player::readEnvironment(environment_path, pack.transfer.order);
  const CpuFrame cpu = renderFrameOnCpu(pack, environment, settings);
  formats::writePng(folder / "cpu.png", cpu.display);
  if (played.width != cpu.display.width || played.height != cpu.display.height || played.channelCount() != 4)
    throw std::runtime_error(picture_path.string() + " has another size than was asked for");

  PlayerComparison result;
  result.pixels = cpu.silhouette.size();
  for (int y = 0; y < played.height; ++y)
    for (int x = 0; x < played.width; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * played.width + x;
      if (cpu.silhouette[pixel]) {
        ++result.silhouette_pixels;
        continue;
      }
      ++(cpu.object[pixel] ? result.object_pixels : result.backdrop_pixels);
      const int difference = largestCodeDifference(played.texel(x, y), cpu.display.texel(x, y));
      if (difference > 0) ++result.differing_pixels;
      if (difference > result.largest_difference) {
        result.largest_difference = difference;
        result.worst_x = x;
        result.worst_y = y;
      }
    }
  return result;
}

}  // namespace bakelight::tests
