#include "tools/player/operators/diffuse_pass.h"

#include <cmath>
#include <limits>
#include <random>

#include "formats/error.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/lights/gpu_light.h"
#include "transport/evaluator.h"

namespace bakelight::player {
namespace {

using transport::Float3;

struct Case {
  int order;
  std::vector<float> values;
  formats::EncodedTable table;
  transport::ShLight light;
};

Case randomCase(int order, std::size_t vertex_count,
                formats::Precision precision = formats::Precision::kFloat32) {
  std::mt19937 random(static_cast<unsigned>(order));
  std::uniform_real_distribution<float> uniform(-1, 1);
  Case made{order, std::vector<float>(vertex_count * order * order), {}, transport::ShLight(order * order)};
  for (float& value : made.values) value = uniform(random);
  for (Float3& value : made.light) value = {100 * uniform(random), uniform(random), 0.01f * uniform(random)};
  made.table = formats::encodeTable(made.values, order * order, precision, "made", "table");
  made.values = made.table.decode();
  return made;
}

// The pass and what it needs, evaluated.
struct Evaluated {
  GpuTable table;
  DiffusePass pass;
  GpuLight light = darkLight();

  explicit Evaluated(const Case& made, std::size_t largest_block_bytes = 0)
      : table(made.table), pass(table, made.order, 1, {}, false, largest_block_bytes) {
    setLight(light, made.light);
    pass.evaluate(light.sh);
  }
};

std::vector<Float3> readBack(const Buffer& buffer, std::size_t vertex_count) {
  std::vector<Float3> radiance(vertex_count);
  glGetNamedBufferSubData(buffer.name(), 0, static_cast<GLsizeiptr>(vertex_count * sizeof(Float3)),
                          radiance.data());
  return radiance;
}

// The largest difference, relative to what the sum would be if nothing cancelled: that is what rounding
// scales with.
double largestRelativeError(const Case& made, const std::vector<Float3>& actual) {
  const auto expected = transport::evaluateDiffuse(made.values, made.order, made.light);
  EXPECT_EQ(actual.size(), expected.size());
  double largest = 0;
  const std::size_t count = made.light.size();
  for (std::size_t v = 0; v < expected.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c) {
      double scale = 0;
      for (std::size_t i = 0; i < count; ++i)
        scale += std::abs(made.values[v * count + i] * made.light[i][c]);
      largest = std::max(largest, std::abs(static_cast<double>(actual[v][c]) - expected[v][c]) / scale);
    }
  return largest;
}

class DiffusePassTest : public testing::Test {
 protected:
  HeadlessContext context_;
};

TEST_F(DiffusePassTest, AgreesWithTheCpuForEachOrderAndPrecision) {
  constexpr std::size_t kVertices = 1001;  // no multiple of the work group, nor of a word's bytes
  for (int order = 1; order <= 10; ++order)
    for (const auto precision :
         {formats::Precision::kFloat32, formats::Precision::kFloat16, formats::Precision::kUint8}) {
      const Case made = randomCase(order, kVertices, precision);
      EXPECT_LT(largestRelativeError(made, readBack(Evaluated(made).pass.buffer(), kVertices)), 1e-5)
          << order << ' ' << formats::nameOf(precision);
    }
}

TEST_F(DiffusePassTest, PiecesGiveTheSameAsTheWholeTable) {
  constexpr std::size_t kVertices = 1000;
  for (const auto precision :
       {formats::Precision::kFloat32, formats::Precision::kFloat16, formats::Precision::kUint8})
    for (const int order : {1, 5, 10}) {
      const Case made = randomCase(order, kVertices, precision);
      const Evaluated whole(made), pieces(made, 8000);
      EXPECT_EQ(whole.pass.dispatchCount(), 1u);
      if (order > 1) {
        EXPECT_GT(pieces.pass.dispatchCount(), 1u) << "nothing was cut";
      }
      EXPECT_EQ(readBack(pieces.pass.buffer(), kVertices), readBack(whole.pass.buffer(), kVertices))
          << order << ' ' << formats::nameOf(precision);
    }
}

TEST_F(DiffusePassTest, SecondLightReplacesTheFirst) {
  const Case made = randomCase(4, 100);
  Evaluated evaluated(made);
  setLight(evaluated.light, transport::uniformLight(4, {5, 5, 5}));
  evaluated.pass.evaluate(evaluated.light.sh);
  setLight(evaluated.light, made.light);
  evaluated.pass.evaluate(evaluated.light.sh);
  EXPECT_LT(largestRelativeError(made, readBack(evaluated.pass.buffer(), 100)), 1e-5);
}

TEST_F(DiffusePassTest, ChannelsColorsAndAdditionMultiplyOut) {
  constexpr std::size_t kVertices = 70;
  // Order 1: the transfer of a vertex is one number a channel.
  std::vector<float> transfer;
  std::vector<Float3> colors;
  for (std::size_t v = 0; v < kVertices; ++v) {
    const auto x = static_cast<float>(v);
    transfer.insert(transfer.end(), {x, 2 * x, 3});
    colors.push_back({1, 0.5f, x / kVertices});
  }
  const GpuTable table(formats::encodeTable(transfer, 3, formats::Precision::kFloat32, "made", "table"));
  const Buffer color_buffer = makeBuffer(kVertices * sizeof(Float3), colors.data());
  GpuLight light = darkLight();
  setLight(light, std::vector<Float3>{{1, 10, 100}});
  const Albedo albedo{{0.5f, 1, 0.25f}, &color_buffer};
  DiffusePass first(table, 1, 3, albedo, false), second(table, 1, 3, albedo, true);
  first.evaluate(light.sh);
  second.evaluate(light.sh, &first.buffer());
  const auto once = readBack(first.buffer(), kVertices), twice = readBack(second.buffer(), kVertices);
  for (std::size_t v = 0; v < kVertices; ++v) {
    const auto x = static_cast<float>(v);
    const Float3 expected = {0.5f * x, 0.5f * 20 * x, 75 * colors[v][2]};
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(once[v][c], expected[c], 1e-4f * (1 + expected[c])) << v;
      EXPECT_NEAR(twice[v][c], 2 * expected[c], 2e-4f * (1 + expected[c])) << v;
    }
  }
}

TEST_F(DiffusePassTest, NoVertexIsNoWork) {
  const GpuTable table;
  DiffusePass pass(table, 3, 1, {}, false);
  pass.evaluate(darkLight().sh);
  EXPECT_EQ(pass.dispatchCount(), 0u);
}

TEST_F(DiffusePassTest, LightThatIsNotFiniteIsAnErrorThatNamesTheCoefficient) {
  GpuLight buffer = darkLight();
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    auto light = transport::uniformLight(2, {1, 1, 1});
    light[3][1] = value;
    try {
      setLight(buffer, light);
      FAIL() << "accepted " << value;
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
      EXPECT_THAT(error.what(), testing::HasSubstr("coefficient 3"));
    }
  }
}

}  // namespace
}  // namespace bakelight::player
