#include "tests/e2e/player_comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <vector>

#include "formats/image.h"
#include "formats/pack.h"
#include "tests/e2e/silhouette.h"
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
  const transport::PictureGrid grid{settings.width_px, settings.height_px, settings.supersampling};
  const auto picture =
      transport::renderOnCpu(pack.mesh, scene, radiance, camera, grid, backdropOf(environment, settings));
  CpuFrame frame;
  const auto exposure = static_cast<float>(player::exposureFactor(settings, environment.light));
  frame.display = transport::encodeForDisplay(picture.linear, exposure);
  frame.silhouette = silhouettePixels(pack.mesh, picture, camera, grid);
  const std::size_t columns = static_cast<std::size_t>(grid.width_px) * grid.supersampling;
  for (int y = 0; y < grid.height_px; ++y)
    for (int x = 0; x < grid.width_px; ++x) {
      const std::size_t first_subsample = (y * columns + x) * grid.supersampling;
      frame.object.push_back(picture.hits[first_subsample].valid());
    }
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
