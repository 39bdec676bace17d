#include "tests/e2e/player_comparison.h"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <cstdlib>

#include "formats/file.h"
#include "formats/image.h"
#include "formats/json.h"
#include "formats/neighborhood.h"
#include "formats/pack.h"
#include "tests/e2e/made_packs.h"
#include "tests/support/compressed_transfer.h"
#include "tests/support/made_pixel_pack.h"
#include "tests/support/made_rtt.h"
#include "tests/support/made_translucent_pack.h"
#include "transport/camera.h"
#include "transport/lights.h"
#include "transport/texture_frames.h"
#include "transport/translucent_shading.h"
#include "transport/translucent_tables.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;

const fs::path kPlayer = fs::path(BAKELIGHT_BIN_DIR) / "player";

// Coloured waves of fine and coarse detail, and a sun a hundred times brighter.
formats::Image skyWithSun() {
  formats::Image sky(256, 128, {"R", "G", "B"});
  const transport::Vec3 sun = transport::Vec3(0.4, 0.5, -0.8).normalized();
  for (int y = 0; y < sky.height; ++y)
    for (int x = 0; x < sky.width; ++x) {
      const auto direction = transport::directionOfLatLong((x + 0.5) / sky.width, (y + 0.5) / sky.height);
      float* texel = sky.texel(x, y);
      for (int c = 0; c < 3; ++c)
        texel[c] =
            static_cast<float>(0.6 + 0.3 * direction[c] + 0.2 * std::sin(0.3 * x + c) * std::sin(0.4 * y) +
                               (direction.dot(sun) > 0.995 ? 60 : 0));
    }
  return sky;
}

class PlayerAgainstCpu : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("bakelight-e2e-" + std::string(test->name()));
    fs::create_directories(folder_);
    formats::writeExr(folder_ / "sky.exr", skyWithSun(), formats::ExrPrecision::kFloat);
  }
  void TearDown() override {
    if (!HasFailure()) fs::remove_all(folder_);
  }

  PlayerComparison compare(const formats::Pack& pack, const formats::FrameSettings& settings,
                           const PlayerLights& lights, const PlayerSurroundings& surroundings = {}) {
    formats::writePack(folder_ / "made.glb", pack, {});
    const auto result =
        comparePlayerWithCpu(kPlayer, folder_ / "made.glb", lights, settings, folder_, surroundings);
    EXPECT_TRUE(result.agrees()) << result.summary() << "; pictures in " << folder_;
    RecordProperty("comparison", result.summary());
    std::printf("%s\n", result.summary().c_str());
    return result;
  }

  PlayerLights sky() const { return {.environment_path = folder_ / "sky.exr"}; }
  PlayerLights rig(const std::string& json) const {
    formats::writeFileAtomically(folder_ / "rig.json", json);
    return {.rig_path = folder_ / "rig.json"};
  }

  fs::path folder_;
};

constexpr formats::FrameSettings kSmall = {.width_px = 320, .height_px = 240};

// Radiance transfer textures by texture coordinates and by an index, of few components and of so many that they take several
// draws; large, and so small that levels of the pyramid are blended.
TEST_F(PlayerAgainstCpu, RadianceTransferTextures) {
  for (const formats::Storage storage : {formats::Storage::kMatrix, formats::Storage::kVisibility})
    for (const int components : {3, 21}) {
      SCOPED_TRACE(components);
      formats::Pack pack = wavyPack(3, 24);
      addGlossyTransfer(pack, 3, storage);
      addSphericalTexcoords(pack.mesh);
      // Those of made transfer turn and change hands from vertex to vertex, which no patch lies along.
      pack.sh().glossy->tangents = transport::textureFrames(pack.mesh).tangents;
      for (formats::Float4& tangent : pack.sh().glossy->tangents) tangent[3] = 1;  // at the seam, too
      formats::RttReflection rtt = madeRtt(3, 4, 8, 6, components);
      rtt.repeats = 3;
      const bool relief = (components > 16) == (storage == formats::Storage::kMatrix);
      if (!relief) rtt.heights.reset();
      if (components > 16) rtt.index = madeIndex(64, 32);
      formats::reflectionOf(pack) = rtt;
      const PlayerComparison near = compare(pack, kSmall, sky());
      EXPECT_LT(near.texel_edge_pixels * 5, near.object_pixels);
      rtt.patch_width = 0.01F;  // a pixel covers several texels
      formats::reflectionOf(pack) = rtt;
      compare(pack, kSmall, sky());
    }
}

// Uneven light on a plate that it goes through, from above and aslant, where Fresnel's share matters.
TEST_F(PlayerAgainstCpu, TranslucentObjects) {
  formats::Pack pack = translucentPack(64, mediumOf(2.5), 4, 0.5F);
  for (const formats::Float3& position : pack.mesh.positions)
    pack.colors.push_back({0.5F + 0.5F * std::sin(position[0]), 1, 0.8F});
  for (const double pitch : {70.0, 45.0}) {
    formats::FrameSettings settings = kSmall;
    settings.pitch_deg = pitch;
    compare(pack, settings, sky());
  }
}

// Emitters, too, by the same vectors as distant light; tables as packs have them without far knots and without components of kernels.
TEST_F(PlayerAgainstCpu, TranslucentObjectsByEmittersWithFewerTables) {
  formats::Pack pack = translucentPack(64, mediumOf(2.5), 4, 0.5F);
  auto& translucency = *formats::reflectionOf(pack).as<formats::Translucency>();
  ASSERT_GT(translucency.components, 0);
  translucency.kernels =
      formats::encodeTable(transport::expandedKernels(translucency), std::size_t{3} * formats::kKernelTexels,
                           formats::Precision::kFloat32, "", "");
  translucency.components = 0, translucency.basis.clear();
  translucency.far_count = 0, translucency.spread = {}, translucency.far = {};
  formats::FrameSettings settings = kSmall;
  settings.pitch_deg = 60;
  compare(pack, settings, rig(R"({"units": "object",
    "lights": [{"type": "disk", "direction": [1, 2, 0.5], "half_angle_deg": 20, "radiance": [3, 2.5, 2]}],
    "emitters": [{"shape": "sphere", "position": [1, 1.5, 1], "radius": 0.4, "radiance": [6, 8, 12]}]})"));
}

// A plate with a ridge, behind which low lights throw shadows: from outside, where one view sees the plate, and from so near that it takes a
// cube; slides, cones and points, moving, around an object that is turned. Edges of shadows differ by a texel of the shadow map, a fraction of the atlas's; what of
// that is left after 7 × 7 kernels may be seen in few pixels.
TEST_F(PlayerAgainstCpu, TranslucentObjectsUnderPunctualLights) {
  formats::Pack pack = translucentPack(64, mediumOf(2.5), 4, 0);
  for (std::size_t v = 0; v < pack.mesh.vertexCount(); ++v) {
    formats::Float3& position = pack.mesh.positions[v];
    const float across = (position[0] - 30) / 4, height = 12 * std::exp(-across * across);
    position[1] = height;
    pack.mesh.normals[v] =
        transport::float3(transport::Vec3(2.0 * static_cast<double>(across * height / 4), 1, 0).normalized());
  }
  formats::Image slide(4, 4, {"R", "G", "B"});
  for (int i = 0; i < 16; ++i)
    for (int c = 0; c < 3; ++c)
      slide.texel(i % 4, i / 4)[c] = (i + i / 4) % 2 == 0 ? 1.0F : 0.1F * static_cast<float>(c);
  formats::writeExr(folder_ / "slide.exr", slide);
  const char* rigs[] = {
      R"({"type": "point", "position": [-0.9, 0.35, 0.1], "intensity": [2, 1, 3]})",
      R"({"type": "point", "position": [-2, 1, 0.5], "intensity": [9, 12, 6],
          "motion": {"kind": "orbit", "period_s": 5}})",
      R"({"type": "spot", "position": [1.5, 1.5, 0.5], "direction": [-1.5, -1.4, -0.5], "intensity": [9, 12, 6],
          "inner_half_angle_deg": 8, "outer_half_angle_deg": 12})",
      R"({"type": "slide", "position": [-2, 2, 1], "direction": [2, -2, -1], "up": [0, 0, -1],
          "field_of_view_deg": 30, "image": "slide.exr", "intensity": [15, 15, 15]})"};
  for (const char* light : rigs) {
    SCOPED_TRACE(light);
    formats::FrameSettings settings = kSmall;
    settings.pitch_deg = 55;
    settings.object_yaw_deg = 20;
    settings.time_s = 0.3;
    settings.exposure_ev = -1;
    const std::string sky =
        R"({"lights": [{"type": "disk", "half_angle_deg": 180, "radiance": [0.1, 0.1, 0.1]}],)";
    compare(pack, settings, rig(sky + R"("punctual": [)" + light + "]}"));
  }
}

// Each branch on its own, as --branches shows it.
TEST_F(PlayerAgainstCpu, BranchesOfTranslucentObjects) {
  const formats::Pack pack = translucentPack(64, mediumOf(2.5), 4, 0.5F);
  formats::writePack(folder_ / "whole.glb", pack, {});
  formats::writePack(folder_ / "other.glb", wavyPack(3, 16), {});
  formats::FrameSettings settings = kSmall;
  settings.pitch_deg = 60;
  const auto play = [&](const std::string& name, const std::string& branches) {
    const auto quoted = [&](const char* file) { return "'" + (folder_ / file).string() + "'"; };
    const std::string command = "'" + kPlayer.string() + "' " + quoted(name.c_str()) + " --environment " +
                                quoted("sky.exr") + " --width 320 --height 240 --pitch-deg 60 --branches " +
                                branches + " --image " + quoted("shown.png") + " --stats " +
                                quoted("stats.json") + " 2> " + quoted("log");
    return std::system(command.c_str());
  };
  for (const auto& [word, branches] : transport::kTranslucentBranches) {
    SCOPED_TRACE(word);
    compare(transport::withBranches(pack, branches), settings, sky());
    ASSERT_EQ(play("whole.glb", word), 0);
    EXPECT_EQ(formats::readFile(folder_ / "shown.png"), formats::readFile(folder_ / "player.png"));
  }
  ASSERT_EQ(play("whole.glb", "both"), 0);
  const formats::Json stats = formats::readJson(folder_ / "stats.json")["stats"],
                      &cost = stats["cost_by_pass"];
  double total = 0;
  for (const char* part :
       {"illumination_map_ms", "local_ms", "distribution_ms", "throughput_ms", "display_ms"}) {
    EXPECT_GT(cost[part].get<double>(), 0) << part;
    total += cost[part].get<double>();
  }
  EXPECT_NEAR(cost["total_ms"].get<double>(), total, 1e-9 * total);
  EXPECT_EQ(cost["throughput_ms"], stats["gpu_pass_ms"]["throughput"]);
  const auto& translucency = *pack.appearances.front().reflection.as<formats::Translucency>();
  EXPECT_EQ(cost["vertices"], translucency.knot_count);
  EXPECT_EQ(cost["factors"], translucency.near.columns.count() + translucency.far.columns.count());
  EXPECT_NE(play("other.glb", "local"), 0);
  const formats::Bytes log = formats::readFile(folder_ / "log");
  const std::string text(reinterpret_cast<const char*>(log.data()), log.size());
  EXPECT_NE(text.find("/branches"), std::string::npos) << text;
}

TEST_F(PlayerAgainstCpu, PunctualLightsAreRefusedByNameForOtherPacks) {
  formats::writePack(folder_ / "made.glb", wavyPack(3, 16), {});
  const PlayerLights lights = rig(R"({"punctual": [{"type": "point", "position": [0, 2, 0]}]})");
  std::string command = "'" + kPlayer.string() + "' '" + (folder_ / "made.glb").string() + "' --lights '" +
                        lights.rig_path.string() + "' --image '" + (folder_ / "none.png").string() +
                        "' 2> '" + (folder_ / "log").string() + "'";
  EXPECT_NE(std::system(command.c_str()), 0);
  const formats::Bytes log = formats::readFile(folder_ / "log");
  const std::string text(reinterpret_cast<const char*>(log.data()), log.size());
  EXPECT_NE(text.find("rig.json"), std::string::npos) << text;
  EXPECT_NE(text.find("/punctual"), std::string::npos) << text;
}

// Transfer in a pixel basis with BTFs: frames that turn and change hands from vertex to vertex, so that every triangle has a crease,
// and smooth ones; relief and none; a sun in one texel of the light, and emitters near by. As sums that rows share, in several tiles,
// and as rows.
TEST_F(PlayerAgainstCpu, TransferInAPixelBasis) {
  for (const bool creased : {true, false}) {
    SCOPED_TRACE(creased);
    formats::Pack pack = wavyPack(3, 24);
    addSphericalTexcoords(pack.mesh);
    formats::PixelTransfer transfer = madePixelTransfer(pack.mesh, 8);
    formats::BtfReflection btf = madeBtf(4, 4, 8, 6, creased ? 5 : 21);
    btf.repeats = 3;
    if (creased) {
      btf.index = madeIndex(64, 32);
      btf.heights.reset();
    } else {
      transfer.tangents = transport::textureFrames(pack.mesh).tangents;
      for (formats::Float4& tangent : transfer.tangents) tangent[3] = 1;  // at the seam, too
    }
    pack.transfer = compressed(transfer, {.rows_per_tile = 2000});
    ASSERT_FALSE(pack.transfer.as<formats::PixelTransfer>()->sums->grammar->sum_parts.empty());
    formats::reflectionOf(pack) = btf;
    if (!creased) {
      compare(pack, kSmall, sky());
      pack.transfer = transfer;
      compare(pack, kSmall, sky());
      continue;
    }
    PlayerLights near = rig(R"({"units": "object",
      "lights": [{"type": "disk", "direction": [1, 2, 0.5], "half_angle_deg": 2, "radiance": [300, 250, 200]}],
      "emitters": [{"shape": "sphere", "position": [1, 1.5, 1], "radius": 0.4, "radiance": [6, 8, 12]}]})");
    near.cube_resolution = 256;
    compare(pack, kSmall, near);
  }
}

// Numbers without a meaning in a table of that many columns, smaller the farther the point is.
formats::EncodedTable madeTable(std::size_t rows, std::size_t columns, formats::Precision precision) {
  std::vector<float> values;
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < columns; ++c)
      values.push_back(0.15F * std::sin(0.7F * static_cast<float>(r) + 0.3F * static_cast<float>(c)) /
                       (1 + 0.1F * static_cast<float>(c)));
  return formats::encodeTable(values, columns, precision, "made", "table");
}

formats::Neighborhood madeNeighborhood(const formats::Pack& pack, int channels,
                                       formats::Precision precision) {
  const transport::BoundingSphere bounds = transport::boundingSphere(pack.mesh);
  const auto axis = [&](Eigen::Index a, double from, double to, int intervals) {
    std::vector<float> result;
    for (int i = 0; i <= intervals; ++i)
      result.push_back(static_cast<float>(
          bounds.center[a] +
          bounds.radius * (from + (to - from) * std::pow(i / static_cast<double>(intervals), 1.2))));
    return result;
  };
  formats::Neighborhood result;
  result.order = pack.sh().order;
  result.channels = channels;
  const auto columns = static_cast<std::size_t>(channels * result.order * result.order);
  formats::GroundTransfer ground;
  ground.level = static_cast<float>(bounds.center.y() - bounds.radius);
  ground.x = axis(0, -3, 3, 9), ground.z = axis(2, -2.5, 3.5, 7);
  ground.vectors = madeTable(80, columns, precision);
  result.ground = ground;
  formats::VolumeTransfer volume;
  volume.axes = {axis(0, -1.8, 1.8, 4), axis(1, -1, 1.5, 3), axis(2, -1.7, 2, 5)};
  volume.matrices = madeTable(120, formats::kReceivedCoefficients * columns, precision);
  result.volume = volume;
  return result;
}

TEST_F(PlayerAgainstCpu, GroundThatFadesIntoTheBackdrop) {
  for (const int channels : {1, 3}) {
    formats::Pack pack = wavyPack(4, 24);
    pack.neighborhood = madeNeighborhood(
        pack, channels, channels == 1 ? formats::Precision::kFloat16 : formats::Precision::kUint8);
    formats::FrameSettings settings = kSmall;
    settings.pitch_deg = 30, settings.distance = 0.85;
    compare(pack, settings, sky(), {.ground_albedo = formats::Float3{0.7F, 0.5F, 0.2F}});
    settings.object_yaw_deg = 40, settings.light_yaw_deg = 70, settings.object_pitch_deg = 20;
    settings.background = formats::Background::kBlack;
    compare(pack, settings, sky(), {.ground_albedo = formats::Float3{0.5F, 0.5F, 0.5F}});
    settings.object_pitch_deg = 0, settings.pitch_deg = -20;  // from below it is not there
    compare(pack, settings, sky(), {.ground_albedo = formats::Float3{0.5F, 0.5F, 0.5F}});
  }
}

TEST_F(PlayerAgainstCpu, ReceiverThatMovesUnderEmittersToo) {
  for (const int channels : {1, 3}) {
    formats::Pack pack = wavyPack(channels == 1 ? 3 : 6, 24);
    pack.neighborhood = madeNeighborhood(pack, channels, formats::Precision::kFloat16);
    transport::Receiver receiver;
    receiver.mesh = transport::unitSphere();
    receiver.position = {1.2F, 0.2F, 0.4F};
    receiver.radius = 0.35;
    receiver.orbit_s = 4;
    formats::FrameSettings settings = kSmall;
    settings.distance = 0.7, settings.object_yaw_deg = 30, settings.object_pitch_deg = -15,
    settings.time_s = 3.6;
    compare(pack, settings, sky(), {.ground_albedo = {}, .receiver = receiver});
    PlayerLights near = rig(
        R"({"lights": [{"type": "disk", "direction": [0, 1, 0.5], "half_angle_deg": 40, "radiance": [2, 2, 2]}],
        "emitters": [{"shape": "sphere", "position": [1, 1.5, 1], "radius": 0.4, "radiance": [6, 8, 12]}]})");
    near.cube_resolution = 256;  // an even plane shows each step of it
    compare(pack, settings, near, {.ground_albedo = formats::Float3{0.5F, 0.5F, 0.5F}, .receiver = receiver});
  }
}

TEST_F(PlayerAgainstCpu, GroundIsShownByPacksThatHaveOneUnlessTransparent) {
  formats::Pack pack = wavyPack(3, 24);
  pack.neighborhood = madeNeighborhood(pack, 1, formats::Precision::kFloat16);
  formats::writePack(folder_ / "made.glb", pack, {});
  const auto pictureOf = [&](const std::string& options) {
    const fs::path picture = folder_ / "picture.png";
    const std::string command = kPlayer.string() + " " + (folder_ / "made.glb").string() +
                                " --width=64 --height=48 --pitch-deg=30 --image " + picture.string() +
                                options;
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return formats::readImage(picture).values;
  };
  EXPECT_EQ(pictureOf(" --background black"), pictureOf(" --background black --ground on"));
  EXPECT_NE(pictureOf(" --background black"), pictureOf(" --background black --ground off"));
  EXPECT_EQ(pictureOf(" --background transparent"), pictureOf(" --background transparent --ground off"));
  EXPECT_NE(pictureOf(" --background transparent"), pictureOf(" --background transparent --ground on"));
}

TEST_F(PlayerAgainstCpu, ReceiversAreRefusedByNameWithoutAVolume) {
  formats::writePack(folder_ / "made.glb", wavyPack(2, 12), {});
  const std::string command = kPlayer.string() + " " + (folder_ / "made.glb").string() +
                              " --receiver sphere --image " + (folder_ / "a.png").string() + " 2> " +
                              (folder_ / "errors").string();
  EXPECT_NE(std::system(command.c_str()), 0);
  const formats::Bytes bytes = formats::readFile(folder_ / "errors");
  const std::string errors(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  EXPECT_NE(errors.find("/receiver"), std::string::npos) << errors;
  EXPECT_NE(errors.find("volume_cells"), std::string::npos) << errors;
}

TEST_F(PlayerAgainstCpu, DefaultFrame) {
  compare(wavyPack(5, 96), {}, sky());
}

TEST_F(PlayerAgainstCpu, DefaultLight) {
  compare(wavyPack(4, 64), {.width_px = 640, .height_px = 480}, {});
}

// Yaw and pitch of camera, light and object all at once, so that a wrong order of rotations shows.
TEST_F(PlayerAgainstCpu, TurnedCameraLightAndObject) {
  compare(wavyPack(10, 64),
          {.width_px = 480,
           .height_px = 640,
           .supersampling = 3,
           .yaw_deg = -130,
           .pitch_deg = 40,
           .distance = 0.8,
           .field_of_view_deg = 50,
           .light_yaw_deg = 70,
           .light_pitch_deg = -35,
           .object_yaw_deg = -25,
           .object_pitch_deg = 110,
           .exposure_ev = -1},
          sky());
}

TEST_F(PlayerAgainstCpu, TransparentBackground) {
  compare(wavyPack(3, 64),
          {.width_px = 400,
           .height_px = 300,
           .supersampling = 1,
           .background = formats::Background::kTransparent},
          sky());
}

TEST_F(PlayerAgainstCpu, VertexColorsAndEightBitVectors) {
  formats::Pack pack = wavyPack(5, 64);
  for (const auto& normal : pack.mesh.normals)
    pack.colors.push_back({0.5F + 0.5F * normal[0], 0.5F + 0.5F * normal[1], 0.7F});
  encodeAt(formats::Precision::kUint8, pack);
  compare(pack, kSmall, sky());
}

// Every kind of distant light, an environment on top, windowed; and the object turned under them.
TEST_F(PlayerAgainstCpu, RigOfDistantLights) {
  PlayerLights lights = rig(R"({"lights": [
      {"type": "sky", "turbidity": 4, "sun_elevation_deg": 30, "sun_azimuth_deg": 50, "intensity": 0.05},
      {"type": "disk", "direction": [-1, 0.5, 0.3], "half_angle_deg": 12, "radiance": [4, 2, 1]},
      {"type": "polygon", "vertices": [[1, -0.5, 1], [1, 0.5, 1], [0.2, 0.4, 1]], "radiance": [1, 3, 2]},
      {"type": "directional", "direction": [0, -1, 0.2], "irradiance": [0.1, 0.2, 0.5]}]})");
  lights.environment_path = folder_ / "sky.exr";
  lights.windowing = -1;
  formats::FrameSettings settings = kSmall;
  settings.light_yaw_deg = 40;
  settings.object_yaw_deg = 100;
  compare(wavyPack(6, 64), settings, lights);
}

constexpr const char* kMovingLights = R"({"lights": [
    {"type": "disk", "direction": [1, 1, 1], "half_angle_deg": 20, "radiance": [0.4, 0.4, 0.5]}],
  "emitters": [
    {"shape": "sphere", "position": [1.1, 0.5, 0.6], "radius": 0.25, "radiance": [6, 3, 1],
     "motion": {"kind": "orbit", "axis": [0, 1, 0.2], "period_s": 6}},
    {"shape": "quad", "position": [-1.2, 0.3, 0.2], "normal": [1, 0, 0.4], "width": 0.5, "height": 0.9,
     "radiance": [1, 2, 7]},
    {"shape": "sphere", "position": [0, -1.2, 0.4], "radius": 0.2, "radiance": [2, 5, 2],
     "motion": {"kind": "shuttle", "to": [0.9, -0.9, 0.5], "period_s": 5}}]})";

TEST_F(PlayerAgainstCpu, EmittersLightAndGlow) {
  formats::FrameSettings settings = kSmall;
  settings.distance = 0.9;
  settings.time_s = 0.8;
  settings.object_yaw_deg = 30;
  settings.object_pitch_deg = -20;
  settings.exposure_ev = -1;
  const auto lights = rig(kMovingLights);
  compare(wavyPack(5, 64), settings, lights);
  // So dark that the emitters' own colours show.
  settings.exposure_ev = -6;
  EXPECT_GT(compare(wavyPack(5, 64), settings, lights).emitter_pixels, 2000u);
}

TEST_F(PlayerAgainstCpu, NearTransferWithCoarseAndFineCube) {
  formats::Pack pack = spherePack(5, 48);
  scaleMesh(pack, 0.5F);
  addNearTransfer(pack, 1.0F);
  formats::FrameSettings settings = kSmall;
  settings.distance = 1.3;
  settings.exposure_ev = -1;
  PlayerLights lights = rig(kMovingLights);
  for (const int resolution : {24, 128}) {
    lights.cube_resolution = resolution;
    compare(pack, settings, lights);
  }
}

TEST_F(PlayerAgainstCpu, GlossyInEachStorageAndPrecision) {
  using formats::Storage, formats::Precision;
  formats::MadeReflection phong, ggx, table;
  phong.model = formats::Lobe::kPhong;
  phong.exponent = 20;
  phong.specular_color = {0.6F, 0.5F, 0.4F};
  ggx.model = formats::Lobe::kGgx;
  ggx.roughness = 0.4F;
  ggx.specular_color = {0.3F, 0.5F, 0.6F};
  table.model = formats::Lobe::kTable;
  table.table = madeBrdfTable(16, 4);
  const struct {
    Storage storage;
    Precision precision;
    int channels;
    const formats::MadeReflection& material;
  } cases[] = {{Storage::kMatrix, Precision::kFloat32, 1, phong},
               {Storage::kMatrix, Precision::kUint8, 3, ggx},
               {Storage::kVisibility, Precision::kFloat16, 1, ggx},
               {Storage::kVisibility, Precision::kUint8, 1, table},
               {Storage::kCpca, Precision::kFloat16, 3, phong}};
  for (const auto& made : cases) {
    formats::Pack pack = wavyPack(5, 48);
    addGlossyTransfer(pack, 4, made.storage, made.channels);
    reflectionOf(pack) = made.material;
    encodeAt(made.precision, pack);
    SCOPED_TRACE(std::string(nameOf(made.storage)) + ' ' + nameOf(made.precision) + ' ' +
                 nameOf(made.material.model));
    formats::FrameSettings settings = kSmall;
    settings.object_yaw_deg = 40;
    compare(pack, settings, sky());
  }
}

TEST_F(PlayerAgainstCpu, GlossyUnderEmitters) {
  formats::Pack pack = wavyPack(4, 48);
  addGlossyTransfer(pack, 4, formats::Storage::kMatrix);
  reflectionOf(pack) = formats::GgxLobe{0.3F, {1, 1, 1}};
  formats::FrameSettings settings = kSmall;
  settings.distance = 0.9;
  settings.exposure_ev = -1;
  compare(pack, settings, rig(kMovingLights));
}

// A camera so close that it sees nothing but the body, while a light of constant radiance comes from afar
// through the virtual sphere's wall to its centre.
TEST_F(PlayerAgainstCpu, LightFromAfarToTheCenterIsFiniteAndMonotone) {
  formats::Pack pack = spherePack(5, 24);
  scaleMesh(pack, 0.1F);
  addNearTransfer(pack, 1.0F);
  formats::writePack(folder_ / "made.glb", pack, {});
  double before = 0;
  for (const double distance : {3.0, 1.3, 1.01, 1.0, 0.99, 0.8, 0.52, 0.0}) {
    const PlayerLights lights =
        rig(fmt::format(R"({{"units": "world", "emitters": [{{"shape": "sphere", "radius": 0.3,
                              "position": [{}, 0, {}]}}]}})",
                        0.6 * distance, 0.8 * distance));
    std::string command = "'";
    command.append(kPlayer.string()).append("' '").append((folder_ / "made.glb").string());
    command.append("' --lights '").append(lights.rig_path.string());
    command.append("' --image '").append((folder_ / "near.exr").string());
    command.append("' --width 32 --height 32 --field-of-view-deg 20 --distance 0.35");
    ASSERT_EQ(std::system(command.c_str()), 0);
    const formats::Image picture = formats::readImage(folder_ / "near.exr");
    double sum = 0;
    for (const float value : picture.values) {
      ASSERT_TRUE(std::isfinite(value)) << distance;
      sum += value;
    }
    // Alpha is 1 everywhere.
    const double mean = sum / (32 * 32) / 3 - 1.0 / 3;
    std::printf("light at %.2f: mean radiance %.6f\n", distance, mean);
    EXPECT_GT(mean, before) << distance;
    before = mean;
  }
  EXPECT_NEAR(before, 1, 0.01) << "light all around a white body";
}

}  // namespace
}  // namespace bakelight::tests
