// Walks through media against adding-doubling, published figures and the white furnace.
#include "tools/reference/random_walk.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/LU>
#include <numbers>

#include "tests/unit/reference/scenes.h"
#include "transport/diffusion.h"
#include "transport/gauss_legendre.h"
#include "transport/random.h"
#include "transport/slab.h"

namespace bakelight::tests {
namespace {

using namespace reference;

constexpr double kPi = std::numbers::pi;

// Radiative transfer in a plane layer by adding and doubling (van de Hulst 1980, chapter 4), for a beam along the normal.
class Layer {
 public:
  // Light of `nodes` cosines on either side of the critical angle, and of the beam.
  Layer(double optical_thickness, double albedo, double anisotropy, double relative_ior, int nodes)
      : relative_ior_(relative_ior) {
    const double critical = relative_ior > 1 ? std::sqrt(1 - 1 / (relative_ior * relative_ior)) : 0.5;
    const int count = 2 * nodes + 1;
    cosines_.resize(count);
    weights_.resize(count);
    int i = 0;
    for (const auto& [low, high] : {std::pair(0.0, critical), std::pair(critical, 1.0)})
      for (const transport::QuadratureNode& node : transport::gaussLegendreRule(nodes)) {
        cosines_[i] = low + (high - low) * (node.x + 1) / 2;
        weights_[i++] = (high - low) / 2 * node.weight;
      }
    cosines_[i] = 1;
    weights_[i] = kBeamWeight;

    constexpr int kDoublings = 30;
    const double thin = std::ldexp(optical_thickness, -kDoublings);
    reflectance_.resize(count, count);
    transmittance_.resize(count, count);
    for (int to = 0; to < count; ++to)
      for (int from = 0; from < count; ++from) {
        const double scattered = albedo * thin / (2 * cosines_[to]) * weights_[from];
        reflectance_(to, from) = scattered * phase(anisotropy, cosines_[to], -cosines_[from]);
        transmittance_(to, from) = scattered * phase(anisotropy, cosines_[to], cosines_[from]) +
                                   (to == from ? 1 - thin / cosines_[to] : 0);
      }
    const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(count, count);
    for (int doubling = 0; doubling < kDoublings; ++doubling) {
      const Eigen::MatrixXd between =
          transmittance_ * (identity - reflectance_ * reflectance_).partialPivLu().inverse();
      reflectance_ += between * reflectance_ * transmittance_;
      transmittance_ = between * transmittance_;
    }
  }

  double transmitted() const { return fluxOf(transmittance_.col(cosines_.size() - 1) / kBeamWeight); }
  // Of what has entered, through a boundary that reflects inside. A layer on nothing, so a thick one where η is not 1.
  double reflected() const {
    Eigen::VectorXd beam = Eigen::VectorXd::Zero(cosines_.size());
    beam[beam.size() - 1] = 1 / kBeamWeight;
    return reflectedOf(beam);
  }
  // The same of light that is uniform outside.
  double reflectedOfUniform() const {
    const Eigen::VectorXd entered = Eigen::VectorXd::Ones(cosines_.size()) - reflectedInside();
    return reflectedOf(entered / fluxOf(entered));
  }

 private:
  static constexpr double kBeamWeight = 1e-9;

  // Henyey and Greenstein's, averaged over azimuths; its mean over cosines is 1.
  static double phase(double anisotropy, double to, double from) {
    double sum = 0, power = 1;
    for (unsigned l = 0; l < 48 && power > 0; ++l, power *= anisotropy)
      sum += (2 * l + 1) * power * std::legendre(l, std::abs(to)) * std::legendre(l, std::abs(from)) *
             (l % 2 == 1 && to * from < 0 ? -1 : 1);
    return sum;
  }
  Eigen::VectorXd reflectedInside() const {
    Eigen::VectorXd inside = cosines_;
    for (double& cosine : inside) cosine = transport::fresnelReflectance(cosine, 1 / relative_ior_);
    return inside;
  }
  double reflectedOf(const Eigen::VectorXd& down) const {
    const Eigen::VectorXd inside = reflectedInside();
    const Eigen::MatrixXd again = Eigen::MatrixXd::Identity(inside.size(), inside.size()) -
                                  reflectance_ * inside.asDiagonal().toDenseMatrix();
    const Eigen::VectorXd up = again.partialPivLu().solve(reflectance_ * down);
    return fluxOf(up.cwiseProduct((1 - inside.array()).matrix()));
  }
  double fluxOf(const Eigen::VectorXd& radiance) const {
    return (radiance.array() * cosines_.array() * weights_.array()).sum();
  }

  double relative_ior_;
  Eigen::VectorXd cosines_, weights_;
  Eigen::MatrixXd reflectance_, transmittance_;
};

constexpr int kNodes = 16;
constexpr double kThick = 1e5;

double semiInfinite(double albedo, double relative_ior) {
  return Layer(kThick, albedo, 0, relative_ior, kNodes).reflected();
}

TEST(AddingDoubling, HasPublishedFiguresAndConverges) {
  // Van de Hulst 1980, table 35, for Henyey and Greenstein's phase function.
  const Layer forward(2, 0.9, 0.75, 1, kNodes);
  EXPECT_NEAR(forward.reflected(), 0.09739, 1e-5);
  EXPECT_NEAR(forward.transmitted(), 0.66096, 1e-5);
  // Giovanelli 1955, with what the surface reflects.
  EXPECT_NEAR(0.04 + 0.96 * semiInfinite(0.9, 1.5), 0.2600, 1e-4);
  for (const double albedo : {0.5, 0.9, 0.999})
    for (const double relative_ior : {1.0, 1.5}) {
      const Layer coarse(kThick, albedo, 0, relative_ior, kNodes),
          fine(kThick, albedo, 0, relative_ior, 3 * kNodes / 2);
      EXPECT_NEAR(coarse.reflected(), fine.reflected(), 2e-5) << albedo << " " << relative_ior;
    }
}

// What diffusion says of layers that scatter much is transport's answer within some percent; thin ones keep what is not scattered.
TEST(AddingDoubling, IsNearDiffusionsLayers) {
  for (const double albedo : {1.0, 0.999, 0.99})
    for (const double thickness : {0.5, 2.0, 8.0, 32.0}) {
      const transport::SlabTransmission slab =
          transport::slabTransmission({albedo, 1 - albedo, 1}, thickness);
      const double found = slab.unabsorbed * std::exp(-slab.attenuation * thickness);
      EXPECT_NEAR(found / Layer(thickness, albedo, 0, 1, kNodes).transmitted(), 1, 0.05)
          << albedo << " " << thickness;
    }
}

// What it matters that light goes in diffusely: along the normal it goes deepest, so least comes back.
TEST(AddingDoubling, TellsWhatDiffuseEntryLeavesOut) {
  const double albedos[] = {0.999, 0.99, 0.9, 0.5}, errors[] = {0.006, 0.016, 0.039, 0.059};
  for (std::size_t i = 0; i < 4; ++i) {
    const Layer half_space(kThick, albedos[i], 0, 1.5, kNodes);
    EXPECT_NEAR(half_space.reflectedOfUniform() / half_space.reflected() - 1, errors[i], 0.001) << albedos[i];
  }
}

// A closed block below y = 0.
TriangleMesh block(float half_width, float depth, const Float3& offset = {0, 0, 0}) {
  TriangleMesh mesh;
  const float w = half_width;
  for (const float y : {0.0F, -depth})
    for (const auto& [x, z] : {std::pair(-w, w), std::pair(w, w), std::pair(w, -w), std::pair(-w, -w)})
      mesh.positions.push_back({x + offset[0], y + offset[1], z + offset[2]});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {6, 5, 4}, {7, 6, 4}};
  for (std::uint32_t side = 0; side < 4; ++side) {
    const std::uint32_t next = (side + 1) % 4;
    mesh.triangles.push_back({side, side + 4, next + 4});
    mesh.triangles.push_back({side, next + 4, next});
  }
  return flatShaded(mesh);
}

formats::Medium mediumOf(const Rgb& albedo, const Rgb& extinction, double eta) {
  formats::Medium medium;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto color = static_cast<Eigen::Index>(c);
    medium.reduced_scattering[c] = static_cast<float>(albedo[color] * extinction[color]);
    medium.absorption[c] = static_cast<float>((1 - albedo[color]) * extinction[color]);
  }
  medium.eta = eta;
  return medium;
}

struct MeanOfWalks {
  Rgb sum = Rgb::Zero(), squares = Rgb::Zero();
  int count = 0;
  void add(const Rgb& value) {
    sum += value;
    squares += value.square();
    ++count;
  }
  void expect(const Rgb& expected, double smallest_error) const {
    for (int c = 0; c < 3; ++c) {
      const double mean = sum[c] / count, error = std::sqrt((squares[c] / count - mean * mean) / count);
      EXPECT_LT(error, smallest_error * expected[c]) << c;
      EXPECT_NEAR(mean, expected[c], 3.5 * error + 1e-4 * expected[c]) << c;
    }
  }
};

struct ThroughTheTop {
  MeanOfWalks reflected, transmitted;
  TraceCounts counts;
};
// Of a beam along the normal that meets the top beside the middle.
ThroughTheTop walksInto(const TriangleMesh& mesh, const formats::Medium& medium, const Vec3& offset,
                        int count, std::vector<std::uint8_t> of_medium = {}) {
  const transport::RayScene rays(mesh);
  const RandomWalk inside(medium, mesh, std::move(of_medium), rays);
  const double size = transport::boundingSphere(mesh).radius;
  const Vec3 place = offset + Vec3(0.02, 0, 0.01) * size;
  const transport::Hit hit = rays.nearestHit(place + size * Vec3::UnitY(), -Vec3::UnitY());
  const RandomWalk::Start start{place, Vec3::UnitY(), hit.triangle, hit.back_face};
  ThroughTheTop result;
  for (int i = 0; i < count; ++i) {
    const auto exit = inside.walk(start, inside.refracted(start, Vec3::UnitY()),
                                  transport::scrambled(static_cast<std::uint64_t>(i)), result.counts);
    const bool above = exit && exit->place.triangle < 2;
    result.reflected.add(exit && above ? exit->weight : Rgb(Rgb::Zero()));
    result.transmitted.add(exit && !above ? exit->weight : Rgb(Rgb::Zero()));
  }
  return result;
}

// All colors in one walk, of other albedos and thicknesses.
TEST(RandomWalk, OfASlabIsAddingDoubling) {
  const Rgb albedo(0.9, 0.5, 0.99), extinction(1, 2, 0.5);
  const ThroughTheTop walks = walksInto(block(400, 2), mediumOf(albedo, extinction, 1), Vec3::Zero(), 100000);
  Rgb reflected, transmitted;
  for (int c = 0; c < 3; ++c) {
    const Layer layer(2 * extinction[c], albedo[c], 0, 1, kNodes);
    reflected[c] = layer.reflected();
    transmitted[c] = layer.transmitted();
  }
  walks.reflected.expect(reflected, 0.01);
  walks.transmitted.expect(transmitted, 0.02);
  EXPECT_EQ(walks.counts.walks, 100000U);
  EXPECT_EQ(walks.counts.open_walks + walks.counts.cut_walks, 0U);
}

TEST(RandomWalk, EndsAtOtherMaterials) {
  std::vector<std::uint8_t> of_medium(12, 1);
  of_medium[2] = of_medium[3] = 0;  // the bottom
  const ThroughTheTop walks =
      walksInto(block(400, 2), mediumOf(Rgb(0.9, 0.9, 0.9), Rgb(1, 1, 1), 1), Vec3::Zero(), 20000, of_medium);
  walks.reflected.expect(Rgb::Constant(Layer(2, 0.9, 0, 1, kNodes).reflected()), 0.02);
  EXPECT_TRUE((walks.transmitted.sum == 0).all());
}

TEST(RandomWalk, BelowARefractingBoundaryIsGiovanellis) {
  const Rgb albedo(0.9, 0.5, 0.999);
  const ThroughTheTop walks =
      walksInto(block(300, 200), mediumOf(albedo, Rgb(1, 1.5, 0.8), 1.5), Vec3::Zero(), 40000);
  Rgb expected;
  for (int c = 0; c < 3; ++c) expected[c] = semiInfinite(albedo[c], 1.5);
  walks.reflected.expect(expected, 0.02);
}

// Free paths that single precision does not resolve.
TEST(RandomWalk, IsRightForPathsShorterThanARounding) {
  const Vec3 offset(30, -50, 70);
  for (const double extinction : {1e4, 1e7, 1e10}) {
    const ThroughTheTop walks =
        walksInto(block(1, 1, float3(offset)), mediumOf(Rgb(0.9, 0.5, 0.99), Rgb::Constant(extinction), 1.5),
                  offset, 20000);
    walks.reflected.expect(Rgb(semiInfinite(0.9, 1.5), semiInfinite(0.5, 1.5), semiInfinite(0.99, 1.5)),
                           0.03);
    EXPECT_EQ(walks.counts.open_walks, 0U) << extinction;
  }
}

Surface walked(const TriangleMesh& mesh, const formats::Medium& medium) {
  Surface surface = surfaceOf(mesh, 1);
  surface.material.media = {medium};
  surface.translucency = Translucency::kRandomWalk;
  return surface;
}

ShadingPoint seenFrom(const Scene& scene, const Vec3& eye, const Vec3& direction) {
  return scene.pointAt(scene.rays().nearestHit(eye, direction));
}

void expectMean(const BatchMeans& means, const Rgb& expected, double smallest_error) {
  for (int c = 0; c < 3; ++c) {
    const double error = std::sqrt(means.variance()[c]);
    EXPECT_LE(error, smallest_error * expected[c]) << c;
    EXPECT_NEAR(means.mean()[c], expected[c], 3.5 * error + 1e-4 * expected[c]) << c;
  }
}

TEST(RandomWalk, TellsTheErrorOfTheDipole) {
  const double albedos[] = {0.999, 0.99, 0.9, 0.5}, errors[] = {0, -0.008, -0.07, -0.24};
  for (std::size_t i = 0; i < 4; ++i) {
    const formats::Medium medium = mediumOf(Rgb::Constant(albedos[i]), Rgb(1, 2, 3), 1);
    const Scene scene = sceneOf(walked(block(200, 200), medium), uniformRig());
    const ShadingPoint point = seenFrom(scene, Vec3(1, 5, 2), -Vec3::UnitY());
    const auto means = estimate(scene, {}, point, Vec3::UnitY(), 1500);
    const double expected = semiInfinite(albedos[i], 1);
    expectMean(means, Rgb::Constant(expected), 0.02);
    const transport::DiffuseReflectance dipole(formats::DiffusionModel::kDipole,
                                               {albedos[i], 1 - albedos[i], 1});
    EXPECT_NEAR(dipole.total() / expected - 1, errors[i], 0.005) << albedos[i];
  }
}

// What leaves and what the boundary reflects are all of the light.
TEST(RandomWalk, LosesNothingInAWhiteFurnace) {
  const TriangleMesh ball = flatShaded(icosphere(1));
  for (const double eta : {1.0, 1.5})
    for (const TriangleMesh& mesh : {ball, insideOut(ball)}) {
      const Scene scene = sceneOf(walked(mesh, mediumOf(Rgb::Ones(), Rgb(5, 10, 0.3), eta)), uniformRig());
      const Vec3 eye(2, 3, 4);
      for (const Vec3& target : {Vec3(0, 0, 0), Vec3(0.3, 0.7, -0.2)}) {
        const Vec3 direction = (target - eye).normalized();
        const ShadingPoint point = seenFrom(scene, eye, direction);
        const double reflected = transport::fresnelReflectance(-point.normal.dot(direction), eta);
        expectMean(estimate(scene, {}, point, -direction, 500), Rgb::Constant(1 - reflected), 0.02);
      }
    }
}

formats::Medium withVeins(formats::Medium medium, const Rgb& scattering, const Rgb& absorption,
                          double spacing, double width) {
  medium.veins = formats::Veins{};
  for (int c = 0; c < 3; ++c) {
    medium.veins->reduced_scattering[static_cast<std::size_t>(c)] = static_cast<float>(scattering[c]);
    medium.veins->absorption[static_cast<std::size_t>(c)] = static_cast<float>(absorption[c]);
  }
  medium.veins->spacing = spacing, medium.veins->width = width;
  return medium;
}

// Scattering that is another in veins bends ways, and loses nothing.
TEST(RandomWalk, LosesNothingWithVeinsThatScatterMore) {
  const TriangleMesh ball = flatShaded(icosphere(1));
  const formats::Medium medium =
      withVeins(mediumOf(Rgb::Ones(), Rgb(5, 2, 0.3), 1.3), Rgb(40, 1, 9), Rgb::Zero(), 0.5, 0.2);
  const Scene scene = sceneOf(walked(ball, medium), uniformRig());
  const Vec3 eye(2, 3, 4), direction = (Vec3(0.3, 0.7, -0.2) - eye).normalized();
  const ShadingPoint point = seenFrom(scene, eye, direction);
  const double reflected = transport::fresnelReflectance(-point.normal.dot(direction), 1.3);
  expectMean(estimate(scene, {}, point, -direction, 2000), Rgb::Constant(1 - reflected), 0.02);
}

// Where next to nothing scatters, what comes through is what the veins on the way leave.
TEST(RandomWalk, VeinsAbsorbAlongTheWay) {
  const TriangleMesh mesh = block(4, 2);
  const formats::Medium medium = withVeins(mediumOf(Rgb::Constant(1e-4), Rgb(0.1, 0.2, 0.4), 1),
                                           Rgb::Constant(1e-5), Rgb(2, 0.5, 1), 0.5, 0.2);
  const ThroughTheTop walks = walksInto(mesh, medium, Vec3::Zero(), 40000);
  const transport::MediumField field(medium, mesh.positions);
  const double size = transport::boundingSphere(mesh).radius;
  const Vec3 place = Vec3(0.02, 0, 0.01) * size;
  Rgb depths = Rgb::Zero();
  constexpr int kPoints = 4000;
  for (int k = 0; k < kPoints; ++k)
    for (int c = 0; c < 3; ++c)
      depths[c] += 2.0 / kPoints *
                   field
                       .coefficients(static_cast<std::size_t>(c),
                                     field.shareAt(place - 2 * (k + 0.5) / kPoints * Vec3::UnitY()))
                       .extinction();
  walks.transmitted.expect((-depths).exp(), 0.03);
}

TEST(RandomWalk, StartsAtVerticesToo) {
  const Scene scene = sceneOf(walked(icosphere(2), mediumOf(Rgb::Ones(), Rgb(5, 10, 0.3), 1)), uniformRig());
  const ShadingPoint point = scene.pointAtVertex(7);
  expectMean(estimate(scene, {}, point, point.normal, 500), Rgb::Ones(), 0.02);
}

// As in models of which a face has been made twice, the same or the other way round: here below the first, or above it by less than rays
// start off the surface, looked at from both sides.
TEST(RandomWalk, LetsLightThroughDoubledFaces) {
  for (const double radius : {0.99, 1.00001}) {
    TriangleMesh ball = flatShaded(icosphere(1)), doubled = flatShaded(icosphere(1, radius));
    const std::vector<formats::Triangle> faces = doubled.triangles;
    doubled.triangles.clear();
    for (auto [a, b, c] : faces) {
      if (doubled.positions[a][1] < 0.3F) continue;
      if (doubled.triangles.size() % 2 == 0) std::swap(b, c);
      doubled.triangles.push_back({a, b, c});
    }
    append(ball, doubled);
    const Scene scene = sceneOf(walked(ball, mediumOf(Rgb::Ones(), Rgb(5, 10, 2), 1)), uniformRig());
    for (const Vec3& eye :
         {Vec3(1, 3, 2), Vec3(-2, 3, 1), Vec3(0, 4, 0.3), Vec3(1, -4, 0.3), Vec3(0.2, 0.1, 5)}) {
      const ShadingPoint point = seenFrom(scene, eye, -eye.normalized());
      expectMean(estimate(scene, {}, point, eye.normalized(), 200), Rgb::Ones(), 0.03);
    }
  }
}

TEST(RandomWalk, TakesOverlappingBodiesForOne) {
  TriangleMesh pair = flatShaded(icosphere(1));
  append(pair, flatShaded(icosphere(1, 0.7, Vec3(0.8, 0.1, 0))));
  const Scene scene = sceneOf(walked(pair, mediumOf(Rgb::Ones(), Rgb(4, 1, 8), 1)), uniformRig());
  const Vec3 direction = -Vec3(0.3, 0.2, 1).normalized();
  expectMean(estimate(scene, {}, seenFrom(scene, -4 * direction, direction), -direction, 300), Rgb::Ones(),
             0.02);
  TraceCounts counts;
  const transport::StratifiedBatch batch(1, 0, 0);
  const ShadingPoint point = seenFrom(scene, -4 * direction, direction);
  for (int s = 0; s < transport::StratifiedBatch::kSize; ++s)
    PathTracer(scene, {}).exitRadiance(point, -direction, {batch, s}, counts);
  EXPECT_GT(counts.walks, 0U);
  EXPECT_EQ(counts.open_walks, 0U);
}

// Light enters diffusely, so a sun's share of a uniform light's is that of its irradiance.
TEST(RandomWalk, SunlightEntersByItsCosineAndFresnel) {
  formats::LightRig rig;
  rig.distant.emplace_back(formats::DirectionalLight{{0, 1, 1}, {5, 5, 5}});
  const Scene scene = sceneOf(walked(block(200, 100), mediumOf(Rgb(0.9, 0.5, 0.99), Rgb::Ones(), 1.5)), rig);
  const ShadingPoint point = seenFrom(scene, Vec3(1, 5, 2), -Vec3::UnitY());
  const double cosine = std::sqrt(0.5);
  const double entered = 5 * cosine * (1 - transport::fresnelReflectance(cosine, 1.5)) /
                         (1 - 2 * transport::fresnelMoments(1.5).first);
  const Rgb inside(semiInfinite(0.9, 1.5), semiInfinite(0.5, 1.5), semiInfinite(0.99, 1.5));
  expectMean(estimate(scene, {}, point, Vec3::UnitY(), 3000), entered / kPi * 0.96 * inside, 0.03);
}

TEST(RandomWalk, TellsOfOpenMeshesAndEndlessPaths) {
  const transport::StratifiedBatch batch(1, 0, 0);
  const auto countsOf = [&](const Surface& surface, int samples) {
    const Scene scene = sceneOf(surface, uniformRig());
    const ShadingPoint point = seenFrom(scene, Vec3(0.1, 5, 0.2), -Vec3::UnitY());
    TraceCounts counts;
    for (int s = 0; s < samples; ++s)
      EXPECT_TRUE(
          PathTracer(scene, {}).exitRadiance(point, Vec3::UnitY(), {batch, s}, counts).isFinite().all());
    return counts;
  };
  const TraceCounts open = countsOf(walked(floorSquare(1), mediumOf(Rgb::Ones(), Rgb(3, 3, 3), 1.3)), 16);
  EXPECT_EQ(open.walks, 16U);
  EXPECT_EQ(open.open_walks, 16U);
  const Reference picture =
      render(walked(icosphere(2), mediumOf(Rgb::Constant(1 - 1e-9), Rgb(30, 40, 50), 1.3)), uniformRig(),
             pictureOptions(16, 16, 32));
  EXPECT_GT(picture.picture.report.counts.walks, 0U);
  EXPECT_EQ(picture.picture.report.counts.open_walks + picture.picture.report.counts.cut_walks, 0U);
  EXPECT_EQ(picture.metadata.at("bakelight:translucency"), "random_walk");
}

TEST(RandomWalk, PicturesAreTheSameWithAnyNumberOfThreads) {
  std::vector<Reference> made;
  for (const At at : {At::kPixels, At::kVertices})
    for (const std::size_t threads : {1, 5}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      Options options = pictureOptions(20, 20, 32);
      options.at = at;
      made.push_back(render(walked(icosphere(2), mediumOf(Rgb(0.9, 0.99, 0.5), Rgb(5, 9, 20), 1.3)),
                            uniformRig(), options));
    }
  for (const std::size_t i : {0, 2}) {
    EXPECT_EQ(made[i].picture.image.values, made[i + 1].picture.image.values);
    EXPECT_EQ(made[i].picture.report.counts.walks, made[i + 1].picture.report.counts.walks);
  }
}

}  // namespace
}  // namespace bakelight::tests
