#include "tools/reference/pictures.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "formats/error.h"
#include "formats/mesh_import.h"
#include "tests/unit/reference/scenes.h"
#include "tools/reference/coverage.h"
#include "tools/stage/frame_options.h"
#include "transport/frame.h"

namespace bakelight::reference {
namespace {

using namespace bakelight::tests;

// The default asset.
const Surface& bunny() {
  static const Surface surface = [] {
    const auto path = std::filesystem::path(BAKELIGHT_BIN_DIR).parent_path() / "assets/models/bunny.obj";
    const TriangleMesh mesh = formats::importMesh(path).mesh;
    Surface made = surfaceOf(mesh, 0.8f);
    // Smooth normals, by area.
    std::vector<Vec3> sums(mesh.vertexCount(), Vec3::Zero());
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vec3 corner = vec3(mesh.positions[a]);
      const Vec3 cross = (vec3(mesh.positions[b]) - corner).cross(vec3(mesh.positions[c]) - corner);
      for (const auto v : {a, b, c}) sums[v] += cross;
    }
    made.mesh.normals.clear();
    for (const Vec3& sum : sums)
      made.mesh.normals.push_back(sum.norm() > 0 ? float3(sum.normalized()) : Float3{0, 1, 0});
    return made;
  }();
  return surface;
}

// A wide lamp over a dim sky, of which directions over the hemisphere find enough.
formats::LightRig wideLamp() {
  formats::LightRig rig = diskRig(40, 4, {1, 1, 0.7f});
  rig.distant.emplace_back(formats::DiskLight{{0, 1, 0}, 180, {0.2f, 0.3f, 0.4f}});
  return rig;
}

PixelStatistics compare(const formats::Image& a, const formats::Image& b) {
  const auto valueOf = [&](std::size_t pixel, std::size_t channel) {
    return b.values[pixel * b.channelCount() + channel];
  };
  return compareWith(
      a, [&](std::size_t pixel) { return valueOf(pixel, 0); },
      [&](std::size_t pixel) { return valueOf(pixel, 4); });
}

// Two ways to the same picture that share nothing but geometry and materials: directions over the hemisphere,
// and lights by importance.
TEST(Integrators, AgreeOnTheBunny) {
  Options options = pictureOptions(28, 21, 512);
  const Reference mis = render(bunny(), wideLamp(), options);
  options.paths.integrator = Integrator::kUniform;
  options.effort.samples = 2048;
  options.seed = 1;
  const Reference uniform = render(bunny(), wideLamp(), options);
  const PixelStatistics difference = compare(mis.picture.image, uniform.picture.image);
  std::printf("%d pixels: mean z %.2f, chi² %.3f; relative errors %.4f (mis), %.4f (uniform)\n",
              difference.pixels, difference.mean_z, difference.chi_squared, mis.picture.report.relative_error,
              uniform.picture.report.relative_error);
  ASSERT_GT(difference.pixels, 60);
  EXPECT_LT(std::abs(difference.mean_z), 3);
  EXPECT_NEAR(difference.chi_squared, 1, 5 * std::sqrt(2.0 / difference.pixels));
  EXPECT_LT(uniform.picture.report.relative_error, 0.05);
  EXPECT_LT(mis.picture.report.relative_error, 0.02);
}

// Root mean square over pixels and colours, of what is not noise of the converged picture itself.
double rmsError(const formats::Image& image, const formats::Image& converged) {
  double sum = 0;
  int count = 0;
  for (std::size_t pixel = 0; pixel < image.values.size() / image.channelCount(); ++pixel) {
    const float* here = &image.values[pixel * image.channelCount()];
    const float* there = &converged.values[pixel * image.channelCount()];
    if (here[3] != 1 || there[3] != 1) continue;
    for (int c = 0; c < 3; ++c) sum += std::pow(here[c] - there[c], 2) - there[4 + c];
    count += 3;
  }
  return std::sqrt(sum / count);
}

TEST(Error, FallsAsTheRootOfTheSamples) {
  Options options = pictureOptions(36, 27, 8192);
  options.seed = 99;
  const formats::Image converged = render(bunny(), wideLamp(), options).picture.image;
  std::vector<double> x, y;
  for (const int samples : {32, 128, 512, 2048}) {
    options.effort.samples = samples;
    options.seed = samples;
    const Reference made = render(bunny(), wideLamp(), options);
    const double error = rmsError(made.picture.image, converged);
    // What the picture says of its own error is true.
    double variance = 0;
    int count = 0;
    for (std::size_t pixel = 0; pixel < made.picture.image.values.size() / 7; ++pixel) {
      const float* values = &made.picture.image.values[7 * pixel];
      if (values[3] != 1) continue;
      variance += values[4] + values[5] + values[6];
      count += 3;
    }
    EXPECT_NEAR(std::sqrt(variance / count), error, 0.15 * error) << samples;
    x.push_back(std::log(samples));
    y.push_back(std::log(error));
    std::printf("%5d samples: rms error %.5f\n", samples, error);
  }
  double mean_x = 0, mean_y = 0, xy = 0, xx = 0;
  for (std::size_t i = 0; i < x.size(); ++i) mean_x += x[i] / 4, mean_y += y[i] / 4;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    xx += (x[i] - mean_x) * (x[i] - mean_x);
  }
  std::printf("slope %.3f over a range of %.0f\n", xy / xx, std::exp(x.back() - x.front()));
  EXPECT_NEAR(xy / xx, -0.5, 0.05);
}

// A small sun is a light of its own, so it costs no more samples than a wide one.
TEST(Sun, OfAMillionOverASkyOfOneConverges) {
  formats::LightRig rig = diskRig(0.27, 1e6f, {0.3f, 1, 0.5f});
  rig.distant.emplace_back(formats::DiskLight{{0, 1, 0}, 180, {1, 1, 1}});
  Options options = pictureOptions(40, 30, 256);
  options.effort.relative_error = 0.01;
  const Reference made = render(surfaceOf(icosphere(3), 0.5f), rig, options);
  std::printf("%d samples, relative error %.4f\n", made.picture.report.samples,
              made.picture.report.relative_error);
  EXPECT_TRUE(made.picture.report.converged);
  EXPECT_LE(made.picture.report.samples, 256);
  EXPECT_LE(made.picture.report.relative_error, 0.01);

  const Scene scene = sceneOf(surfaceOf(icosphere(3), 0.5f), rig);
  const Vec3 sun = Vec3(0.3, 1, 0.5).normalized();
  int compared = 0;
  for (std::uint32_t v = 0; v < scene.mesh().vertexCount(); v += 13) {
    const ShadingPoint point = scene.pointAtVertex(v);
    const double cosine = point.normal.dot(sun);
    if (cosine < 0.05) continue;
    const double solid = std::numbers::pi * std::pow(std::sin(0.27 * std::numbers::pi / 180), 2);
    const double expected = 0.5 / std::numbers::pi * 1e6 * solid * cosine + 0.5;
    const auto means = estimate(scene, {}, point, point.normal, 16, v);
    EXPECT_NEAR(means.luminance(), expected, 0.02 * expected);
    ++compared;
  }
  EXPECT_GT(compared, 20);
}

// The same sun as texels of an image, and looked up in full.
TEST(Sun, InAnImageConvergesLikewise) {
  formats::LightRig rig;
  formats::EnvironmentLight environment;
  environment.image = formats::Image(1024, 512, {"R", "G", "B"});
  std::fill(environment.image.values.begin(), environment.image.values.end(), 1.0f);
  for (int c = 0; c < 3; ++c) environment.image.texel(300, 140)[c] = 1e6f;
  rig.distant.emplace_back(environment);
  Options options = pictureOptions(40, 30, 256);
  options.effort.relative_error = 0.0125;  // texels are drawn among a sky of others
  const Reference made = render(surfaceOf(icosphere(3), 0.5f), rig, options);
  EXPECT_TRUE(made.picture.report.converged) << made.picture.report.relative_error;
}

class ConvexBody : public testing::TestWithParam<At> {};

TEST_P(ConvexBody, HasTheSameLightInEveryTransport) {
  Options options = pictureOptions(28, 21, 256);
  options.at = GetParam();
  const Surface ball = surfaceOf(icosphere(3), 0.9f);
  const Reference full = render(ball, wideLamp(), options);
  for (const auto transport : {Transport::kInterreflected, Transport::kShadowed, Transport::kUnshadowed}) {
    options.paths.transport = transport;
    options.seed = static_cast<int>(transport);
    const Reference made = render(ball, wideLamp(), options);
    const PixelStatistics difference = compare(full.picture.image, made.picture.image);
    EXPECT_GT(difference.pixels, 100);
    if (GetParam() == At::kPixels) {
      EXPECT_LT(std::abs(difference.mean_z), 3.5) << formats::wordFor(kTransports, transport);
    }
    EXPECT_NEAR(difference.chi_squared, 1, 0.45);
  }
}

INSTANTIATE_TEST_SUITE_P(Places, ConvexBody, testing::Values(At::kPixels, At::kVertices, At::kLeastSquares));

TEST(Bunny, ShadowsDarkenAndBouncesBrighten) {
  Options options = pictureOptions(20, 15, 256);
  const auto meanOf = [&](Transport transport, int bounces) {
    options.paths = {.transport = transport, .bounces = bounces};
    const formats::Image image = render(bunny(), wideLamp(), options).picture.image;
    double sum = 0;
    for (std::size_t i = 0; i < image.values.size(); i += 7) sum += image.values[i + 1];
    return sum;
  };
  const double unshadowed = meanOf(Transport::kUnshadowed, 0), shadowed = meanOf(Transport::kShadowed, 0);
  const double once = meanOf(Transport::kInterreflected, 1), all = meanOf(Transport::kInterreflected, 0);
  EXPECT_LT(shadowed, 0.97 * unshadowed);
  EXPECT_GT(once, 1.01 * shadowed);
  EXPECT_GT(all, once);
  EXPECT_EQ(meanOf(Transport::kFull, 0), all);  // a diffuse body
}

// Interpolated: between two triangles of one colour each vertex's value shows, with its variance.
TEST(Vertices, AreInterpolatedWithTheirVariance) {
  Options options = pictureOptions(24, 18, 64);
  options.at = At::kVertices;
  options.frame.pitch_deg = 80;
  Surface floor = surfaceOf(floorSquare(1), 1);
  floor.material.vertex_albedo = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5f, 0.5f, 0.5f}};
  const Reference made = render(floor, wideLamp(), options);
  const formats::Image& image = made.picture.image;
  const float* middle = image.texel(12, 9);
  ASSERT_EQ(middle[3], 1);
  const Scene scene = sceneOf(floor, wideLamp(), options.frame);
  const transport::OrbitCamera camera =
      transport::frameCamera(options.frame, transport::boundingSphere(floor.mesh));
  const transport::Hit hit = scene.rays().nearestHit(
      camera.eye(), camera.directionThrough(12.5, 9.5, options.frame.width_px, options.frame.height_px));
  // All vertices have the same irradiance but for noise, so colours are the interpolated weights.
  const double irradiance = estimate(scene, {}, scene.pointAtVertex(0), Vec3::UnitY(), 400).mean()[0];
  const double weight = 1.0 - hit.u - hit.v;  // of the red vertex, which both triangles have first
  EXPECT_NEAR(middle[0], weight * irradiance, 4 * std::sqrt(middle[4]) + 0.05 * middle[0]);
  EXPECT_GT(middle[0], 0);
  // One vertex brings in that colour, so its variance is that of the vertex times the weight squared.
  const double single =
      estimate(scene, {}, scene.pointAtVertex(0), Vec3::UnitY(), 400).variance()[0] * 400 / 4;
  EXPECT_GT(middle[4], 0.1 * weight * weight * single);
  EXPECT_LT(middle[4], 5 * weight * weight * single);
  EXPECT_EQ(made.picture.report.samples, 64);
}

// Colours that are linear over each triangle, in even light, are all that triangles can show.
TEST(Triangles, FittedToWhatVerticesSayAreTheVertices) {
  Options options = pictureOptions(24, 18, 256);
  options.frame.pitch_deg = 80;
  Surface floor = surfaceOf(floorSquare(1), 1);
  floor.material.vertex_albedo = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5f, 0.5f, 0.5f}};
  options.at = At::kLeastSquares;
  const Reference fitted = render(floor, wideLamp(), options);
  options.at = At::kVertices;
  options.seed = 1;
  const PixelStatistics difference =
      compare(fitted.picture.image, render(floor, wideLamp(), options).picture.image);
  EXPECT_GT(difference.pixels, 100);
  EXPECT_LT(difference.chi_squared, 2);
  EXPECT_GT(difference.chi_squared, 0.1);
  EXPECT_LT(fitted.picture.report.relative_error, 0.05);
}

TEST(Pictures, AreTheSameWithAnyNumberOfThreads) {
  const Surface ball = surfaceOf(icosphere(2), 0.8f);
  for (const At at : {At::kPixels, At::kVertices, At::kLeastSquares}) {
    Options options = pictureOptions(24, 18, 4096);
    options.at = at;
    options.effort.relative_error = at == At::kPixels ? 0.05 : 0.01;
    const Surface& surface = at == At::kPixels ? bunny() : ball;
    std::vector<Reference> made;
    for (const std::size_t threads : {1, 2, 5}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      made.push_back(render(surface, wideLamp(), options));
    }
    for (std::size_t i = 1; i < made.size(); ++i) {
      EXPECT_EQ(made[0].picture.image.values, made[i].picture.image.values);
      EXPECT_EQ(made[0].metadata, made[i].metadata);
      EXPECT_EQ(made[0].picture.report.counts.rays, made[i].picture.report.counts.rays);
    }
    EXPECT_GT(made[0].picture.report.rounds, 1);
    options.seed = 7;
    EXPECT_NE(made[0].picture.image.values, render(surface, wideLamp(), options).picture.image.values);
  }
}

TEST(Rounds, StopAtTheErrorOrAtTheSamples) {
  Options options = pictureOptions(24, 18, 4096);
  options.effort.relative_error = 0.03;
  const RoundsReport reached = render(bunny(), wideLamp(), options).picture.report;
  EXPECT_TRUE(reached.converged);
  EXPECT_LE(reached.relative_error, 0.03);
  EXPECT_LT(reached.samples, 4096);
  options.effort = {1e-4, 100};
  const RoundsReport ended = render(bunny(), wideLamp(), options).picture.report;
  EXPECT_FALSE(ended.converged);
  EXPECT_EQ(ended.samples, 96);
  EXPECT_GT(ended.relative_error, 1e-4);
}

TEST(Coverage, LeavesOutNothingThatARayHits) {
  formats::FrameSettings frame;
  frame.width_px = 60;
  frame.height_px = 50;
  for (const double distance : {0.4, 1.0, 3.0}) {
    frame.distance = distance;
    const auto camera = transport::frameCamera(frame, transport::boundingSphere(bunny().mesh));
    const auto covered = possiblyCovered(bunny().mesh, camera, frame.width_px, frame.height_px);
    const transport::RayScene rays(bunny().mesh);
    int hit = 0;
    for (int y = 0; y < 4 * frame.height_px; ++y)
      for (int x = 0; x < 4 * frame.width_px; ++x) {
        const Vec3 direction =
            camera.directionThrough((x + 0.5) / 4, (y + 0.5) / 4, frame.width_px, frame.height_px);
        if (!rays.nearestHit(camera.eye(), direction).valid) continue;
        ++hit;
        ASSERT_EQ(covered[static_cast<std::size_t>(y / 4) * frame.width_px + x / 4], 1) << x << " " << y;
      }
    EXPECT_GT(hit, 500);
    const auto count = static_cast<int>(std::count(covered.begin(), covered.end(), 1));
    if (distance > 0.5) {
      EXPECT_LT(count, hit / 16 * 2 + 200);
    }
  }
}

TEST(Pictures, ShowEmittersAndTheBackground) {
  formats::LightRig rig = uniformRig(3);
  formats::Emitter quad;
  quad.position = {0, 0, 1.2f};
  quad.width = quad.height = 0.2;
  quad.radiance = {50, 60, 70};
  rig.emitters.push_back(quad);
  Options options = pictureOptions(41, 31, 64);
  options.frame.yaw_deg = options.frame.pitch_deg = 0;
  for (const At at : {At::kPixels, At::kVertices, At::kLeastSquares}) {
    options.at = at;
    options.frame.background = formats::Background::kEnvironment;
    const formats::Image over_sky = render(surfaceOf(icosphere(1), 0.5f), rig, options).picture.image;
    EXPECT_NEAR(over_sky.texel(20, 15)[0], 50, 1e-4);
    EXPECT_NEAR(over_sky.texel(20, 15)[2], 70, 1e-4);
    EXPECT_EQ(over_sky.texel(20, 15)[3], 1);
    EXPECT_NEAR(over_sky.texel(0, 0)[0], 3, 1e-3);
    EXPECT_EQ(over_sky.texel(0, 0)[3], 1);
    options.frame.background = formats::Background::kTransparent;
    const formats::Image alone = render(surfaceOf(icosphere(1), 0.5f), rig, options).picture.image;
    EXPECT_EQ(alone.texel(0, 0)[0], 0);
    EXPECT_EQ(alone.texel(0, 0)[3], 0);
  }
}

// The object turned one way under turned light is the camera moved the other way.
TEST(Pictures, TurnedObjectAndLightAreATurnedCamera) {
  Options options = pictureOptions(28, 21, 256);
  const Reference plain = render(bunny(), wideLamp(), options);
  options.frame.object_yaw_deg = options.frame.light_yaw_deg = 70;
  options.frame.yaw_deg += 70;
  options.seed = 3;
  const Reference turned = render(bunny(), wideLamp(), options);
  const PixelStatistics difference = compare(plain.picture.image, turned.picture.image);
  EXPECT_GT(difference.pixels, 60);
  EXPECT_LT(std::abs(difference.mean_z), 3.5);
  EXPECT_NEAR(difference.chi_squared, 1, 0.6);
  options.frame.light_yaw_deg = 0;
  EXPECT_GT(compare(plain.picture.image, render(bunny(), wideLamp(), options).picture.image).chi_squared, 3);
}

TEST(Metadata, FramesAnotherMeshAlike) {
  Options options = pictureOptions(16, 12, 32);
  options.frame.distance = 1.25;
  const Reference made =
      render(surfaceOf(icosphere(1, 2, Vec3(0.1, 0.7, -1 / 3.0)), 0.5f), uniformRig(), options);
  const auto bounds = boundsFromMetadata(made.metadata, "");
  EXPECT_EQ(bounds.radius, transport::boundingSphere(icosphere(1, 2, Vec3(0.1, 0.7, -1 / 3.0))).radius);
  const Reference other = makeReference(surfaceOf(icosphere(1), 0.5f), uniformRig(), options, bounds,
                                        stage::ProgressStyle::kNone);
  for (const char* key : {"bakelight:eye", "bakelight:target", "bakelight:fov_deg", "bakelight:frame"})
    EXPECT_EQ(other.metadata.at(key), made.metadata.at(key)) << key;
  EXPECT_NE(other.picture.image.values, made.picture.image.values);
  const auto frame =
      formats::frameSettingsFromJson(formats::parseJson(made.metadata.at("bakelight:frame"), ""), "", "");
  EXPECT_EQ(frame.distance, 1.25);
  EXPECT_EQ(frame.background, formats::Background::kTransparent);
  EXPECT_EQ(made.metadata.at("bakelight:transport"), "full");
  EXPECT_THROW(boundsFromMetadata({{"bakelight:bounds", "1 2 3"}}, "a.exr"), Error);
  EXPECT_THROW(boundsFromMetadata({}, "a.exr"), Error);
}

TEST(Scene, RefusesMeshesThatCannotBeShaded) {
  Surface no_normals = surfaceOf(icosphere(1), 0.5f);
  no_normals.mesh.normals.clear();
  Surface no_triangles = surfaceOf(icosphere(1), 0.5f);
  no_triangles.mesh.triangles.clear();
  for (const auto* surface : {&no_normals, &no_triangles}) {
    try {
      render(*surface, uniformRig(), pictureOptions(8, 6, 32));
      FAIL() << "accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    }
  }
}

// What a picture's metadata say can be read back whatever the tools were told: one rule on both sides.
TEST(FrameOptions, HaveTheRangesOfFrameSettings) {
  formats::FrameSettings settings;
  stage::Tool tool("frame", "");
  stage::declareFrame(tool, settings);
  int compared = 0;
  for (const auto& parameter : tool.description().parameters) {
    if (!parameter.minimum) continue;
    for (const double bound : {*parameter.minimum, *parameter.maximum}) {
      const bool integer = parameter.type == formats::ParameterType::kInteger;
      const auto read = [&](double value) {
        const formats::Json number = integer ? formats::Json(static_cast<int>(value)) : formats::Json(value);
        return formats::frameSettingsFromJson({{parameter.name, number}}, "", "");
      };
      EXPECT_NO_THROW(read(bound)) << parameter.name;
      EXPECT_THROW(read(bound == *parameter.minimum ? bound - 1 : bound + 1), Error) << parameter.name;
      ++compared;
    }
    EXPECT_EQ(formats::toJson(formats::FrameSettings()).at(parameter.name), parameter.default_value);
  }
  EXPECT_EQ(compared, 24);
}

}  // namespace
}  // namespace bakelight::reference
