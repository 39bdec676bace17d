#include "tools/player/vertex_radiance.h"

#include <cmath>
#include <limits>
#include <random>

#include "formats/error.h"
#include "tools/player/gl_context.h"
#include "transport/evaluator.h"

namespace bakelight::player {
namespace {

using transport::Float3;

struct Case {
  formats::DiffuseTransfer transfer;
  transport::ShLight light;
};

Case randomCase(int order, std::size_t vertex_count) {
  std::mt19937 random(static_cast<unsigned>(order));
  std::uniform_real_distribution<float> uniform(-1, 1);
  Case made{{order, "unshadowed", std::vector<float>(vertex_count * order * order)},
            transport::ShLight(order * order)};
  for (float& value : made.transfer.vectors) value = uniform(random);
  for (Float3& value : made.light) value = {100 * uniform(random), uniform(random), 0.01f * uniform(random)};
  return made;
}

std::vector<Float3> readBack(const Buffer& buffer, std::size_t vertex_count) {
  std::vector<Float3> radiance(vertex_count);
  glGetNamedBufferSubData(buffer.name(), 0, static_cast<GLsizeiptr>(vertex_count * sizeof(Float3)),
                          radiance.data());
  return radiance;
}

// The largest difference, relative to what the sum would be if nothing cancelled: that is what rounding
// scales with.
double largestRelativeError(const Case& made, const std::vector<Float3>& actual) {
  const auto expected = transport::evaluateDiffuse(made.transfer.vectors, made.transfer.order, made.light);
  EXPECT_EQ(actual.size(), expected.size());
  double largest = 0;
  const std::size_t count = made.light.size();
  for (std::size_t v = 0; v < expected.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c) {
      double scale = 0;
      for (std::size_t i = 0; i < count; ++i)
        scale += std::abs(made.transfer.vectors[v * count + i] * made.light[i][c]);
      largest = std::max(largest, std::abs(static_cast<double>(actual[v][c]) - expected[v][c]) / scale);
    }
  return largest;
}

class VertexRadianceTest : public testing::Test {
 protected:
  HeadlessContext context_;
};

TEST_F(VertexRadianceTest, AgreesWithTheCpuForEachOrder) {
  constexpr std::size_t kVertices = 1001;  // no multiple of the work group
  for (int order = 1; order <= 10; ++order) {
    const Case made = randomCase(order, kVertices);
    VertexRadiance vertex_radiance(made.transfer, kVertices);
    vertex_radiance.evaluate(made.light);
    EXPECT_LT(largestRelativeError(made, readBack(vertex_radiance.buffer(), kVertices)), 1e-5) << order;
  }
}

TEST_F(VertexRadianceTest, PiecesGiveTheSameAsTheWholeTable) {
  constexpr std::size_t kVertices = 1000;
  for (const int order : {1, 5, 10}) {
    const Case made = randomCase(order, kVertices);
    VertexRadiance whole(made.transfer, kVertices), pieces(made.transfer, kVertices, 40000);
    EXPECT_EQ(whole.dispatchCount(), 1);
    if (order > 1) {
      EXPECT_GT(pieces.dispatchCount(), 1) << "nothing was cut";
    }
    whole.evaluate(made.light);
    pieces.evaluate(made.light);
    EXPECT_EQ(readBack(pieces.buffer(), kVertices), readBack(whole.buffer(), kVertices)) << order;
  }
}

TEST_F(VertexRadianceTest, SecondLightReplacesTheFirst) {
  const Case made = randomCase(4, 100);
  VertexRadiance vertex_radiance(made.transfer, 100);
  vertex_radiance.evaluate(transport::uniformLight(4, {5, 5, 5}));
  vertex_radiance.evaluate(made.light);
  EXPECT_LT(largestRelativeError(made, readBack(vertex_radiance.buffer(), 100)), 1e-5);
}

TEST_F(VertexRadianceTest, NoVertexIsNoWork) {
  VertexRadiance vertex_radiance({3, "unshadowed", {}}, 0);
  vertex_radiance.evaluate(transport::uniformLight(3, {1, 1, 1}));
  EXPECT_EQ(vertex_radiance.dispatchCount(), 0);
}

TEST_F(VertexRadianceTest, LightThatIsNotFiniteIsAnErrorThatNamesTheCoefficient) {
  const Case made = randomCase(2, 10);
  VertexRadiance vertex_radiance(made.transfer, 10);
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    auto light = made.light;
    light[3][1] = value;
    try {
      vertex_radiance.evaluate(light);
      FAIL() << "accepted " << value;
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
      EXPECT_THAT(error.what(), testing::HasSubstr("coefficient 3"));
    }
  }
}

}  // namespace
}  // namespace bakelight::player
