#include "formats/light_rig_file.h"

#include <gtest/gtest.h>

#include "formats/error.h"
#include "formats/file.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::formats {
namespace {

class LightRigFile : public testing::Test {
 protected:
  LightRig read(const std::string& text) const {
    writeFileAtomically(folder_ / "rig.json", text);
    return readLightRig(folder_ / "rig.json");
  }

  // The error that `text` causes; fails if it causes none.
  Error errorOf(const std::string& text) const {
    try {
      read(text);
    } catch (const Error& error) {
      EXPECT_TRUE(error.place().file.ends_with("rig.json")) << error.paragraph();
      return error;
    }
    ADD_FAILURE() << "no error from " << text;
    return badInput({}, "");
  }
  void expectError(const std::string& text, const std::string& pointer, const std::string& message) const {
    const Error error = errorOf(text);
    EXPECT_EQ(error.place().pointer, pointer) << text;
    EXPECT_THAT(error.paragraph(), testing::HasSubstr(message)) << text;
  }

  void writeProbe(const std::string& name, int width, int height) const {
    Image image(width, height, {"R", "G", "B"});
    image.values.assign(image.values.size(), 0.5F);
    writeExr(folder_ / name, image);
  }

  tests::TemporaryFolder folder_;
};

TEST_F(LightRigFile, ReadsEveryKindOfDistantLight) {
  writeProbe("probe.exr", 8, 4);
  const LightRig rig = read(R"({"lights": [
    {"type": "environment", "image": "probe.exr", "yaw_deg": 30, "intensity": 2},
    {"type": "disk", "direction": [1, 2, 3], "half_angle_deg": 4, "radiance": [5, 6, 7]},
    {"type": "polygon", "vertices": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "radiance": [1, 2, 3]},
    {"type": "directional", "direction": [0, 0, -1], "irradiance": [3, 2, 1]},
    {"type": "sky", "turbidity": 2.5, "sun_elevation_deg": 12, "sun_azimuth_deg": -90, "sun": false,
     "ground_albedo": [0, 0.5, 1], "intensity": 0.1}],
    "windowing": 0.01})");
  ASSERT_EQ(rig.distant.size(), 5u);
  const auto& environment = std::get<EnvironmentLight>(rig.distant[0]);
  EXPECT_EQ(environment.image.width, 8);
  EXPECT_EQ(environment.image.texel(3, 2)[1], 0.5F);
  EXPECT_EQ(environment.yaw_deg, 30);
  EXPECT_EQ(environment.intensity, 2);
  const auto& disk = std::get<DiskLight>(rig.distant[1]);
  EXPECT_EQ(disk.direction, (Float3{1, 2, 3}));
  EXPECT_EQ(disk.half_angle_deg, 4);
  EXPECT_EQ(disk.radiance, (Float3{5, 6, 7}));
  const auto& polygon = std::get<PolygonLight>(rig.distant[2]);
  EXPECT_EQ(polygon.vertices.at(1), (Float3{0, 1, 0}));
  EXPECT_EQ(polygon.radiance, (Float3{1, 2, 3}));
  const auto& directional = std::get<DirectionalLight>(rig.distant[3]);
  EXPECT_EQ(directional.direction, (Float3{0, 0, -1}));
  EXPECT_EQ(directional.irradiance, (Float3{3, 2, 1}));
  const auto& sky = std::get<SkyLight>(rig.distant[4]);
  EXPECT_EQ(sky.turbidity, 2.5);
  EXPECT_EQ(sky.sun_elevation_deg, 12);
  EXPECT_EQ(sky.sun_azimuth_deg, -90);
  EXPECT_FALSE(sky.sun);
  EXPECT_EQ(sky.ground_albedo, (Float3{0, 0.5F, 1}));
  EXPECT_EQ(sky.intensity, 0.1);
  EXPECT_EQ(rig.windowing, 0.01);
  EXPECT_TRUE(rig.emitters.empty());
}

TEST_F(LightRigFile, ReadsEveryKindOfEmitter) {
  writeFileAtomically(folder_ / "lamp.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const LightRig rig = read(R"({"units": "world", "emitters": [
    {"shape": "quad", "position": [1, 2, 3], "normal": [0, 1, 0], "width": 4, "height": 5, "radiance": [6, 7, 8],
     "motion": {"kind": "orbit", "axis": [1, 0, 0], "center": [0, 1, 0], "period_s": 3}},
    {"shape": "sphere", "radius": 0.1, "motion": {"kind": "shuttle", "to": [9, 0, 0]}},
    {"shape": "mesh", "mesh": "lamp.obj", "scale": 2, "motion": {"kind": "still"}}]})");
  EXPECT_FALSE(rig.object_units);
  ASSERT_EQ(rig.emitters.size(), 3u);
  const Emitter& quad = rig.emitters[0];
  EXPECT_EQ(quad.shape, Emitter::Shape::kQuad);
  EXPECT_EQ(quad.position, (Float3{1, 2, 3}));
  EXPECT_EQ(quad.normal, (Float3{0, 1, 0}));
  EXPECT_EQ(quad.width, 4);
  EXPECT_EQ(quad.height, 5);
  EXPECT_EQ(quad.radiance, (Float3{6, 7, 8}));
  EXPECT_EQ(quad.motion.kind, Motion::Kind::kOrbit);
  EXPECT_EQ(quad.motion.axis, (Float3{1, 0, 0}));
  EXPECT_EQ(quad.motion.center, (Float3{0, 1, 0}));
  EXPECT_EQ(quad.motion.period_s, 3);
  EXPECT_EQ(rig.emitters[1].shape, Emitter::Shape::kSphere);
  EXPECT_EQ(rig.emitters[1].radius, 0.1);
  EXPECT_EQ(rig.emitters[1].motion.kind, Motion::Kind::kShuttle);
  EXPECT_EQ(rig.emitters[1].motion.to, (Float3{9, 0, 0}));
  EXPECT_EQ(rig.emitters[2].shape, Emitter::Shape::kMesh);
  EXPECT_EQ(rig.emitters[2].mesh.triangleCount(), 1u);
  EXPECT_EQ(rig.emitters[2].scale, 2);
  EXPECT_EQ(rig.emitters[2].motion.kind, Motion::Kind::kStill);
}

TEST_F(LightRigFile, ReadsEveryKindOfPunctualLight) {
  writeProbe("slide.exr", 6, 4);
  const LightRig rig = read(R"({"units": "world", "punctual": [
    {"type": "point", "position": [1, 2, 3], "intensity": [4, 5, 6],
     "motion": {"kind": "shuttle", "to": [9, 0, 0]}},
    {"type": "spot", "position": [0, 1, 0], "direction": [0, -1, 0], "inner_half_angle_deg": 10,
     "outer_half_angle_deg": 20},
    {"type": "slide", "position": [0, 0, 3], "direction": [0, 0, -1], "up": [1, 1, 0],
     "field_of_view_deg": 25, "image": "slide.exr"}]})");
  ASSERT_EQ(rig.punctual.size(), 3u);
  const PunctualLight &point = rig.punctual[0], &spot = rig.punctual[1], &slide = rig.punctual[2];
  EXPECT_EQ(point.type, PunctualLight::Type::kPoint);
  EXPECT_EQ(point.position, (Float3{1, 2, 3}));
  EXPECT_EQ(point.intensity, (Float3{4, 5, 6}));
  EXPECT_EQ(point.motion.kind, Motion::Kind::kShuttle);
  EXPECT_EQ(spot.type, PunctualLight::Type::kSpot);
  EXPECT_EQ(spot.direction, (Float3{0, -1, 0}));
  EXPECT_EQ(spot.inner_half_angle_deg, 10);
  EXPECT_EQ(spot.outer_half_angle_deg, 20);
  EXPECT_EQ(slide.type, PunctualLight::Type::kSlide);
  EXPECT_EQ(slide.up, (Float3{1, 1, 0}));
  EXPECT_EQ(slide.field_of_view_deg, 25);
  ASSERT_NE(slide.image, nullptr);
  EXPECT_EQ(slide.image->width, 6);
  EXPECT_FALSE(rig.empty());
}

TEST_F(LightRigFile, ChecksPunctualLights) {
  writeProbe("slide.exr", 2, 2);
  Image dark(1, 1, {"R", "G", "B"});
  dark.values = {1, -1, 1};
  writeExr(folder_ / "dark.exr", dark);
  const auto expect = [&](const std::string& members, const std::string& pointer,
                          const std::string& message) {
    expectError("{\"punctual\": [{" + members + "}]}", "/punctual/0" + pointer, message);
  };
  expect(R"("type": "point")", "", "\"position\" is missing");
  expect(R"("type": "lamp", "position": [0, 0, 0])", "/type", "\"point\"");
  expect(R"("type": "point", "position": [0, 0, 0], "intensity": [1, -1, 1])", "/intensity", "from 0");
  expect(R"("type": "point", "position": [0, 0, 0], "direction": [1, 0, 0])", "/direction", "unknown key");
  expect(R"("type": "spot", "position": [0, 0, 0])", "", "\"direction\" is missing");
  expect(R"("type": "spot", "position": [0, 0, 0], "direction": [0, 0, 0])", "/direction", "no direction");
  const std::string spot = R"("type": "spot", "position": [0, 0, 0], "direction": [0, 0, 1], )";
  expect(spot + R"("outer_half_angle_deg": 91)", "/outer_half_angle_deg", "out of range");
  expect(spot + R"("inner_half_angle_deg": 45)", "/inner_half_angle_deg", "not less than");
  expect(spot + R"("inner_half_angle_deg": 20, "outer_half_angle_deg": 10)", "/inner_half_angle_deg",
         "not less than");
  const std::string slide = R"("type": "slide", "position": [0, 0, 0], "direction": [0, 0, 1], )";
  expect(slide + R"("up": [0, 1, 0])", "", "\"image\" is missing");
  expect(slide + R"("image": "slide.exr", "up": [0, 0, -3])", "/up", "along the direction");
  expect(slide + R"("image": "slide.exr", "up": [0, 0, 0])", "/up", "no direction");
  expect(slide + R"("image": "slide.exr", "field_of_view_deg": 180)", "/field_of_view_deg", "out of range");
  expect(slide + R"("image": "none.png")", "/image", "none.png");
  expect(slide + R"("image": "dark.exr")", "/image", "below 0");
}

TEST_F(LightRigFile, LeavesDefaultsWhereNothingIsSaid) {
  const LightRig rig = read(R"({"lights": [{"type": "disk"}], "windowing": "auto"})");
  EXPECT_EQ(std::get<DiskLight>(rig.distant[0]).half_angle_deg, DiskLight{}.half_angle_deg);
  EXPECT_TRUE(rig.object_units);
  EXPECT_LT(rig.windowing, 0);
  EXPECT_EQ(read(R"({"emitters": [{"shape": "quad"}]})").windowing, 0);
}

TEST_F(LightRigFile, NamesTheNearestKeyAndChoice) {
  expectError(R"({"lights": [{"type": "disk", "radience": [1, 1, 1]}]})", "/lights/0/radience",
              "\"radiance\"");
  expectError(R"({"lights": [{"type": "dsik"}]})", "/lights/0/type", "\"disk\"");
  expectError(R"({"light": [{"type": "disk"}]})", "/light", "\"lights\"");
  expectError(R"({"emitters": [{"shape": "quad", "motion": {"kind": "orbit", "centre": [0, 0, 0]}}]})",
              "/emitters/0/motion/centre", "\"center\"");
  expectError(R"({"lights": [{"type": "disk"}], "units": "metre"})", "/units", "\"object\"");
  expectError(R"({"lights": [{"type": "disk"}], "windowing": "automatic"})", "/windowing", "\"auto\"");
  // A key of another kind of light is unknown here.
  expectError(R"({"lights": [{"type": "disk", "turbidity": 3}]})", "/lights/0/turbidity", "unknown key");
  expectError(R"({"emitters": [{"shape": "sphere", "width": 3}]})", "/emitters/0/width", "unknown key");
  expectError(R"({"emitters": [{"shape": "quad", "motion": {"kind": "still", "period_s": 3}}]})",
              "/emitters/0/motion/period_s", "unknown key");
}

TEST_F(LightRigFile, ChecksTypesAndRanges) {
  const auto light = [](const std::string& members) { return "{\"lights\": [{" + members + "}]}"; };
  const auto emitter = [](const std::string& members) { return "{\"emitters\": [{" + members + "}]}"; };
  expectError(light(R"("type": "disk", "half_angle_deg": 181)"), "/lights/0/half_angle_deg", "out of range");
  expectError(light(R"("type": "disk", "half_angle_deg": 0)"), "/lights/0/half_angle_deg", "out of range");
  expectError(light(R"("type": "disk", "half_angle_deg": "wide")"), "/lights/0/half_angle_deg", "a number");
  expectError(light(R"("type": "disk", "radiance": [1, -1, 1])"), "/lights/0/radiance", "from 0");
  expectError(light(R"("type": "disk", "radiance": 1)"), "/lights/0/radiance", "a list of 3 numbers");
  expectError(light(R"("type": "disk", "direction": [0, 0, 0])"), "/lights/0/direction", "no direction");
  expectError(light(R"("type": "sky", "turbidity": 11)"), "/lights/0/turbidity", "from 1.7 to 10");
  expectError(light(R"("type": "sky", "sun": 1)"), "/lights/0/sun", "true or false");
  expectError(light(R"("direction": [0, 1, 0])"), "/lights/0", "\"type\" is missing");
  expectError(light(R"("type": "polygon")"), "/lights/0", "\"vertices\" is missing");
  expectError(light(R"("type": "polygon", "vertices": [[1, 0, 0], [0, 1, 0]])"), "/lights/0/vertices",
              "at least 3");
  expectError(light(R"("type": "polygon", "vertices": [[1, 0, 0], [0, 1], [0, 0, 1]])"),
              "/lights/0/vertices/1", "3 numbers");
  expectError(light(R"("type": "polygon", "vertices": [[1, 0, 0], [0, 1, 0], [0, 0, 0]])"),
              "/lights/0/vertices/2", "at the object itself");
  expectError(light(R"("type": "polygon", "vertices": [[1, 0, 0], [0, 1, 0], [0, -2, 0]])"),
              "/lights/0/vertices/1", "opposite");
  expectError(emitter(R"("shape": "sphere", "radius": 0)"), "/emitters/0/radius", "out of range");
  expectError(emitter(R"("shape": "quad", "motion": {"kind": "orbit", "period_s": 0})"),
              "/emitters/0/motion/period_s", "out of range");
  expectError(emitter(R"("shape": "quad", "motion": {"kind": "shuttle"})"), "/emitters/0/motion",
              "\"to\" is missing");
  expectError(emitter(R"("shape": "quad", "motion": 3)"), "/emitters/0/motion", "a JSON object");
  expectError(R"({"lights": [{"type": "disk"}], "windowing": -1})", "/windowing", "out of range");
  expectError(R"({"lights": {"type": "disk"}})", "/lights", "a list");
  expectError(R"({"lights": [3]})", "/lights/0", "a JSON object");
  expectError(R"([])", "", "a JSON object");
}

TEST_F(LightRigFile, RefusesARigWithoutLight) {
  expectError("{}", "", "no light");
  expectError(R"({"lights": [], "emitters": []})", "", "no light");
}

TEST_F(LightRigFile, NamesFilesThatAreMissingOrOfTheWrongShape) {
  expectError(R"({"lights": [{"type": "environment", "image": "none.exr"}]})", "/lights/0/image", "none.exr");
  expectError(R"({"lights": [{"type": "environment"}]})", "/lights/0", "\"image\" is missing");
  expectError(R"({"emitters": [{"shape": "mesh", "mesh": "none.obj"}]})", "/emitters/0/mesh", "none.obj");
  writeProbe("square.exr", 8, 8);
  expectError(R"({"lights": [{"type": "environment", "image": "square.exr"}]})", "/lights/0/image", "8 × 8");
  writeProbe("strip.exr", 12, 2);
  EXPECT_NO_THROW(read(R"({"lights": [{"type": "environment", "image": "strip.exr"}]})"));
}

TEST_F(LightRigFile, ReadsTheRigsOfTheProject) {
  int rigs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(BAKELIGHT_SOURCE_DIR "/configs/lights")) {
    const LightRig rig = readLightRig(entry.path());
    EXPECT_FALSE(rig.empty()) << entry.path();
    ++rigs;
  }
  EXPECT_GE(rigs, 4);
}

}  // namespace
}  // namespace bakelight::formats
