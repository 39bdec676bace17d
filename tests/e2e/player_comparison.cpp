#include "tests/e2e/player_comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "formats/btf_reflection.h"
#include "formats/image.h"
#include "formats/light_rig_file.h"
#include "formats/neighborhood.h"
#include "formats/pack.h"
#include "formats/rtt_reflection.h"
#include "tests/e2e/silhouette.h"
#include "tests/support/pack_parts.h"
#include "transport/cpu_renderer.h"
#include "transport/frame.h"
#include "transport/light_rig.h"
#include "transport/lighting.h"
#include "transport/near_light.h"
#include "transport/neighborhood_shading.h"
#include "transport/sh.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;
using transport::Vec3;

std::string quoted(const fs::path& path) {
  std::string text = "'";
  text += path.string();
  return text += "'";
}

void runPlayer(const fs::path& executable, const fs::path& pack_path, const PlayerLights& lights,
               const formats::FrameSettings& settings, const PlayerSurroundings& surroundings,
               const fs::path& picture_path) {
  std::string command =
      quoted(executable) + " --pack " + quoted(pack_path) + " --image " + quoted(picture_path);
  if (!lights.environment_path.empty()) command += " --environment " + quoted(lights.environment_path);
  if (!lights.rig_path.empty()) command += " --lights " + quoted(lights.rig_path);
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
  option("object-yaw-deg", std::to_string(settings.object_yaw_deg));
  option("object-pitch-deg", std::to_string(settings.object_pitch_deg));
  option("time-s", std::to_string(settings.time_s));
  if (lights.windowing)
    option("windowing", *lights.windowing < 0 ? "auto" : formats::Json(*lights.windowing).dump());
  option("cube-resolution", std::to_string(lights.cube_resolution));
  option("auto-exposure", settings.auto_exposure ? "true" : "false");
  option("exposure-ev", std::to_string(settings.exposure_ev));
  option("background", formats::wordFor(formats::kBackgrounds, settings.background));
  const auto list = [&](const std::string& name, const formats::Float3& values) {
    command += " --" + name;
    for (const float value : values) command += " " + std::to_string(value);
  };
  option("ground", surroundings.ground_albedo ? "on" : "off");
  if (surroundings.ground_albedo) list("ground-albedo", *surroundings.ground_albedo);
  if (const auto& receiver = surroundings.receiver) {
    option("receiver", "sphere");
    option("receiver-radius", std::to_string(receiver->radius));
    option("receiver-orbit-s", std::to_string(receiver->orbit_s));
    list("receiver-position", receiver->position);
    list("receiver-albedo", receiver->albedo);
  }
  const int status = std::system(command.c_str());
  if (status != 0) throw std::runtime_error("failed (" + std::to_string(status) + "): " + command);
}

// All that the comparison needs of the CPU's picture.
struct CpuFrame {
  formats::Image display;
  std::vector<bool> silhouette;  // pixels
  enum class Seen { kBackdrop, kObject, kEmitter };
  std::vector<Seen> seen;  // by the first subsample of each pixel
};

transport::Backdrop backdropOf(const transport::Lighting& lighting, const formats::FrameSettings& settings) {
  const Eigen::Matrix3d light_from_world = transport::worldFromLight(settings).transpose();
  return [&lighting, background = settings.background,
          light_from_world](const Vec3& direction) -> formats::Float4 {
    if (background == formats::Background::kTransparent) return {0, 0, 0, 0};
    if (background == formats::Background::kBlack) return {0, 0, 0, 1};
    const auto radiance = transport::lookUpLatLong(lighting.backdrop, light_from_world * direction);
    return {radiance[0], radiance[1], radiance[2], 1};
  };
}

void append(formats::TriangleMesh& mesh, const formats::TriangleMesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({first + a, first + b, first + c});
}

// The light around an object, in its frame.
struct SurroundingLight {
  transport::ShLight distant, near;
};

// The receiver in the world, and its radiance.
transport::EmitterMesh receiverMesh(const formats::Neighborhood& neighborhood,
                                    const transport::Receiver& receiver, const SurroundingLight& light,
                                    const transport::BoundingSphere& bounds,
                                    const Eigen::Matrix3d& world_from_object, double time_s) {
  transport::VolumeShading volume(neighborhood);
  volume.setLight(light.distant, light.near);
  transport::EmitterMesh result;
  result.mesh = receiver.mesh;
  for (std::size_t v = 0; v < receiver.mesh.vertexCount(); ++v) {
    const Vec3 from_middle = bounds.radius * (receiver.middleAt(time_s) +
                                              receiver.radius * transport::vec3(receiver.mesh.positions[v]));
    result.mesh.positions[v] = transport::float3(bounds.center + from_middle);
    transport::Float3 radiance =
        volume.radiosityAt(bounds.center + world_from_object.transpose() * from_middle,
                           world_from_object.transpose() * transport::vec3(receiver.mesh.normals[v]));
    for (std::size_t c = 0; c < 3; ++c) radiance[c] *= receiver.albedo[c];
    result.radiance.push_back(radiance);
  }
  return result;
}

transport::Backdrop withGround(const transport::Backdrop& behind, const formats::Neighborhood& neighborhood,
                               const formats::Float3& albedo, const SurroundingLight& light, const Vec3& eye,
                               const Eigen::Matrix3d& world_from_object) {
  auto ground = std::make_shared<transport::GroundShading>(neighborhood);
  ground->setLight(light.distant, light.near);
  return [=](const Vec3& direction) -> formats::Float4 {
    formats::Float4 seen = behind(direction);
    const formats::Float4 over = ground->seen(eye, world_from_object.transpose() * direction, albedo);
    for (std::size_t c = 0; c < 4; ++c) seen[c] = over[c] + (1 - over[3]) * seen[c];
    return seen;
  };
}

CpuFrame renderFrameOnCpu(const formats::Pack& pack, const transport::Lighting& lighting,
                          const formats::FrameSettings& settings, const PlayerSurroundings& surroundings) {
  const auto bounds = transport::boundingSphere(pack.mesh);
  const auto camera = transport::frameCamera(settings, bounds);
  const Eigen::Matrix3d world_from_object = transport::worldFromObject(settings);
  const std::unique_ptr<transport::PackShading> shading = transport::makePackShading(pack);
  const Vec3 eye = world_from_object.transpose() * (camera.eye() - bounds.center) + bounds.center;
  transport::lightShading(*shading, pack.mesh, lighting,
                          world_from_object.transpose() * transport::worldFromLight(settings),
                          world_from_object, settings.time_s);
  shading->setView({eye, camera.pixelAngle(settings.height_px * settings.supersampling)});

  formats::TriangleMesh scene_mesh;
  scene_mesh.positions = pack.mesh.positions;
  scene_mesh.triangles = pack.mesh.triangles;
  transport::turnAbout(bounds.center, world_from_object, scene_mesh.positions);
  transport::EmitterMesh emitters;
  if (!lighting.near.emitters.empty()) {
    emitters = transport::emitterMesh(lighting.near, bounds, settings.time_s);
    append(scene_mesh, emitters.mesh);
  }
  transport::Backdrop backdrop = backdropOf(lighting, settings);
  if (surroundings.ground_albedo || surroundings.receiver) {
    const auto& neighborhood = *pack.neighborhood.value().as<formats::Neighborhood>();
    const transport::ShRotation turn(neighborhood.order,
                                     world_from_object.transpose() * transport::worldFromLight(settings));
    const SurroundingLight light{
        turn.apply(lighting.distant),
        transport::nearLight(pack.mesh, shading->needs(), lighting, settings.time_s, world_from_object)};
    if (surroundings.ground_albedo)
      backdrop =
          withGround(backdrop, neighborhood, *surroundings.ground_albedo, light, eye, world_from_object);
    if (surroundings.receiver) {
      const transport::EmitterMesh receiver = receiverMesh(neighborhood, *surroundings.receiver, light,
                                                           bounds, world_from_object, settings.time_s);
      append(scene_mesh, receiver.mesh);
      append(emitters.mesh, receiver.mesh);
      emitters.radiance.insert(emitters.radiance.end(), receiver.radiance.begin(), receiver.radiance.end());
    }
  }
  const auto glow = transport::interpolated(emitters.mesh.triangles, emitters.radiance);
  const auto object_triangles = static_cast<std::uint32_t>(pack.mesh.triangleCount());
  const auto shade = [&](std::span<const transport::SurfaceHit> hits, std::span<transport::Float3> radiance) {
    for (std::size_t i = 0; i < hits.size(); ++i) {
      transport::SurfaceHit hit = hits[i];
      if (hit.triangle < object_triangles) {
        shading->radianceAt({&hit, 1}, radiance.subspan(i, 1));
      } else {
        hit.triangle -= object_triangles;
        glow({&hit, 1}, radiance.subspan(i, 1));
      }
    }
  };

  const transport::RayScene scene(scene_mesh);
  const transport::PictureGrid grid{settings.width_px, settings.height_px, settings.supersampling};
  const auto picture = transport::renderOnCpu(scene, shade, camera, grid, backdrop);
  CpuFrame frame;
  const auto exposure = static_cast<float>(
      transport::exposureFactor(settings, transport::exposureLight(pack.mesh, shading->needs(), lighting)));
  frame.display = transport::encodeForDisplay(picture.linear, exposure);
  frame.silhouette = silhouettePixels(scene_mesh, picture, camera, grid);
  const std::size_t columns = static_cast<std::size_t>(grid.width_px) * grid.supersampling;
  for (int y = 0; y < grid.height_px; ++y)
    for (int x = 0; x < grid.width_px; ++x) {
      const auto& hit = picture.hits[(y * columns + x) * grid.supersampling];
      const bool object = hit.valid() && hit.triangle < pack.mesh.triangleCount();
      frame.seen.push_back(!hit.valid() ? CpuFrame::Seen::kBackdrop
                           : object     ? CpuFrame::Seen::kObject
                                        : CpuFrame::Seen::kEmitter);
    }
  return frame;
}

std::size_t& countOf(CpuFrame::Seen seen, PlayerComparison& result) {
  if (seen == CpuFrame::Seen::kBackdrop) return result.backdrop_pixels;
  return seen == CpuFrame::Seen::kObject ? result.object_pixels : result.emitter_pixels;
}

int largestCodeDifference(const float* a, const float* b) {
  int largest = 0;
  for (int c = 0; c < 4; ++c)
    largest =
        std::max(largest, static_cast<int>(std::abs(std::lround(255 * a[c]) - std::lround(255 * b[c]))));
  return largest;
}

// Where the last digits of a position decide which texel of a texture is seen, which is never filtered, or which side of a
// crease: there the picture changes when the camera moves by a hair.
std::vector<bool> pixelsOnTexelEdges(const formats::Pack& pack, const transport::Lighting& lighting,
                                     const formats::FrameSettings& settings, const formats::Image& display) {
  std::vector<bool> result(static_cast<std::size_t>(display.width) * display.height, false);
  const auto isTextured = [](const formats::Appearance& appearance) {
    return appearance.reflection.as<formats::RttReflection>() != nullptr ||
           appearance.reflection.as<formats::BtfReflection>() != nullptr;
  };
  if (std::none_of(pack.appearances.begin(), pack.appearances.end(), isTextured)) return result;
  constexpr double kHair_deg = 0.01;  // of the camera's way around: a hundredth of a pixel
  for (const auto& [yaw_deg, pitch_deg] :
       {std::pair(kHair_deg, 0.0), {-kHair_deg, 0.0}, {0.0, kHair_deg}, {0.0, -kHair_deg}}) {
    formats::FrameSettings turned = settings;
    turned.yaw_deg += yaw_deg, turned.pitch_deg += pitch_deg;
    const formats::Image moved = renderFrameOnCpu(pack, lighting, turned, {}).display;
    for (std::size_t i = 0; i < result.size(); ++i)
      if (largestCodeDifference(&moved.values[4 * i], &display.values[4 * i]) > 1) result[i] = true;
  }
  return result;
}

}  // namespace

std::string PlayerComparison::summary() const {
  return "largest difference " + std::to_string(largest_difference) + "/255 at pixel " +
         std::to_string(worst_x) + ", " + std::to_string(worst_y) + "; " + std::to_string(differing_pixels) +
         " pixels differ; compared " + std::to_string(object_pixels) + " object, " +
         std::to_string(emitter_pixels) + " emitter and " + std::to_string(backdrop_pixels) +
         " backdrop pixels of " + std::to_string(pixels) + ", left out " + std::to_string(silhouette_pixels) +
         " silhouette pixels and " + std::to_string(texel_edge_pixels) + " on edges of texels";
}

PlayerComparison comparePlayerWithCpu(const fs::path& player_executable, const fs::path& pack_path,
                                      const PlayerLights& lights, const formats::FrameSettings& settings,
                                      const fs::path& folder, const PlayerSurroundings& surroundings) {
  const fs::path picture_path = folder / "player.png";
  runPlayer(player_executable, pack_path, lights, settings, surroundings, picture_path);
  const formats::Image played = formats::readImage(picture_path);

  const formats::Pack pack = formats::readPack(pack_path);
  transport::Lighting lighting = transport::lightingFor(
      formats::readLights(lights.environment_path, lights.rig_path, lights.windowing),
      std::max(transport::makePackShading(pack)->needs().sh_order, 1), lights.rig_path.string());
  lighting.cube_resolution = lights.cube_resolution;
  const CpuFrame cpu = renderFrameOnCpu(pack, lighting, settings, surroundings);
  const std::vector<bool> on_edges = pixelsOnTexelEdges(pack, lighting, settings, cpu.display);
  formats::writePng(folder / "cpu.png", cpu.display);
  if (played.width != cpu.display.width || played.height != cpu.display.height || played.channelCount() != 4)
    throw std::runtime_error(picture_path.string() + " has another size than was asked for");

  PlayerComparison result;
  const auto* sh = pack.transfer.as<formats::ShTransfer>();
  result.allowed_difference = sh != nullptr && storageOf(*sh) == formats::Storage::kNone ? 1 : 2;
  result.pixels = cpu.silhouette.size();
  for (int y = 0; y < played.height; ++y)
    for (int x = 0; x < played.width; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * played.width + x;
      if (cpu.silhouette[pixel]) {
        ++result.silhouette_pixels;
        continue;
      }
      if (on_edges[pixel]) {
        ++result.texel_edge_pixels;
        continue;
      }
      ++countOf(cpu.seen[pixel], result);
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
