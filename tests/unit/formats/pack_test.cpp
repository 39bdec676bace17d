#include "formats/pack.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>

#include "formats/draco_mesh.h"
#include "formats/error.h"
#include "formats/glb.h"
#include "tests/unit/formats/test_meshes.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;

// The row of a vertex in the test's transfer table: a function of where the vertex is, so that it can be
// checked after any reordering.
float coefficient(const Float3& position, int i) {
  return position[0] * static_cast<float>(i + 1) + position[1] - 2 * position[2] * static_cast<float>(i);
}

Pack packOf(TriangleMesh mesh, int order) {
  Pack pack{"grid", std::move(mesh), {0.25F, 0.5F, 0.75F}, {order, "shadowed", {}}};
  for (const Float3& position : pack.mesh.positions) {
    for (int i = 0; i < order * order; ++i) pack.transfer.vectors.push_back(coefficient(position, i));
  }
  return pack;
}

void expectStepLock(const Pack& pack) {
  const int count = pack.transfer.order * pack.transfer.order;
  ASSERT_EQ(pack.transfer.vectors.size(), pack.mesh.vertexCount() * static_cast<std::size_t>(count));
  ASSERT_GT(pack.mesh.vertexCount(), 0U);
  for (std::size_t vertex = 0; vertex < pack.mesh.vertexCount(); ++vertex) {
    for (int i = 0; i < count; ++i) {
      ASSERT_EQ(pack.transfer.vectors[vertex * static_cast<std::size_t>(count) + static_cast<std::size_t>(i)],
                coefficient(pack.mesh.positions[vertex], i))
          << "vertex " << vertex << ", coefficient " << i;
    }
  }
}

Pack roundTrip(const Pack& pack, const PackOptions& options) {
  return decodePack(encodePack(pack, options, "a.glb"), "a.glb");
}

std::string errorOf(std::span<const std::byte> bytes) {
  try {
    decodePack(bytes, "a.glb");
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "no error";
}

std::string encodeErrorOf(const Pack& pack, const PackOptions& options = {}) {
  try {
    encodePack(pack, options, "a.glb");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Pack, RoundTripIsExact) {
  const Pack pack = packOf(wavyGrid(9), 5);
  const Pack read = roundTrip(pack, {});
  EXPECT_EQ(read.name, pack.name);
  EXPECT_EQ(read.base_color, pack.base_color);
  EXPECT_EQ(read.mesh.positions, pack.mesh.positions);
  EXPECT_EQ(read.mesh.normals, pack.mesh.normals);
  EXPECT_EQ(read.mesh.texcoords, pack.mesh.texcoords);
  EXPECT_EQ(read.mesh.triangles, pack.mesh.triangles);
  EXPECT_EQ(read.transfer.order, 5);
  EXPECT_EQ(read.transfer.visibility, "shadowed");
  EXPECT_EQ(read.transfer.vectors, pack.transfer.vectors);
}

TEST(Pack, SameInputGivesSameBytes) {
  const Pack pack = packOf(wavyGrid(5), 3);
  for (const bool draco : {false, true}) {
    EXPECT_EQ(encodePack(pack, {.draco = draco}, "a.glb"), encodePack(pack, {.draco = draco}, "b.glb"));
  }
}

TEST(Pack, SectionsCoverTheTablesAndAreAligned) {
  const Bytes bytes = encodePack(packOf(wavyGrid(4), 2), {}, "a.glb");
  std::vector<std::string> names;
  for (const PackSection& section : packSections(bytes, "a.glb")) {
    names.push_back(section.name);
    EXPECT_EQ(section.offset_bytes % 16, 0U) << section.name;
    EXPECT_LE(section.offset_bytes + section.size_bytes, bytes.size());
  }
  EXPECT_THAT(names, testing::ElementsAre("indices", "positions", "normals", "texcoords", "transfer"));
}

TEST(Pack, EveryFlippedBitIsAnError) {
  TriangleMesh mesh = wavyGrid(2);
  mesh.texcoords.clear();
  for (const bool draco : {false, true}) {
    Bytes bytes = encodePack(packOf(mesh, 1), {.draco = draco}, "a.glb");
    ASSERT_EQ(errorOf(bytes), "no error");
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      for (int bit = 0; bit < 8; ++bit) {
        const std::byte original = bytes[i];
        bytes[i] ^= static_cast<std::byte>(1 << bit);
        EXPECT_NE(errorOf(bytes), "no error") << "byte " << i << ", bit " << bit;
        bytes[i] = original;
      }
    }
  }
}

TEST(Pack, EveryTruncationIsAnError) {
  const Bytes bytes = encodePack(packOf(wavyGrid(2), 1), {}, "a.glb");
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
  Bytes bytes = encodePack(packOf(wavyGrid(3), 2), {}, "a.glb");
  const auto sections = packSections(bytes, "a.glb");
  bytes[sections.back().offset_bytes + 3] ^= std::byte{1};
  EXPECT_THAT(errorOf(bytes), testing::AllOf(HasSubstr("section transfer"), HasSubstr("checksum")));
}

// A GLB with valid checksums around any JSON, as a hostile author can make it.
Bytes withJson(const Pack& pack, const std::function<void(Json&)>& change) {
  const Bytes bytes = encodePack(pack, {}, "a.glb");
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, sizeof size);
  Json document = Json::parse(reinterpret_cast<const char*>(bytes.data()) + 20,
                              reinterpret_cast<const char*>(bytes.data()) + 20 + size);
  for (const char* key : {"bufferViews", "buffers", "extensions"}) document.erase(key);
  change(document);
  GlbWriter writer;
  for (const PackSection& section : packSections(bytes, "a.glb")) {
    writer.addSection(section.name, std::span(bytes).subspan(section.offset_bytes, section.size_bytes),
                      GlbTarget::kNone);
  }
  return writer.finish(std::move(document), "a.glb");
}

TEST(Pack, HostileNumbersAreErrors) {
  const Pack pack = packOf(wavyGrid(3), 2);
  ASSERT_EQ(errorOf(withJson(pack, [](Json&) {})), "no error");
  const std::string extension = std::string("/meshes/0/primitives/0/extensions/") + kTransferExtension;
  const std::vector<std::pair<std::string, Json>> cases = {
      {"/accessors/1/count", 0x4000000000000001ULL},  // × 12 wraps
      {"/accessors/1/count", 10},
      {"/accessors/1/count", -9},
      {"/accessors/1/count", 9.5},
      {"/accessors/0/count", 0xFFFFFFFFFFFFFFFFULL},
      {"/accessors/1/bufferView", 99},
      {"/accessors/1/componentType", 5123},
      {"/meshes/0/primitives/0/attributes/POSITION", 18446744073709551615ULL},
      {"/meshes/0/primitives/0/indices", "0"},
      {extension + "/order", 4294967298ULL},  // 2 in 32 bits
      {extension + "/order", 11},
      {extension + "/coefficientsPerVertex", 5},
      {extension + "/bufferView", 0},
      {extension + "/technique", "other"},
      {extension + "/visibility", "maybe"},
      {"/materials/0/pbrMetallicRoughness/baseColorFactor", {1e300, 0, 0, 1}},
      {"/materials/0/pbrMetallicRoughness/baseColorFactor", {2, 0, 0, 1}},
      {"/meshes", Json::array()},
  };
  for (const auto& [pointer, value] : cases) {
    const Bytes bytes = withJson(pack, [&](Json& json) { json.at(Json::json_pointer(pointer)) = value; });
    EXPECT_THAT(errorOf(bytes), HasSubstr("a.glb")) << pointer << " = " << value;
  }
}

TEST(Pack, NewerVersionIsRefusedWithAdvice) {
  const Bytes bytes = encodePack(packOf(wavyGrid(2), 1), {}, "a.glb");
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t position = text.find("\"version\":1");
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

TEST(Pack, WhatCannotBeAPackIsRefused) {
  const Pack good = packOf(wavyGrid(3), 2);
  Pack pack = good;
  pack.mesh = {};
  pack.transfer.vectors.clear();
  EXPECT_THAT(encodeErrorOf(pack), HasSubstr("no vertex"));
  pack = good;
  pack.mesh.normals.pop_back();
  EXPECT_THAT(encodeErrorOf(pack), HasSubstr("8 normals"));
  pack = good;
  pack.mesh.normals[4] = {0, 2, 0};
  EXPECT_THAT(encodeErrorOf(pack), HasSubstr("vertex 4"));
  pack = good;
  pack.transfer.vectors.pop_back();
  EXPECT_THAT(encodeErrorOf(pack), HasSubstr("9 vertices × 4 coefficients"));
  pack = good;
  pack.transfer.vectors[9] = std::nanf("");
  EXPECT_THAT(encodeErrorOf(pack), HasSubstr("transfer of vertex 2: coefficient 1"));
  pack = good;
  pack.mesh.triangles[1][2] = 9;
  EXPECT_THAT(encodeErrorOf(pack), HasSubstr("triangle 1: vertex 9"));
  pack = good;
  pack.name = "\xFF";
  EXPECT_THAT(encodeErrorOf(pack), HasSubstr("UTF-8"));
}

TEST(Pack, NamesThatLookLikeJsonAreHarmless) {
  Pack pack = packOf(wavyGrid(2), 1);
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
  const Pack pack = packOf(wavyGrid(17), 5);
  const Pack read = roundTrip(pack, {.draco = true});
  EXPECT_EQ(read.mesh.vertexCount(), pack.mesh.vertexCount());
  EXPECT_EQ(read.mesh.triangleCount(), pack.mesh.triangleCount());
  EXPECT_NE(read.mesh.positions, pack.mesh.positions)
      << "Edgebreaker is expected to reorder: is the test still one?";
  expectStepLock(read);
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
  Pack pack = packOf(mesh, 1);
  for (std::size_t i = 0; i < mesh.vertexCount(); ++i) pack.transfer.vectors[i] = static_cast<float>(i);

  const Pack read = roundTrip(pack, {.draco = true});
  ASSERT_EQ(read.mesh.vertexCount(), mesh.vertexCount());
  std::vector<float> rows = read.transfer.vectors;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(read.mesh.positions[i], mesh.positions[static_cast<std::size_t>(rows[i])]);
  }
  for (const Triangle& t : read.mesh.triangles) EXPECT_EQ(rows[t[0]] < 9, rows[t[1]] < 9);
  std::sort(rows.begin(), rows.end());
  EXPECT_EQ(rows, pack.transfer.vectors) << "each row once";
}

TEST(PackWithDraco, DegenerateIsolatedAndNonManifoldStayInStep) {
  TriangleMesh mesh = wavyGrid(4);
  mesh.triangles.push_back({0, 0, 1});     // degenerate: dropped
  mesh.positions.push_back({5, 5, 5});     // isolated: dropped
  mesh.positions.push_back({0.5F, 3, 0});  // a fin: its edge has three triangles
  for (int i = 0; i < 2; ++i) mesh.normals.push_back({0, 1, 0}), mesh.texcoords.push_back({0, 0});
  mesh.triangles.push_back({5, 6, 17});
  mesh.triangles.push_back(mesh.triangles[0]);  // a duplicate
  const Pack pack = packOf(mesh, 3);
  const Pack read = roundTrip(pack, {.draco = true});
  EXPECT_EQ(read.mesh.triangleCount(), mesh.triangleCount() - 1);
  for (const Float3& position : read.mesh.positions) EXPECT_NE(position, (Float3{5, 5, 5}));
  expectStepLock(read);
}

TEST(PackWithDraco, QuantisationErrsByHalfAStepAtMost) {
  const Pack pack = packOf(wavyGrid(17), 1);
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
    EXPECT_EQ(read.transfer.vectors[i], pack.transfer.vectors[draco.source_from_decoded[i]]);
  }
}

TEST(PackWithDraco, OnlyDegenerateTrianglesAreRefused) {
  TriangleMesh mesh = wavyGrid(2);
  mesh.triangles = {{0, 0, 1}};
  EXPECT_THAT(encodeErrorOf(packOf(mesh, 1), {.draco = true}), HasSubstr("draco"));
}

// Packs of version 1 as the first release wrote them: wavyGrid(3) at order 2. They stay readable for ever.
class GoldenPack : public testing::TestWithParam<const char*> {};

TEST_P(GoldenPack, StaysReadable) {
  const Pack read =
      readPack(std::filesystem::path(BAKELIGHT_SOURCE_DIR) / "tests/unit/formats/golden" / GetParam());
  const Pack expected = packOf(wavyGrid(3), 2);
  EXPECT_EQ(read.name, "grid");
  EXPECT_EQ(read.base_color, expected.base_color);
  EXPECT_EQ(read.transfer.visibility, "shadowed");
  ASSERT_EQ(read.mesh.vertexCount(), 9U);
  ASSERT_EQ(read.mesh.triangleCount(), 8U);
  // Sines differ in the last bit between C libraries, so values near, not equal, to a grid made today; and by
  // position, as Draco reorders.
  for (std::size_t i = 0; i < 9; ++i) {
    const Float3& position = read.mesh.positions[i];
    const auto column = static_cast<std::size_t>(std::lround(position[0] * 2));
    const auto row = static_cast<std::size_t>(std::lround(-position[2] * 2));
    const std::size_t source = row * 3 + column;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(position[axis], expected.mesh.positions[source][axis], 1e-6F);
      EXPECT_NEAR(read.mesh.normals[i][axis], expected.mesh.normals[source][axis], 1e-6F);
    }
    EXPECT_EQ(read.mesh.texcoords[i], expected.mesh.texcoords[source]);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_NEAR(read.transfer.vectors[i * 4 + k], expected.transfer.vectors[source * 4 + k], 1e-5F);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Version1, GoldenPack, testing::Values("pack-v1.glb", "pack-v1-draco.glb"),
                         [](const auto& test) {
                           const bool is_draco = std::string(test.param).find("draco") != std::string::npos;
                           return std::string(is_draco ? "Draco" : "Plain");
                         });

}  // namespace
}  // namespace bakelight::formats
