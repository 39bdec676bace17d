#include "formats/compare.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "formats/btf_writer.h"
#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "tests/stages/scenes.h"
#include "tests/support/pack_parts.h"

namespace bakelight::formats {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const Difference& differenceCalled(const Comparison& comparison, const std::string& what) {
  for (const Difference& difference : comparison.differences)
    if (difference.what == what) return difference;
  throw std::runtime_error("no difference is called " + what);
}

std::string failingDifferences(const Comparison& comparison) {
  std::string names;
  for (const Difference& difference : comparison.differences)
    if (!difference.passes()) names += difference.what + ";";
  return names;
}

TensorFile tensorsOf(std::vector<float> values, std::vector<std::uint64_t> shape = {2, 2}) {
  TensorFile file;
  file.tensors["a"] = Tensor::from<float>(ElementType::kFloat32, std::move(shape), values);
  file.metadata = {{"order", "1"}, {"mesh_hash", "x"}};
  return file;
}

EncodedTable columnOf(const TriangleMesh& mesh, float value) {
  const std::vector<float> values(mesh.vertexCount(), value);
  return encodeTable(values, 1, Precision::kFloat32, "test", "table");
}

Pack packOf(const TriangleMesh& mesh) {
  Pack pack{.name = "two", .mesh = mesh};
  pack.appearances[0].base_color = {0.5f, 0.5f, 0.5f};
  pack.sh().order = 1;
  pack.sh().transport = Transport::kUnshadowed;
  pack.sh().vectors = columnOf(mesh, 0.25f);
  return pack;
}

Pack glossyPackOf(const TriangleMesh& mesh) {
  Pack pack = packOf(mesh);
  makeGlossy(pack.sh(), Storage::kMatrix, 1);
  for (const Float3& n : mesh.normals) {
    // Of right angles to a normal on any axis or between them.
    const Float3 t = std::abs(n[0]) < 0.5f ? Float3{1, 0, 0} : Float3{0, 1, 0};
    const float along = t[0] * n[0] + t[1] * n[1];
    const float length = std::sqrt(1 - along * along);
    pack.sh().glossy->tangents.push_back(
        {(t[0] - along * n[0]) / length, (t[1] - along * n[1]) / length, -along * n[2] / length, 1});
  }
  pack.sh().glossy->vertexTable() = columnOf(mesh, 0.5f);
  reflectionOf(pack) = GgxLobe();
  return pack;
}

TEST(CompareMeshes, EqualMeshesPassWithoutTolerance) {
  const TriangleMesh mesh = stages::twoSpheres(2);
  const Comparison comparison = compareMeshes(mesh, mesh, {});
  EXPECT_TRUE(comparison.passes());
  EXPECT_EQ(comparison.compared_values, 132U + 256U);
  EXPECT_EQ(comparison.differences.size(), 3U);
}

TEST(CompareMeshes, MeasuresTheLargestMoveOverTheDiagonal) {
  const TriangleMesh reference = stages::sphere(1);
  TriangleMesh mesh = reference;
  mesh.positions[0] = {1.125f, 0, 0};  // away from all others
  const Comparison comparison = compareMeshes(mesh, reference, {.distance = 0.01});
  EXPECT_FALSE(comparison.passes());
  EXPECT_DOUBLE_EQ(differenceCalled(comparison, "vertices, distance").measured, 0.125 / std::sqrt(12.0));
  EXPECT_TRUE(compareMeshes(mesh, reference, {.distance = 0.04}).passes());
}

TEST(CompareMeshes, ColorsCount) {
  TriangleMesh reference = stages::sphere(1);
  reference.colors.assign(reference.vertexCount(), {0.5f, 0.5f, 0.5f});
  TriangleMesh mesh = reference;
  EXPECT_TRUE(compareMeshes(mesh, reference, {}).passes());
  mesh.colors[7][2] = 0.75f;
  EXPECT_EQ(differenceCalled(compareMeshes(mesh, reference, {}), "colors, maximum").measured, 0.25);
  EXPECT_FALSE(compareMeshes(mesh, reference, {.maximum = 0.2}).passes());
  EXPECT_TRUE(compareMeshes(mesh, reference, {.maximum = 0.25}).passes());
  mesh.colors.clear();
  EXPECT_FALSE(compareMeshes(mesh, reference, {.maximum = 1}).passes());
}

TEST(CompareMeshes, MaterialsCount) {
  TriangleMesh reference = stages::sphere(1);
  for (std::uint32_t t = 0; t < reference.triangleCount(); ++t) reference.triangle_materials.push_back(t % 2);
  reference.material_names = {"red", "blue"};
  TriangleMesh mesh = reference;
  EXPECT_TRUE(compareMeshes(mesh, reference, {}).passes());
  std::swap(mesh.triangle_materials[2], mesh.triangle_materials[5]);
  EXPECT_GT(differenceCalled(compareMeshes(mesh, reference, {}), "material 0, distance").measured, 0.05);
  EXPECT_FALSE(compareMeshes(mesh, reference, {}).passes());
  mesh = reference;
  mesh.material_names[1] = "green";
  EXPECT_FALSE(compareMeshes(mesh, reference, {.distance = 1}).passes());
  mesh = reference;
  mesh.triangle_materials[0] = 1;
  EXPECT_FALSE(compareMeshes(mesh, reference, {.distance = 1}).passes());
  mesh.triangle_materials.clear();
  mesh.material_names.clear();
  EXPECT_FALSE(compareMeshes(mesh, reference, {.distance = 1}).passes());
}

TEST(CompareMeshes, BothDirectionsCount) {
  // Each vertex of `doubled` lies on one of `reference`, but not the other way round.
  const TriangleMesh reference = stages::sphere(0);
  TriangleMesh doubled = reference;
  doubled.positions[1] = doubled.positions[0];
  EXPECT_GT(differenceCalled(compareMeshes(doubled, reference, {}), "vertices, distance").measured, 0.1);
  EXPECT_GT(differenceCalled(compareMeshes(reference, doubled, {}), "vertices, distance").measured, 0.1);
}

TEST(CompareMeshes, OrderOfVerticesDoesNotCountButConnectionsDo) {
  const TriangleMesh reference = stages::sphere(1);
  TriangleMesh reordered = reference;
  std::reverse(reordered.positions.begin(), reordered.positions.end());
  std::reverse(reordered.normals.begin(), reordered.normals.end());
  const auto last = static_cast<std::uint32_t>(reference.vertexCount() - 1);
  for (Triangle& t : reordered.triangles) t = {last - t[0], last - t[1], last - t[2]};
  EXPECT_TRUE(compareMeshes(reordered, reference, {.distance = 1e-7}).passes());

  TriangleMesh rewired = reference;
  rewired.triangles[0] = rewired.triangles[1];
  EXPECT_EQ(failingDifferences(compareMeshes(rewired, reference, {})), "triangles, distance;");
}

TEST(CompareMeshes, CountsAndAttributesAgreeExactly) {
  const TriangleMesh reference = stages::sphere(1);
  TriangleMesh fewer = reference, bare = reference;
  fewer.triangles.pop_back();
  bare.normals.clear();
  EXPECT_THAT(compareMeshes(fewer, reference, {.distance = 1}).mismatches,
              Contains("triangles: 31, the reference has 32"));
  EXPECT_FALSE(compareMeshes(fewer, reference, {.distance = 1}).passes());
  EXPECT_FALSE(compareMeshes(bare, reference, {.distance = 1, .normal = 2}).passes());
}

TEST(CompareMeshes, ATurnedNormalShows) {
  const TriangleMesh reference = stages::sphere(1);
  TriangleMesh mesh = reference;
  mesh.normals[5] = {0, 0, 1};  // was −z
  const Comparison comparison = compareMeshes(mesh, reference, {.normal = 1.9});
  EXPECT_EQ(failingDifferences(comparison), "normals, difference;");
  EXPECT_DOUBLE_EQ(differenceCalled(comparison, "normals, difference").measured, 2);
}

TEST(CompareMeshes, NormalsAtACreaseFindTheirCounterpart) {
  TriangleMesh creased = stages::sphere(0);
  creased.positions.push_back(creased.positions[0]);
  creased.normals.push_back({0, 1, 0});
  creased.triangles[0][0] = 6;
  EXPECT_TRUE(compareMeshes(creased, creased, {}).passes());
}

TEST(CompareMeshes, NothingComparedIsAFailure) {
  EXPECT_FALSE(compareMeshes({}, {}, {.distance = 1}).passes());
  EXPECT_FALSE(Comparison().passes());
}

TEST(CompareImages, MeasuresMaximumAndRmsOfEachChannel) {
  Image reference(4, 1, {"R", "G"});
  Image image = reference;
  image.texel(2, 0)[1] = 0.5f;
  const Comparison comparison = compareImages(image, reference, {.maximum = 0.5, .rms = 0.2});
  EXPECT_EQ(failingDifferences(comparison), "channel G, rms;");
  EXPECT_DOUBLE_EQ(differenceCalled(comparison, "channel G, maximum").measured, 0.5);
  EXPECT_DOUBLE_EQ(differenceCalled(comparison, "channel G, rms").measured, 0.25);
  EXPECT_TRUE(compareImages(image, reference, {.maximum = 0.5, .rms = 0.25}).passes());
}

TEST(CompareImages, SizeAndChannelNamesAgreeExactly) {
  const Image reference(2, 2, {"R", "G"});
  EXPECT_TRUE(compareImages(reference, reference, {}).passes());
  EXPECT_FALSE(compareImages(Image(2, 2, {"R", "B"}), reference, {}).passes());
  EXPECT_FALSE(compareImages(Image(4, 1, {"R", "G"}), reference, {}).passes());
  EXPECT_FALSE(compareImages(Image(), Image(), {}).passes());
}

TEST(CompareIndices, CountsValuesThatAreOthers) {
  const IndexImage reference(5, 2, {"vertex", "material"});
  IndexImage image = reference;
  image.texel(3, 1)[0] = 1;
  image.texel(4, 1)[0] = 70000;
  const Comparison comparison = compareIndices(image, reference, {.share = 0.1});
  EXPECT_EQ(failingDifferences(comparison), "channel vertex, share of others;");
  EXPECT_DOUBLE_EQ(differenceCalled(comparison, "channel vertex, share of others").measured, 0.2);
  EXPECT_TRUE(compareIndices(image, reference, {.share = 0.2}).passes());
  EXPECT_FALSE(compareIndices(IndexImage(2, 5, {"vertex", "material"}), reference, {.share = 1}).passes());
  EXPECT_FALSE(compareIndices(IndexImage(), IndexImage(), {.share = 1}).passes());
}

TEST(CompareImages, NanNeverPasses) {
  const Image reference(1, 1, {"Y"});
  Image image = reference;
  image.values[0] = std::nanf("");
  EXPECT_EQ(failingDifferences(compareImages(image, reference, {.maximum = 1e30, .rms = 1e30})),
            "channel Y, maximum;channel Y, rms;");
}

TEST(CompareTensors, MeasuresRelativeNormAndMaximum) {
  const TensorFile reference = tensorsOf({3, 0, 0, 4});
  const Comparison comparison = compareTensors(tensorsOf({3, 0.5f, 0, 4}), reference, {.maximum = 0.5});
  EXPECT_EQ(failingDifferences(comparison), "tensor a, relative norm;");
  EXPECT_DOUBLE_EQ(differenceCalled(comparison, "tensor a, relative norm").measured, 0.1);
  EXPECT_EQ(comparison.compared_values, 4U);
}

TEST(CompareTensors, NamesShapesTypesAndMetadataAgreeExactly) {
  const TensorFile reference = tensorsOf({1, 2, 3, 4});
  EXPECT_TRUE(compareTensors(reference, reference, {}).passes());
  EXPECT_FALSE(compareTensors(tensorsOf({1, 2, 3, 4}, {4, 1}), reference, {}).passes());

  TensorFile renamed, retyped = reference, extra = reference, annotated = reference;
  renamed.tensors["b"] = reference.tensors.at("a");
  EXPECT_FALSE(compareTensors(renamed, reference, {}).passes());
  retyped.tensors["a"].type = ElementType::kUint32;
  EXPECT_FALSE(compareTensors(retyped, reference, {}).passes());
  extra.tensors["b"] = reference.tensors.at("a");
  EXPECT_FALSE(compareTensors(extra, reference, {}).passes());
  EXPECT_FALSE(compareTensors(reference, extra, {}).passes());
  annotated.metadata["mesh_hash"] = "y";
  EXPECT_FALSE(compareTensors(annotated, reference, {}).passes());
  EXPECT_TRUE(compareTensors(annotated, reference, {.ignored_keys = {"mesh_hash"}}).passes());
  EXPECT_FALSE(compareTensors({}, {}, {}).passes());
}

TEST(CompareJson, CountsExactlyRealsWithinALimit) {
  const Json reference = {{"count", 100}, {"energy", 2.0}, {"wall_s", 5.5}};
  const CompareLimits limits = {.relative = 0.01, .ignored_keys = {"wall_s"}};
  EXPECT_TRUE(compareJson({{"count", 100}, {"energy", 2.01}, {"wall_s", 99.0}}, reference, limits).passes());
  EXPECT_TRUE(compareJson({{"count", 100}, {"energy", 2.01}}, reference, limits).passes());
  EXPECT_FALSE(compareJson({{"count", 101}, {"energy", 2.0}}, reference, limits).passes());
  EXPECT_FALSE(compareJson({{"count", 100}, {"energy", 2.1}}, reference, limits).passes());
  EXPECT_FALSE(compareJson({{"count", 100}}, reference, limits).passes());
  EXPECT_FALSE(compareJson({{"count", 100}, {"energy", 2.0}, {"more", 1}}, reference, limits).passes());
  EXPECT_FALSE(compareJson({{"count", 100}, {"energy", "2"}}, reference, limits).passes());
}

TEST(CompareJson, WalksIntoListsAndObjects) {
  const Json reference = {{"list", {{{"name", "a"}}, {{"name", "b"}}}}};
  EXPECT_TRUE(compareJson(reference, reference, {}).passes());
  const Comparison renamed = compareJson({{"list", {{{"name", "a"}}, {{"name", "c"}}}}}, reference, {});
  EXPECT_THAT(renamed.mismatches, Contains(HasSubstr("/list/1/name")));
  EXPECT_FALSE(compareJson({{"list", {{{"name", "a"}}}}}, reference, {}).passes());
}

TEST(CompareJson, NothingComparedIsAFailure) {
  EXPECT_FALSE(compareJson(Json::object(), Json::object(), {}).passes());
  EXPECT_FALSE(compareJson({{"wall_s", 1.0}}, {{"wall_s", 1.0}}, {.ignored_keys = {"wall_s"}}).passes());
}

// The first value becomes next to nothing.
void blacken(EncodedTable& table) {
  Bytes bytes(table.data.begin(), table.data.end());
  bytes[3] = std::byte{0};
  table.data = std::move(bytes);
}

TEST(ComparePacks, EachPartShows) {
  const Pack reference = packOf(stages::twoSpheres(0));
  EXPECT_TRUE(comparePacks(reference, reference, {}).passes());

  Pack renamed = reference, recolored = reference, retyped = reference, moved = reference, darker = reference;
  renamed.name = "three";
  recolored.appearances[0].base_color[1] = 0.25f;
  retyped.sh().transport = Transport::kShadowed;
  moved.mesh.positions[0][0] += 0.25f;
  blacken(darker.sh().vectors);
  EXPECT_FALSE(comparePacks(renamed, reference, {}).passes());
  EXPECT_FALSE(comparePacks(recolored, reference, {}).passes());
  EXPECT_FALSE(comparePacks(retyped, reference, {}).passes());
  EXPECT_THAT(failingDifferences(comparePacks(moved, reference, {})), HasSubstr("vertices, distance"));
  EXPECT_EQ(failingDifferences(comparePacks(darker, reference, {})),
            "transfer vectors, relative norm;transfer vectors, maximum;");
}

TEST(ComparePacks, EachGlossyPartShows) {
  const Pack reference = glossyPackOf(stages::twoSpheres(0));
  EXPECT_TRUE(comparePacks(reference, reference, {}).passes());
  EXPECT_FALSE(comparePacks(packOf(stages::twoSpheres(0)), reference, {}).passes());

  Pack rougher = reference, coded = reference, turned = reference, darker = reference, colored = reference;
  reflectionAs<GgxLobe>(rougher).roughness = 0.5f;
  coded.sh().glossy->vertexTable().precision = Precision::kFloat16;
  turned.sh().glossy->tangents[0][3] = -1;
  blacken(darker.sh().glossy->vertexTable());
  colored.colors.assign(reference.mesh.vertexCount(), {1, 1, 1});
  EXPECT_THAT(comparePacks(rougher, reference, {}).mismatches, Contains(HasSubstr("roughness")));
  EXPECT_THAT(comparePacks(coded, reference, {}).mismatches, Contains(HasSubstr("matrices, precision")));
  EXPECT_THAT(comparePacks(colored, reference, {}).mismatches, Contains(HasSubstr("colors")));
  EXPECT_EQ(failingDifferences(comparePacks(turned, reference, {})),
            "transfer glossy.tangents, relative norm;transfer glossy.tangents, maximum;");
  EXPECT_EQ(failingDifferences(comparePacks(darker, reference, {})),
            "transfer glossy.matrices, relative norm;transfer glossy.matrices, maximum;");
}

TEST(CompareFiles, ACompressedPackIsNotItsPlainCounterpart) {
  const auto folder = std::filesystem::temp_directory_path();
  const auto plain = folder / "bakelight_compare_plain.glb", small = folder / "bakelight_compare_small.glb";
  writePack(plain, packOf(stages::twoSpheres(0)), {});
  writePack(small, packOf(stages::twoSpheres(0)), {.draco = true});
  EXPECT_TRUE(compareFiles("pack", plain, plain, {}).passes());
  EXPECT_THAT(compareFiles("pack", small, plain, {.distance = 1, .normal = 2}).mismatches,
              Contains(HasSubstr("sections")));
  std::filesystem::remove(plain);
  std::filesystem::remove(small);
}

TEST(CompareFiles, BtfsByDirectionsAndValues) {
  const auto folder = std::filesystem::temp_directory_path();
  const auto write = [&](const char* name, float brighter, double turned) {
    BtfInfo info;
    info.width = 2, info.height = 3;
    info.lights = {{0.2, 0}, {0.9, 1 + turned}};
    info.views = {{0, 0}, {0.5, 2}, {1, 3}};
    std::vector<float> values(std::size_t{3} * 2 * 6 * 3, 0.5F);
    values[40] += brighter;
    const auto path = folder / name;
    writeRawBtf(path, *btfOf(info, values));
    return path;
  };
  const auto reference = write("bakelight_compare_reference.btf", 0, 0),
             brighter = write("bakelight_compare_brighter.btf", 0.25F, 0),
             turned = write("bakelight_compare_turned.btf", 0, 0.1);
  const Comparison same = compareFiles("btf", reference, reference, {});
  EXPECT_TRUE(same.passes());
  EXPECT_EQ(same.compared_values, std::uint64_t{108});
  EXPECT_NEAR(differenceCalled(compareFiles("btf", brighter, reference, {}), "values, maximum").measured,
              0.25, 1e-3);
  EXPECT_TRUE(compareFiles("btf", brighter, reference, {.maximum = 0.3, .relative = 0.1}).passes());
  EXPECT_FALSE(compareFiles("btf", brighter, reference, {.maximum = 0.2, .relative = 0.1}).passes());
  EXPECT_THAT(compareFiles("btf", turned, reference, {.maximum = 9, .relative = 9}).mismatches,
              testing::Not(IsEmpty()));
  for (const auto& path : {reference, brighter, turned}) std::filesystem::remove(path);
}

TEST(CompareFiles, AMissingFileIsAnError) {
  const auto there = std::filesystem::temp_directory_path() / "bakelight_compare_there.ply";
  writePly(there, stages::sphere(0));
  EXPECT_TRUE(compareFiles("mesh", there, there, {}).passes());
  EXPECT_THROW(compareFiles("mesh", there, "missing.ply", {}), Error);
  EXPECT_THROW(compareFiles("mesh", "missing.ply", there, {}), Error);
  EXPECT_THROW(compareFiles("sound", there, there, {}), std::invalid_argument);
  std::filesystem::remove(there);
}

}  // namespace
}  // namespace bakelight::formats
