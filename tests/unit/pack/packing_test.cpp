#include "tools/pack/packing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numeric>

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "tools/pack/report.h"

namespace bakelight::packing {
namespace {

using formats::ElementType;
using formats::Float3;
using formats::LobeModel;
using formats::MatrixStorage;
using formats::Pack;
using formats::Precision;
using formats::Tensor;
using formats::TensorFile;
using formats::TriangleMesh;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint64_t kVertices = 3, kCoefficients = 4, kRows = 9;  // order 2, rows of order 3
const SourceNames kNames = {"m.ply", "t.safetensors", "b.safetensors"};

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

PackingOptions withLobe(const std::string& lobe, Precision precision = Precision::kFloat32) {
  PackingOptions options;
  options.lobe = lobe;
  options.precision = precision;
  return options;
}

Pack assemble(const TensorFile& transfer, const PackingOptions& options = {},
              const TensorFile* brdf = nullptr) {
  Pack pack = assemblePack(triangle(), transfer, brdf, options, kNames);
  // What the stage makes, the format takes.
  formats::decodePack(formats::encodePack(pack, {}, "a.glb"), "a.glb");
  return pack;
}

std::string errorOf(const TensorFile& transfer, const PackingOptions& options = {},
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
  PackingOptions options;
  options.name = "name";
  options.albedo = {0.1F, 0.2F, 0.3F};
  options.precision = Precision::kUint8;  // not for diffuse vectors
  for (const std::uint64_t channels : {1, 3}) {
    const TensorFile transfer = diffuseTransfer(channels);
    const Pack pack = assemble(transfer, options);
    EXPECT_EQ(pack.name, "name");
    EXPECT_EQ(pack.base_color, (Float3{0.1F, 0.2F, 0.3F}));
    EXPECT_TRUE(pack.colors.empty());
    EXPECT_EQ(pack.mesh.positions, triangle().positions);
    EXPECT_EQ(pack.transfer.order, 2);
    EXPECT_EQ(pack.transfer.transport, "shadowed");
    EXPECT_EQ(pack.transfer.channels, static_cast<int>(channels));
    EXPECT_EQ(pack.transfer.vectors.precision, Precision::kFloat32);
    EXPECT_EQ(pack.transfer.vectors.decode(), valuesOf(transfer, "transfer"));
    EXPECT_EQ(pack.transfer.storage, MatrixStorage::kNone);
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
  EXPECT_EQ(pack.transfer.near_vectors.decode(), valuesOf(transfer, "near_transfer"));
  EXPECT_EQ(pack.transfer.sphere_center, (Float3{1, 2, 3}));
  EXPECT_EQ(pack.transfer.sphere_radius, 4);
}

TEST(Packing, TheTransfersAlbedoWins) {
  TensorFile transfer = diffuseTransfer();
  transfer.tensors["albedo"] =
      Tensor::from<float>(ElementType::kFloat32, {1, 3}, std::vector<float>{0.5F, 0.25F, 0.125F});
  EXPECT_EQ(assemble(transfer).base_color, (Float3{0.5F, 0.25F, 0.125F}));
  transfer.tensors["albedo"] =
      Tensor::from<float>(ElementType::kFloat32, {3, 3},
                          std::vector<float>{0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F, 0.7F, 0.8F, 0.9F});
  const Pack pack = assemble(transfer);
  EXPECT_EQ(pack.base_color, (Float3{1, 1, 1}));
  ASSERT_EQ(pack.colors.size(), 3U);
  EXPECT_EQ(pack.colors[1], (Float3{0.4F, 0.5F, 0.6F}));
  transfer.tensors["albedo"] = ramp({2, 3});
  EXPECT_THAT(errorOf(transfer), AllOf(HasSubstr("tensor albedo"), HasSubstr("2 × 3")));
}

TEST(Packing, TheMeshsColoursWinOverTheParameter) {
  TriangleMesh mesh = triangle();
  mesh.colors = {{0.1F, 0.2F, 0.3F}, {0.4F, 0.5F, 0.6F}, {0.7F, 0.8F, 0.9F}};
  TensorFile transfer = diffuseTransfer();
  const Pack pack = assemblePack(mesh, transfer, nullptr, {}, kNames);
  EXPECT_EQ(pack.base_color, (Float3{1, 1, 1}));
  EXPECT_EQ(pack.colors, mesh.colors);
  EXPECT_TRUE(pack.mesh.colors.empty());
  transfer.tensors["albedo"] =
      Tensor::from<float>(ElementType::kFloat32, {1, 3}, std::vector<float>{0.5F, 0.25F, 0.125F});
  const Pack baked = assemblePack(mesh, transfer, nullptr, {}, kNames);
  EXPECT_EQ(baked.base_color, (Float3{0.5F, 0.25F, 0.125F}))
      << "what was baked with one albedo is shown with it";
  EXPECT_TRUE(baked.colors.empty());
}

TEST(Packing, EachStorageKeepsItsTables) {
  for (const std::uint64_t channels : {1, 3}) {
    const TensorFile transfer = glossyTransfer("matrix", channels);
    const Pack pack = assemble(transfer, withLobe("phong"));
    EXPECT_EQ(pack.transfer.storage, MatrixStorage::kMatrix);
    EXPECT_EQ(pack.transfer.row_order, 3);
    EXPECT_EQ(pack.transfer.tangents[1], (formats::Float4{0, 1, 0, -1}));
    EXPECT_EQ(pack.transfer.matrices.columns, channels * kRows * kCoefficients);
    EXPECT_EQ(pack.transfer.matrices.decode(), valuesOf(transfer, "matrix"));
  }
  const TensorFile visibility = glossyTransfer("visibility");
  const Pack seen = assemble(visibility, withLobe("ggx"));
  EXPECT_EQ(seen.transfer.storage, MatrixStorage::kVisibility);
  EXPECT_EQ(seen.transfer.matrices.decode(), valuesOf(visibility, "visibility"));

  const TensorFile clusters = glossyTransfer("cpca", 3);
  const Pack clustered = assemble(clusters, withLobe("ggx"));
  EXPECT_EQ(clustered.transfer.storage, MatrixStorage::kCpca);
  EXPECT_EQ(clustered.transfer.matrices.decode(), valuesOf(clusters, "weights"));
  EXPECT_THAT(clustered.transfer.clusters, ElementsAre(1, 0, 1));
  EXPECT_EQ(clustered.transfer.basis.rows, 6U);
  EXPECT_EQ(clustered.transfer.basis.decode(), valuesOf(clusters, "basis"));
}

TEST(Packing, LobesCarryTheirOwnParametersOnly) {
  PackingOptions options = withLobe("phong");
  options.exponent = 20;
  options.roughness = 0.5;
  options.specular_color = {0.25F, 0.5F, 0.75F};
  const auto phong = assemble(glossyTransfer("matrix"), options).transfer.material;
  EXPECT_EQ(phong.model, LobeModel::kPhong);
  EXPECT_EQ(phong.exponent, 20);
  EXPECT_EQ(phong.roughness, 0);
  EXPECT_EQ(phong.specular_color, (Float3{0.25F, 0.5F, 0.75F}));
  options.lobe = "ggx";
  const auto ggx = assemble(glossyTransfer("matrix"), options).transfer.material;
  EXPECT_EQ(ggx.model, LobeModel::kGgx);
  EXPECT_EQ(ggx.roughness, 0.5F);
  const TensorFile brdf = brdfOfOrder(4);
  const auto table = assemble(glossyTransfer("matrix"), withLobe("table"), &brdf).transfer.material;
  EXPECT_EQ(table.model, LobeModel::kTable);
  EXPECT_EQ(table.table.angles, 5);
  EXPECT_EQ(table.table.order, 4);
  EXPECT_EQ(table.table.values, valuesOf(brdf, "brdf"));
}

TEST(Packing, PrecisionIsOfTheMatricesAndTheBasisGetsHalvesAtLeast) {
  using enum Precision;
  for (const auto& [precision, basis] :
       {std::pair{kFloat32, kFloat32}, {kFloat16, kFloat16}, {kUint8, kFloat16}}) {
    const Pack pack = assemble(glossyTransfer("cpca"), withLobe("ggx", precision));
    EXPECT_EQ(pack.transfer.matrices.precision, precision);
    EXPECT_EQ(pack.transfer.basis.precision, basis);
    EXPECT_EQ(pack.transfer.vectors.precision, kFloat32);
    EXPECT_EQ(assemble(glossyTransfer("matrix"), withLobe("ggx", precision)).transfer.matrices.precision,
              precision);
    EXPECT_EQ(assemble(glossyTransfer("visibility"), withLobe("ggx", precision)).transfer.matrices.precision,
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
  EXPECT_THAT(errorOf(diffuseTransfer(), withLobe("ggx")),
              AllOf(HasSubstr("/lobe"), HasSubstr("technique glossy")));
  EXPECT_THAT(errorOf(glossyTransfer("matrix")), AllOf(HasSubstr("/lobe"), HasSubstr("phong, ggx or table")));
  EXPECT_THAT(errorOf(glossyTransfer("matrix"), withLobe("table")),
              AllOf(HasSubstr("/brdf"), HasSubstr("input brdf")));
  EXPECT_THAT(errorOf(glossyTransfer("matrix"), withLobe("ggx"), &brdf),
              AllOf(HasSubstr("b.safetensors"), HasSubstr("/brdf")));
  EXPECT_THAT(errorOf(diffuseTransfer(), {}, &brdf), HasSubstr("/brdf"));
  EXPECT_THAT(errorOf(glossyTransfer("visibility", 3), withLobe("ggx")),
              AllOf(HasSubstr("no colour"), HasSubstr("cpca")));
  EXPECT_EQ(errorOf(glossyTransfer("matrix"), withLobe("table"), &brdf), "no error");
  const TensorFile coarse = brdfOfOrder(2);
  EXPECT_THAT(errorOf(glossyTransfer("matrix"), withLobe("table"), &coarse),
              AllOf(HasSubstr("b.safetensors"), HasSubstr("fewer bands")));
}

TEST(Packing, RefusesATransferOfAnotherMesh) {
  TriangleMesh other = triangle();
  other.positions[1][0] = 1.0000001F;
  EXPECT_THAT(errorOf(diffuseTransfer(), {}, nullptr, other),
              AllOf(HasSubstr("t.safetensors"), HasSubstr("another mesh than m.ply")));
  other.positions.push_back({1, 1, 1});
  EXPECT_THAT(errorOf(diffuseTransfer(), {}, nullptr, other),
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
  EXPECT_EQ(run.stats()["albedo_source"], "parameter");
  EXPECT_GT(run.stats()["precision_error"]["matrices"], 0.0);
  EXPECT_TRUE(run.warnings().empty()) << "0.8 + 0.2 is 1";
  options.specular_color = {0.1F, 0.1F, 0.3F};
  const Pack bright = assemble(transfer, options);
  report(bright, transfer, formats::encodePack(bright, {}, "a.glb"), "a.glb", run);
  ASSERT_EQ(run.warnings().size(), 1U);
}

}  // namespace
}  // namespace bakelight::packing
