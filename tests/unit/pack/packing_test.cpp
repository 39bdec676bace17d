#include "tools/pack/packing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numeric>

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "tests/support/pack_parts.h"
#include "tools/pack/report.h"

namespace bakelight::packing {
namespace {

using formats::ElementType;
using formats::Float3;
using formats::Pack;
using formats::Precision;
using formats::Storage, formats::storageOf, formats::clustersOf, formats::Transport;
using formats::Tensor;
using formats::TensorFile;
using formats::TriangleMesh;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint64_t kVertices = 3, kCoefficients = 4, kRows = 9;  // order 2, rows of order 3
const SourceNames kNames = {"m.ply", "t.safetensors", "b.safetensors", "material.json"};

TriangleMesh triangle() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

// Values first, first + 0.5, …
Tensor ramp(std::vector<std::uint64_t> shape, float first = 0) {
  const auto count = std::accumulate(shape.begin(), shape.end(), std::uint64_t{1}, std::multiplies<>());
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = first + 0.5F * static_cast<float>(i);
  return Tensor::from<float>(ElementType::kFloat32, std::move(shape), values);
}

TensorFile diffuseTransfer(std::uint64_t channels = 1) {
  TensorFile file;
  file.tensors["transfer"] = ramp({kVertices, channels, kCoefficients});
  file.metadata = {{"technique", "diffuse"},
                   {"order", "2"},
                   {"transport", "shadowed"},
                   {"basis", "real_sh_cartesian"},
                   {"albedo", "outside"},
                   {"inverse_pi", "inside"},
                   {"mesh_hash", formats::geometryHash(triangle())}};
  return file;
}

TensorFile glossyTransfer(const std::string& storage, std::uint64_t channels = 1) {
  TensorFile file = diffuseTransfer(channels);
  file.metadata["technique"] = "glossy";
  file.metadata["row_order"] = "3";
  file.metadata["storage"] = storage;
  file.tensors["tangent"] = Tensor::from<float>(ElementType::kFloat32, {kVertices, 4},
                                                std::vector<float>{1, 0, 0, 1, 0, 1, 0, -1, 1, 0, 0, 1});
  if (storage == "matrix") file.tensors["matrix"] = ramp({kVertices, channels, kRows, kCoefficients}, -7.3F);
  if (storage == "visibility") file.tensors["visibility"] = ramp({kVertices, 16}, -7.3F);
  if (storage == "cpca") {
    file.tensors["weights"] = ramp({kVertices, 2}, 0.1F);
    file.tensors["cluster"] =
        Tensor::from<std::uint32_t>(ElementType::kUint32, {kVertices}, std::vector<std::uint32_t>{1, 0, 1});
    file.tensors["basis"] = ramp({2, 3, channels, kRows, kCoefficients}, -3.3F);
  }
  return file;
}

TensorFile brdfOfOrder(int order) {
  TensorFile file;
  const auto bands = static_cast<std::uint64_t>(order);
  file.tensors["brdf"] = ramp({5, 3, bands * bands});
  file.metadata = {{"order", std::to_string(order)},
                   {"basis", "real_sh_cartesian"},
                   {"frame", "local"},
                   {"cosine", "inside"}};
  return file;
}

PackingOptions packed(Precision precision = Precision::kFloat32) {
  PackingOptions options;
  options.precision = precision;
  options.material.reflections = {formats::Lambert()};
  return options;
}

const formats::PackPart& reflectionOf(const Pack& pack) {
  return pack.appearances.front().reflection;
}

PackingOptions withReflection(const formats::Reflection& reflection,
                              Precision precision = Precision::kFloat32) {
  PackingOptions options = packed(precision);
  options.material.reflections = {reflection};
  return options;
}

PackingOptions withLobe(const std::string& model, Precision precision = Precision::kFloat32) {
  if (model == "phong") return withReflection(formats::PhongReflection(), precision);
  PackingOptions options = withReflection(formats::GgxReflection(), precision);
  if (model == "table") options.reflection = ShownReflection::kTable;
  return options;
}

Pack assemble(const TensorFile& transfer, const PackingOptions& options = packed(),
              const TensorFile* brdf = nullptr) {
  Pack pack = assemblePack(triangle(), transfer, brdf, options, kNames);
  // What the stage makes, the format takes.
  formats::decodePack(formats::encodePack(pack, {}, "a.glb"), "a.glb");
  return pack;
}

std::string errorOf(const TensorFile& transfer, const PackingOptions& options = packed(),
                    const TensorFile* brdf = nullptr, const TriangleMesh& mesh = triangle()) {
  try {
    assemblePack(mesh, transfer, brdf, options, kNames);
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "no error";
}

std::vector<float> valuesOf(const TensorFile& file, const char* name) {
  const auto values = file.tensors.at(name).as<float>();
  return {values.begin(), values.end()};
}

TEST(Packing, DiffuseTransferGoesInAsItIs) {
  PackingOptions options = packed();
  options.name = "name";
  options.material.albedo = {0.1F, 0.2F, 0.3F};
  options.precision = Precision::kUint8;  // not for diffuse vectors
  for (const std::uint64_t channels : {1, 3}) {
    const TensorFile transfer = diffuseTransfer(channels);
    const Pack pack = assemble(transfer, options);
    EXPECT_EQ(pack.name, "name");
    EXPECT_EQ(pack.appearances[0].base_color, (Float3{0.1F, 0.2F, 0.3F}));
    EXPECT_TRUE(pack.colors.empty());
    EXPECT_EQ(pack.mesh.positions, triangle().positions);
    EXPECT_EQ(pack.sh().order, 2);
    EXPECT_EQ(pack.sh().transport, Transport::kShadowed);
    EXPECT_EQ(pack.sh().channels, static_cast<int>(channels));
    EXPECT_EQ(pack.sh().vectors.precision, Precision::kFloat32);
    EXPECT_EQ(pack.sh().vectors.decode(), valuesOf(transfer, "transfer"));
    EXPECT_EQ(storageOf(pack.sh()), Storage::kNone);
    EXPECT_TRUE(precisionErrors(pack, transfer).empty());
  }
}

TEST(Packing, NearFieldComesWithItsSphere) {
  TensorFile transfer = diffuseTransfer();
  transfer.tensors["near_transfer"] = ramp({kVertices, 1, kCoefficients}, 9);
  EXPECT_THAT(errorOf(transfer), HasSubstr("sphere"));
  transfer.tensors["sphere"] =
      Tensor::from<float>(ElementType::kFloat32, {4}, std::vector<float>{1, 2, 3, 4});
  const Pack pack = assemble(transfer);
  EXPECT_EQ(pack.sh().near_field->vectors.decode(), valuesOf(transfer, "near_transfer"));
  EXPECT_EQ(pack.sh().near_field->center, (Float3{1, 2, 3}));
  EXPECT_EQ(pack.sh().near_field->radius, 4);
}

TEST(Packing, LightHasBouncedOffTheAlbedoThatIsShown) {
  PackingOptions options = packed();
  options.material.albedo = {0.5F, 0.25F, 0.125F};
  TensorFile transfer = diffuseTransfer();
  const auto baked = [&](std::vector<std::uint64_t> shape, const std::vector<float>& values) {
    transfer.tensors["albedo"] = Tensor::from<float>(ElementType::kFloat32, std::move(shape), values);
  };
  baked({1, 3}, {0.5F, 0.25F, 0.125F});
  EXPECT_EQ(assemble(transfer, options).appearances[0].base_color, (Float3{0.5F, 0.25F, 0.125F}));
  baked({1, 3}, {0.5F, 0.25F, 0.25F});
  EXPECT_THAT(errorOf(transfer, options), AllOf(HasSubstr("tensor albedo"), HasSubstr("another albedo")));

  options.material.vertex_albedo = {{0.1F, 0.2F, 0.3F}, {0.4F, 0.5F, 0.6F}, {0.7F, 0.8F, 0.9F}};
  baked({3, 3}, {0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F, 0.7F, 0.8F, 0.9F});
  const Pack pack = assemble(transfer, options);
  EXPECT_EQ(pack.appearances[0].base_color, (Float3{1, 1, 1}));
  EXPECT_EQ(pack.colors, options.material.vertex_albedo);
  baked({3, 3}, {0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F, 0.7F, 0.8F, 0.8F});
  EXPECT_THAT(errorOf(transfer, options), HasSubstr("another albedo"));
  transfer.tensors["albedo"] = ramp({2, 3});
  EXPECT_THAT(errorOf(transfer, options), AllOf(HasSubstr("tensor albedo"), HasSubstr("2 × 3")));
}

TEST(Packing, ColorsAreTheMaterialsNotTheMeshs) {
  TriangleMesh mesh = triangle();
  mesh.colors = {{0.1F, 0.2F, 0.3F}, {0.4F, 0.5F, 0.6F}, {0.7F, 0.8F, 0.9F}};
  const Pack pack = assemblePack(mesh, diffuseTransfer(), nullptr, packed(), kNames);
  EXPECT_EQ(pack.appearances[0].base_color, formats::kDefaultAlbedo);
  EXPECT_TRUE(pack.colors.empty());
  EXPECT_TRUE(pack.mesh.colors.empty());
}

TEST(Packing, EachStorageKeepsItsTables) {
  for (const std::uint64_t channels : {1, 3}) {
    const TensorFile transfer = glossyTransfer("matrix", channels);
    const Pack pack = assemble(transfer, withLobe("phong"));
    EXPECT_EQ(storageOf(pack.sh()), Storage::kMatrix);
    EXPECT_EQ(pack.sh().glossy->output_order, 3);
    EXPECT_EQ(pack.sh().glossy->tangents[1], (formats::Float4{0, 1, 0, -1}));
    EXPECT_EQ(pack.sh().glossy->vertexTable().columns, channels * kRows * kCoefficients);
    EXPECT_EQ(pack.sh().glossy->vertexTable().decode(), valuesOf(transfer, "matrix"));
  }
  const TensorFile visibility = glossyTransfer("visibility");
  const Pack seen = assemble(visibility, withLobe("ggx"));
  EXPECT_EQ(storageOf(seen.sh()), Storage::kVisibility);
  EXPECT_EQ(seen.sh().glossy->vertexTable().decode(), valuesOf(visibility, "visibility"));

  const TensorFile clusters = glossyTransfer("cpca", 3);
  const Pack clustered = assemble(clusters, withLobe("ggx"));
  EXPECT_EQ(storageOf(clustered.sh()), Storage::kCpca);
  EXPECT_EQ(clustered.sh().glossy->vertexTable().decode(), valuesOf(clusters, "weights"));
  EXPECT_THAT(clustersOf(clustered).clusters, ElementsAre(1, 0, 1));
  EXPECT_EQ(clustersOf(clustered).basis.rows, 6U);
  EXPECT_EQ(clustersOf(clustered).basis.decode(), valuesOf(clusters, "basis"));
}

TEST(Packing, LobesCarryTheirOwnParameters) {
  const Float3 color = {0.25F, 0.5F, 0.75F};
  const Pack phong = assemble(glossyTransfer("matrix"), withReflection(formats::PhongReflection{color, 20}));
  ASSERT_NE(reflectionOf(phong).as<formats::PhongLobe>(), nullptr);
  EXPECT_EQ(reflectionOf(phong).as<formats::PhongLobe>()->exponent, 20);
  EXPECT_EQ(reflectionOf(phong).as<formats::PhongLobe>()->specular_color, color);
  const Pack ggx = assemble(glossyTransfer("matrix"), withReflection(formats::GgxReflection{color, 0.5}));
  ASSERT_NE(reflectionOf(ggx).as<formats::GgxLobe>(), nullptr);
  EXPECT_EQ(reflectionOf(ggx).as<formats::GgxLobe>()->roughness, 0.5F);
  const TensorFile brdf = brdfOfOrder(4);
  const Pack pack = assemble(glossyTransfer("matrix"), withLobe("table"), &brdf);
  const auto* table = reflectionOf(pack).as<formats::BrdfTable>();
  ASSERT_NE(table, nullptr);
  EXPECT_EQ(table->angles, 5);
  EXPECT_EQ(table->order, 4);
  EXPECT_EQ(table->values, valuesOf(brdf, "brdf"));
}

// A square of two triangles, in two materials that share a side, and a material that nothing has.
TEST(Packing, EachMaterialThatATriangleHasBecomesAnAppearance) {
  TriangleMesh square;
  square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {9, 9, 9}};  // the last in no triangle
  square.normals.assign(5, {0, 0, 1});
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  square.material_names = {"top", "unused", "bottom"};
  square.triangle_materials = {2, 0};
  TensorFile transfer;
  transfer.tensors["transfer"] = ramp({5, 1, kCoefficients});
  transfer.metadata = diffuseTransfer().metadata;
  transfer.metadata["mesh_hash"] = formats::geometryHash(square);
  Pack pack = assemblePack(square, transfer, nullptr, packed(), kNames);
  ASSERT_EQ(pack.appearances.size(), 2U);
  EXPECT_EQ(pack.appearances[0].material, "top");
  EXPECT_EQ(pack.appearances[1].material, "bottom");
  EXPECT_EQ(orderByMaterial(pack), 1U) << "a vertex was left out";
  const Pack read = formats::decodePack(formats::encodePack(pack, {}, "a.glb"), "a.glb");
  EXPECT_EQ(read.mesh.triangle_materials, (std::vector<std::uint32_t>{0, 1}));
  ASSERT_EQ(read.mesh.vertexCount(), 6U) << "two vertices become four";
  const std::vector<float> rows = read.sh().vectors.decode(), source = valuesOf(transfer, "transfer");
  const std::array<std::uint32_t, 6> source_of = {0, 2, 3, 0, 1, 2};
  for (std::size_t v = 0; v < 6; ++v) {
    EXPECT_EQ(read.mesh.positions[v], square.positions[source_of[v]]) << v;
    for (std::size_t i = 0; i < kCoefficients; ++i)
      EXPECT_EQ(rows[v * kCoefficients + i], source[source_of[v] * kCoefficients + i]) << v;
  }
}

TEST(Packing, PrecisionIsOfTheMatricesAndTheBasisGetsHalvesAtLeast) {
  using enum Precision;
  for (const auto& [precision, basis] :
       {std::pair{kFloat32, kFloat32}, {kFloat16, kFloat16}, {kUint8, kFloat16}}) {
    const Pack pack = assemble(glossyTransfer("cpca"), withLobe("ggx", precision));
    EXPECT_EQ(pack.sh().glossy->vertexTable().precision, precision);
    EXPECT_EQ(clustersOf(pack).basis.precision, basis);
    EXPECT_EQ(pack.sh().vectors.precision, kFloat32);
    EXPECT_EQ(
        assemble(glossyTransfer("matrix"), withLobe("ggx", precision)).sh().glossy->vertexTable().precision,
        precision);
    EXPECT_EQ(assemble(glossyTransfer("visibility"), withLobe("ggx", precision))
                  .sh()
                  .glossy->vertexTable()
                  .precision,
              precision);
  }
}

TEST(Packing, PrecisionErrorIsTheRelativeNormOfWhatWasLost) {
  const auto errorAt = [](const TensorFile& transfer, Precision precision, const char* section) {
    return precisionErrors(assemble(transfer, withLobe("ggx", precision)), transfer).at(section);
  };
  EXPECT_EQ(errorAt(glossyTransfer("matrix"), Precision::kFloat32, "matrices"), 0);
  // By hand: columns of three values v, v + 8, v + 16 at steps of 16 / 255; the middle one falls between
  // codes 127 and 128, half a step off.
  const TensorFile visibility = glossyTransfer("visibility");
  double sum = 0;
  for (const float value : valuesOf(visibility, "visibility")) sum += static_cast<double>(value) * value;
  const double expected = std::sqrt(16 * std::pow(8.0 / 255, 2) / sum);
  EXPECT_NEAR(errorAt(visibility, Precision::kUint8, "visibility"), expected, 1e-4 * expected);
  const double half = errorAt(glossyTransfer("matrix"), Precision::kFloat16, "matrices");
  EXPECT_GT(half, 0);
  EXPECT_LT(half, std::exp2(-11));  // half an ulp of each value
  const TensorFile clusters = glossyTransfer("cpca");
  EXPECT_GT(errorAt(clusters, Precision::kUint8, "weights"), 0);
  EXPECT_LT(errorAt(clusters, Precision::kUint8, "basis"), std::exp2(-11));
}

TEST(Packing, CombinationsThatMakeNoSenseAreErrors) {
  const TensorFile brdf = brdfOfOrder(3);
  PackingOptions without = withLobe("ggx");
  without.reflection = ShownReflection::kNone;
  EXPECT_THAT(errorOf(diffuseTransfer(), withLobe("ggx")),
              AllOf(HasSubstr("/reflection"), HasSubstr("technique glossy")));
  EXPECT_EQ(errorOf(diffuseTransfer(), without), "no error");
  for (const PackingOptions& options : {packed(), without})
    EXPECT_THAT(errorOf(glossyTransfer("matrix"), options),
                AllOf(HasSubstr("/reflection"), HasSubstr("technique diffuse")));
  EXPECT_THAT(errorOf(glossyTransfer("matrix"), withLobe("table")),
              AllOf(HasSubstr("/brdf"), HasSubstr("input brdf")));
  EXPECT_THAT(errorOf(glossyTransfer("visibility", 3), withLobe("ggx")),
              AllOf(HasSubstr("no colour"), HasSubstr("cpca")));
  EXPECT_EQ(errorOf(glossyTransfer("matrix"), withLobe("table"), &brdf), "no error");
  const TensorFile coarse = brdfOfOrder(2);
  EXPECT_THAT(errorOf(glossyTransfer("matrix"), withLobe("table"), &coarse),
              AllOf(HasSubstr("b.safetensors"), HasSubstr("fewer bands")));
}

TEST(Packing, AMaterialThatIsATableNeedsNoOther) {
  const formats::BrdfTable table = formats::brdfTableFrom(brdfOfOrder(3), "own.safetensors");
  const auto reflection = withReflection(formats::TableReflection{"own.safetensors", table});
  const Pack pack = assemble(glossyTransfer("matrix"), reflection);
  ASSERT_NE(reflectionOf(pack).as<formats::BrdfTable>(), nullptr);
  EXPECT_EQ(reflectionOf(pack).as<formats::BrdfTable>()->values, table.values);
}

TEST(Packing, MaterialsReflectEachInItsOwnWay) {
  PackingOptions options = packed();
  options.material.reflections = {formats::GgxReflection(), formats::PhongReflection(), formats::Lambert()};
  options.material.names = {"metal", "paint", "chalk"};
  options.material.of_triangle = {1};
  EXPECT_STREQ(reflectionOf(assemble(glossyTransfer("matrix"), options)).kind(), "phong")
      << "which is the only one in use";
  TriangleMesh mesh = triangle();
  mesh.triangles.push_back({0, 2, 1});
  mesh.triangles.push_back({1, 0, 2});
  mesh.material_names = {"paint", "chalk", "metal"};
  mesh.triangle_materials = {0, 1, 2};
  options.material.of_triangle = {1, 2, 0};
  TensorFile transfer = glossyTransfer("matrix");
  transfer.metadata["mesh_hash"] = formats::geometryHash(mesh);
  Pack pack = assemblePack(mesh, transfer, nullptr, options, kNames);
  ASSERT_EQ(pack.appearances.size(), 3U);
  EXPECT_STREQ(pack.appearances[0].reflection.kind(), "phong");
  EXPECT_STREQ(pack.appearances[1].reflection.kind(), "lambert");
  EXPECT_STREQ(pack.appearances[2].reflection.kind(), "ggx");
  // Each has its own table, or the one for all others.
  options.reflection = ShownReflection::kTable;
  TensorFile brdf = brdfOfOrder(4);
  brdf.tensors["brdf/metal"] = ramp({5, 3, 16}, 40);
  pack = assemblePack(mesh, transfer, &brdf, options, kNames);
  EXPECT_EQ(pack.appearances[0].reflection.as<formats::BrdfTable>()->values, valuesOf(brdf, "brdf"));
  EXPECT_STREQ(pack.appearances[1].reflection.kind(), "lambert");
  EXPECT_EQ(pack.appearances[2].reflection.as<formats::BrdfTable>()->values, valuesOf(brdf, "brdf/metal"));
}

TEST(Packing, RefusesATransferOfAnotherMesh) {
  TriangleMesh other = triangle();
  other.positions[1][0] = 1.0000001F;
  EXPECT_THAT(errorOf(diffuseTransfer(), packed(), nullptr, other),
              AllOf(HasSubstr("t.safetensors"), HasSubstr("another mesh than m.ply")));
  other.positions.push_back({1, 1, 1});
  EXPECT_THAT(errorOf(diffuseTransfer(), packed(), nullptr, other),
              AllOf(HasSubstr("3 × 1 × 4"), HasSubstr("4 × 1 × 4")));
}

TEST(Packing, RefusesWhatAPackCannotHold) {
  for (const char* key : {"technique", "basis", "albedo", "inverse_pi", "order", "storage", "row_order"}) {
    TensorFile transfer = glossyTransfer("matrix");
    transfer.metadata[key] = "other";
    EXPECT_THAT(errorOf(transfer, withLobe("ggx")), AllOf(HasSubstr(key), HasSubstr("'other'"))) << key;
    transfer.metadata.erase(key);
    EXPECT_THAT(errorOf(transfer, withLobe("ggx")), HasSubstr(key)) << key;
  }
  TensorFile brdf = brdfOfOrder(3);
  for (const char* key : {"order", "basis", "frame", "cosine"}) {
    TensorFile spoiled = brdf;
    spoiled.metadata[key] = "other";
    EXPECT_THAT(errorOf(glossyTransfer("matrix"), withLobe("table"), &spoiled),
                AllOf(HasSubstr("b.safetensors"), HasSubstr(key)))
        << key;
  }
}

TEST(Packing, ShapesThatDoNotFitAreNamed) {
  for (const auto& [storage, tensor] : {std::pair{"matrix", "matrix"},
                                        {"matrix", "tangent"},
                                        {"visibility", "visibility"},
                                        {"cpca", "weights"},
                                        {"cpca", "basis"},
                                        {"cpca", "cluster"}}) {
    TensorFile transfer = glossyTransfer(storage);
    Tensor& spoiled = transfer.tensors[tensor];
    // One weight less would be the basis's trouble.
    (std::string(tensor) == "weights" ? spoiled.shape.front() : spoiled.shape.back()) -= 1;
    spoiled.data = formats::Bytes(spoiled.elementCount() * 4);
    EXPECT_THAT(errorOf(transfer, withLobe("ggx")), HasSubstr(std::string("tensor ") + tensor)) << storage;
    transfer.tensors.erase(tensor);
    EXPECT_THAT(errorOf(transfer, withLobe("ggx")), HasSubstr(tensor)) << storage;
  }
  TensorFile transfer = diffuseTransfer(2);
  EXPECT_THAT(errorOf(transfer), HasSubstr("2 channels"));
}

TEST(Packing, ValuesThatDoNotFitThePrecisionAreNamed) {
  TensorFile transfer = glossyTransfer("matrix");
  transfer.tensors["matrix"] = ramp({kVertices, 1, kRows, kCoefficients}, 65500);
  EXPECT_EQ(errorOf(transfer, withLobe("ggx")), "no error");
  EXPECT_THAT(errorOf(transfer, withLobe("ggx", Precision::kFloat16)),
              AllOf(HasSubstr("t.safetensors"), HasSubstr("tensor matrix, row 0, column 9")));
}

TEST(Packing, BitsAreZeroOrInRange) {
  EXPECT_NO_THROW(checkOptions({.draco = true, .position_bits = 0, .normal_bits = 0}));
  EXPECT_NO_THROW(checkOptions({.draco = true, .position_bits = 8, .normal_bits = 30}));
  EXPECT_THROW(checkOptions({.draco = true, .position_bits = 7}), Error);
  EXPECT_THROW(checkOptions({.draco = true, .normal_bits = 5}), Error);
}

TEST(Report, SaysWhatEachSectionCostsAndWarnsOfTooMuchLight) {
  const TensorFile transfer = glossyTransfer("matrix");
  PackingOptions options = withLobe("ggx", Precision::kFloat16);
  stage::Run run(1, stage::ProgressStyle::kNone);
  const Pack pack = assemble(transfer, options);
  report(pack, transfer, formats::encodePack(pack, {}, "a.glb"), "a.glb", run);
  EXPECT_EQ(run.stats()["bytes_per_vertex"]["matrices"], 2.0 * kRows * kCoefficients);
  EXPECT_EQ(run.stats()["bytes_per_vertex"]["tangents"], 16.0);
  EXPECT_EQ(run.stats()["albedo_source"], "material");
  EXPECT_GT(run.stats()["precision_error"]["matrices"], 0.0);
  EXPECT_TRUE(run.warnings().empty()) << "0.8 + 0.2 is 1";
  options.material.reflections = {formats::GgxReflection{.specular_color = {0.1F, 0.1F, 0.3F}}};
  const Pack bright = assemble(transfer, options);
  report(bright, transfer, formats::encodePack(bright, {}, "a.glb"), "a.glb", run);
  ASSERT_EQ(run.warnings().size(), 1U);
}

TEST(Report, WarnsOfALobeThatLeavesOutWhatTheMaterialHas) {
  for (const auto& [reflection, warnings] : {std::pair{formats::GgxReflection{.fresnel = true}, 1U},
                                             {formats::GgxReflection{.multiple_scattering = true}, 1U},
                                             {formats::GgxReflection{}, 0U}}) {
    stage::Run run(1, stage::ProgressStyle::kNone);
    const PackingOptions options = withReflection(reflection);
    warnOfLobe(assemble(glossyTransfer("matrix"), options), options.material, run);
    EXPECT_EQ(run.warnings().size(), warnings);
    PackingOptions table = options;
    table.reflection = ShownReflection::kTable;
    const TensorFile brdf = brdfOfOrder(3);
    warnOfLobe(assemble(glossyTransfer("matrix"), table, &brdf), table.material, run);
    EXPECT_EQ(run.warnings().size(), warnings) << "the table has it";
  }
}

}  // namespace
}  // namespace bakelight::packing
