#include "formats/pack.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>

#include "formats/draco_mesh.h"
#include "formats/error.h"
#include "formats/glb.h"
#include "tests/unit/formats/test_packs.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;

std::string errorOf(std::span<const std::byte> bytes) {
  try {
    decodePack(bytes, "a.glb");
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "no error";
}

TEST(Pack, RoundTripIsExact) {
  const Pack pack = diffusePack(wavyGrid(9), 5);
  const Pack read = roundTrip(pack, {});
  EXPECT_EQ(read.mesh.positions, pack.mesh.positions);
  EXPECT_EQ(read.mesh.triangles, pack.mesh.triangles);
  expectSamePack(read, pack);
}

TEST(Pack, SameInputGivesSameBytes) {
  const Pack pack = diffusePack(wavyGrid(5), 3);
  for (const bool draco : {false, true}) {
    EXPECT_EQ(encodePack(pack, {.draco = draco}, "a.glb"), encodePack(pack, {.draco = draco}, "b.glb"));
  }
}

TEST(Pack, SectionsCoverTheTablesAndAreAligned) {
  const Bytes bytes = encodePack(diffusePack(wavyGrid(4), 2), {}, "a.glb");
  std::vector<std::string> names;
  for (const PackSection& section : packSections(bytes, "a.glb")) {
    names.push_back(section.name);
    EXPECT_EQ(section.offset_bytes % 16, 0U) << section.name;
    EXPECT_LE(section.offset_bytes + section.size_bytes, bytes.size());
  }
  EXPECT_THAT(names, testing::ElementsAre("indices", "positions", "normals", "texcoords", "vectors"));
}

// Bit 0 of the file, then every `stride`-th.
void expectFlippedBitsAreErrors(Bytes bytes, std::size_t stride) {
  ASSERT_EQ(errorOf(bytes), "no error");
  for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += stride) {
    const auto mask = static_cast<std::byte>(1 << bit % 8);
    bytes[bit / 8] ^= mask;
    EXPECT_NE(errorOf(bytes), "no error") << "byte " << bit / 8 << ", bit " << bit % 8;
    bytes[bit / 8] ^= mask;
  }
}

TEST(Pack, EveryFlippedBitIsAnError) {
  TriangleMesh mesh = wavyGrid(2);
  mesh.texcoords.clear();
  expectFlippedBitsAreErrors(encodePack(diffusePack(mesh, 1), {}, "a.glb"), 1);
  expectFlippedBitsAreErrors(encodePack(diffusePack(mesh, 1), {.draco = true}, "a.glb"), 1);
  // One bit of (almost) every byte, as these are larger.
  expectFlippedBitsAreErrors(
      encodePack(glossyPack(mesh, Storage::kCpca, Precision::kUint8, Lobe::kTable), {}, "a.glb"), 9);
  expectFlippedBitsAreErrors(
      readFile(std::filesystem::path(BAKELIGHT_SOURCE_DIR) / "tests/unit/formats/golden/pack-v1.glb"), 9);
}

TEST(Pack, EveryTruncationIsAnError) {
  const Bytes bytes = encodePack(diffusePack(wavyGrid(2), 1), {}, "a.glb");
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THAT(errorOf(std::span(bytes).first(size)), HasSubstr("a.glb")) << size;
    // Even if the header were mended to the new size.
    Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    const auto word = static_cast<std::uint32_t>(size);
    if (size >= 12) std::memcpy(cut.data() + 8, &word, sizeof word);
    EXPECT_NE(errorOf(cut), "no error") << size;
  }
}

TEST(Pack, DamageIsNamed) {
  Bytes bytes = encodePack(diffusePack(wavyGrid(3), 2), {}, "a.glb");
  const auto sections = packSections(bytes, "a.glb");
  bytes[sections.back().offset_bytes + 3] ^= std::byte{1};
  EXPECT_THAT(errorOf(bytes), testing::AllOf(HasSubstr("section vectors"), HasSubstr("checksum")));
}

TEST(Pack, NewerVersionIsRefusedWithAdvice) {
  const Bytes bytes = encodePack(diffusePack(wavyGrid(2), 1), {}, "a.glb");
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t position = text.find("\"version\":3");
  ASSERT_NE(position, std::string::npos);
  text[position + 10] = '9';
  EXPECT_THAT(errorOf(std::as_bytes(std::span(text))),
              testing::AllOf(HasSubstr("version 9"), HasSubstr("newer Bakelight")));
}

TEST(Pack, OrdinaryGltfIsNotAPack) {
  std::string json = R"({"asset":{"version":"2.0"}})";
  json.resize(28, ' ');
  std::string glb = "glTF";
  const auto put = [&](std::uint32_t word) { glb.append(reinterpret_cast<const char*>(&word), sizeof word); };
  put(2), put(12 + 8 + 28), put(28), put(0x4E4F534A);
  glb += json;
  EXPECT_THAT(errorOf(std::as_bytes(std::span(glb))), HasSubstr("not a pack"));
}

TEST(Pack, NamesThatLookLikeJsonAreHarmless) {
  Pack pack = diffusePack(wavyGrid(2), 1);
  pack.name = R"("jsonChecksum":"0000000000000000" \)";
  EXPECT_EQ(roundTrip(pack, {}).name, pack.name);
}

TEST(Pack, FourGibibytesAreRefusedBeforeAnythingIsBuilt) {
  const Bytes block(std::size_t{1} << 26);
  GlbWriter writer;
  for (int i = 0; i < 64; ++i) writer.addSection("block", block, GlbTarget::kNone);
  EXPECT_THROW(writer.finish(Json::object(), "a.glb"), Error);
}

TEST(PackWithDraco, LosslessKeepsTablesInStep) {
  const Pack pack = diffusePack(wavyGrid(17), 5);
  const Pack read = roundTrip(pack, {.draco = true});
  EXPECT_EQ(read.mesh.vertexCount(), pack.mesh.vertexCount());
  EXPECT_EQ(read.mesh.triangleCount(), pack.mesh.triangleCount());
  EXPECT_NE(read.mesh.positions, pack.mesh.positions)
      << "Edgebreaker is expected to reorder: is the test still one?";
  expectSamePack(read, pack);
}

TEST(PackWithDraco, CoincidentVerticesKeepTheirOwnRows) {
  // Two sheets that share all positions and normals: only the rows tell them apart.
  TriangleMesh mesh = wavyGrid(3);
  const auto count = static_cast<std::uint32_t>(mesh.vertexCount());
  const TriangleMesh sheet = mesh;
  for (const auto& p : sheet.positions) mesh.positions.push_back(p);
  for (const auto& n : sheet.normals) mesh.normals.push_back(n);
  for (const auto& t : sheet.texcoords) mesh.texcoords.push_back(t);
  for (const Triangle& t : sheet.triangles)
    mesh.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  Pack pack = diffusePack(mesh, 1);
  std::vector<float> numbers(mesh.vertexCount());
  std::iota(numbers.begin(), numbers.end(), 0.0F);
  pack.sh().vectors = encodeTable(numbers, 1, Precision::kFloat32, "test", "table");

  const Pack read = roundTrip(pack, {.draco = true});
  ASSERT_EQ(read.mesh.vertexCount(), mesh.vertexCount());
  std::vector<float> rows = read.sh().vectors.decode();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(read.mesh.positions[i], mesh.positions[static_cast<std::size_t>(rows[i])]);
  }
  for (const Triangle& t : read.mesh.triangles) EXPECT_EQ(rows[t[0]] < 9, rows[t[1]] < 9);
  std::sort(rows.begin(), rows.end());
  EXPECT_EQ(rows, numbers) << "each row once";
}

TEST(PackWithDraco, DegenerateIsolatedAndNonManifoldStayInStep) {
  TriangleMesh mesh = wavyGrid(4);
  mesh.triangles.push_back({0, 0, 1});     // degenerate: dropped
  mesh.positions.push_back({5, 5, 5});     // isolated: dropped
  mesh.positions.push_back({0.5F, 3, 0});  // a fin: its edge has three triangles
  for (int i = 0; i < 2; ++i) mesh.normals.push_back({0, 1, 0}), mesh.texcoords.push_back({0, 0});
  mesh.triangles.push_back({5, 6, 17});
  mesh.triangles.push_back(mesh.triangles[0]);  // a duplicate
  const Pack pack = diffusePack(mesh, 3);
  const Pack read = roundTrip(pack, {.draco = true});
  EXPECT_EQ(read.mesh.triangleCount(), mesh.triangleCount() - 1);
  for (const Float3& position : read.mesh.positions) EXPECT_NE(position, (Float3{5, 5, 5}));
  expectSamePack(read, pack);
}

TEST(PackWithDraco, QuantizationErrsByHalfAStepAtMost) {
  const Pack pack = diffusePack(wavyGrid(17), 1);
  const DracoMesh draco = encodeDraco(pack.mesh, 12, 10, "a.glb");
  ASSERT_EQ(draco.source_from_decoded.size(), pack.mesh.vertexCount());
  const float half_step = 0.5F / 4095;  // of the unit square, the longest side of the box
  for (std::size_t i = 0; i < draco.source_from_decoded.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(draco.decoded.positions[i][axis], pack.mesh.positions[draco.source_from_decoded[i]][axis],
                  half_step * 1.001F);
    }
  }
  const Pack read = roundTrip(pack, {.draco = true, .position_bits = 12, .normal_bits = 10});
  EXPECT_EQ(read.mesh.positions, draco.decoded.positions);
  for (std::size_t i = 0; i < read.mesh.vertexCount(); ++i) {
    EXPECT_EQ(rowOf(read.sh().vectors, i), rowOf(pack.sh().vectors, draco.source_from_decoded[i]));
  }
}

TEST(PackWithDraco, OnlyDegenerateTrianglesAreRefused) {
  TriangleMesh mesh = wavyGrid(2);
  mesh.triangles = {{0, 0, 1}};
  EXPECT_THROW(encodePack(diffusePack(mesh, 1), {.draco = true}, "a.glb"), Error);
}

}  // namespace
}  // namespace bakelight::formats
