#include "tools/pack/btf_packing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "tests/support/made_pixel_pack.h"
#include "tests/support/shapes.h"
#include "tests/support/temporary_folder.h"
#include "tools/pack/packing.h"
#include "transport/hemisphere_grid.h"

namespace bakelight::packing {
namespace {

using namespace bakelight::tests;
using testing::HasSubstr;

std::vector<formats::BtfDirection> gridDirections(int side) {
  std::vector<formats::BtfDirection> directions;
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      const Vec3 d = transport::hemisphereCell(side, column, row);
      directions.push_back({std::acos(d.z()), std::atan2(d.y(), d.x())});
    }
  return directions;
}

double valueOf(int view, int light, int texel, int color) {
  return 0.3 + 0.1 * std::sin(view + 0.3 * texel) * std::cos(0.7 * light) +
         0.05 * color * std::cos(texel * 1.1 + light);
}

constexpr int kViews = 2, kLights = 4, kWidth = 4, kHeight = 2;

// Lights in another order than the grid's.
std::unique_ptr<formats::Btf> madeBtfFile(bool cosine_inside = true) {
  formats::BtfInfo info;
  info.file = "made.btf";
  info.views = gridDirections(kViews);
  info.lights = gridDirections(kLights);
  std::reverse(info.lights.begin(), info.lights.end());
  info.width = kWidth;
  info.height = kHeight;
  info.cosine_inside = cosine_inside;
  std::vector<float> values;
  for (int view = 0; view < kViews * kViews; ++view)
    for (int light = kLights * kLights - 1; light >= 0; --light)
      for (int texel = 0; texel < kWidth * kHeight; ++texel)
        for (int color = 0; color < 3; ++color)
          values.push_back(static_cast<float>(valueOf(view, light, texel, color)));
  return formats::btfOf(std::move(info), std::move(values));
}

double valueIn(const formats::BtfReflection& btf, const std::vector<float>& factors, std::size_t texel,
               std::size_t view, std::size_t light, std::size_t color) {
  double sum = 0;
  const auto components = static_cast<std::size_t>(btf.components);
  for (std::size_t k = 0; k < components; ++k)
    sum += factors[(texel * kViews * kViews + view) * components + k] *
           btf.basisOf(static_cast<int>(k))[color * btf.cells() + light];
  return sum;
}

TEST(BtfPacking, KeepsValuesWithinTheStatedError) {
  for (const auto& [error, precision] : {std::pair(0.0, formats::Precision::kFloat32),
                                         {0.02, formats::Precision::kFloat16},
                                         {0.0, formats::Precision::kUint8}}) {
    const PackedBtf packed = packBtf(samplesOf(*madeBtfFile()), kLights, {error, precision});
    const formats::BtfReflection& btf = packed.reflection;
    const std::vector<float> factors = btf.factors.decode();
    double squared = 0, difference = 0;
    for (std::size_t view = 0; view < 4; ++view)
      for (std::size_t light = 0; light < 16; ++light)
        for (std::size_t texel = 0; texel < 8; ++texel)
          for (std::size_t color = 0; color < 3; ++color) {
            const double value = valueOf(static_cast<int>(view), static_cast<int>(light),
                                         static_cast<int>(texel), static_cast<int>(color));
            squared += value * value;
            difference += std::pow(valueIn(btf, factors, texel, view, light, color) - value, 2);
          }
    const double relative = std::sqrt(difference / squared);
    EXPECT_NEAR(relative, btf.error, 0.02 * btf.error + 1e-6);
    if (error > 0) {
      EXPECT_LT(btf.error, error * 1.01);
      EXPECT_LT(btf.components, 16);
    }
    EXPECT_GT(packed.stored_bytes, 0U);
    // The last level is the mean over texels.
    const std::size_t last = formats::rttTexelCount(formats::rttLevels(kWidth, kHeight)) - 1;
    double mean = 0;
    for (int texel = 0; texel < 8; ++texel) mean += valueOf(1, 5, texel, 2) / 8;
    EXPECT_NEAR(valueIn(btf, factors, last, 1, 5, 2), mean, 0.02);
  }
}

TEST(BtfPacking, MultipliesCosinesInWhereThereAreNone) {
  const PackedBtf packed =
      packBtf(samplesOf(*madeBtfFile(false)), kLights, {0, formats::Precision::kFloat32});
  EXPECT_NEAR(valueIn(packed.reflection, packed.reflection.factors.decode(), 3, 2, 7, 1),
              valueOf(2, 7, 3, 1) * transport::hemisphereCellCosine(kLights, 3, 1), 1e-5);
}

// [view][texel][color][cell], of a material with a name that a path could not have.
TEST(BtfPacking, TakesTablesAsTheyAreWritten) {
  const BtfSamples samples = samplesOf(*madeBtfFile());
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "btfs.safetensors";
  formats::BtfTableWriter writer(path, {{"", 1, 1, 1, 1}, {"a/b", kViews, kLights, kWidth, kHeight}});
  const std::span<const float> values(samples.values);
  writer.append("a/b", values.first(100));
  writer.append("", std::vector<float>{1, 2, 3});
  writer.append("a/b", values.subspan(100));
  writer.finish();
  const std::vector<formats::BtfTable> tables = formats::readBtfTables(path);
  ASSERT_EQ(tables.size(), 2U);
  EXPECT_EQ(tables[0].valuesOf(0), (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(tables[1].material, "a/b");
  const BtfSamples read = samplesOf(tables[1]);
  EXPECT_EQ(read.views, kViews);
  EXPECT_EQ(read.lights, kLights);
  ASSERT_EQ(read.values.size(), samples.values.size());
  for (std::size_t i = 0; i < read.values.size(); ++i)
    ASSERT_NEAR(read.values[i], samples.values[i], 1e-3) << i;
}

std::string messageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(BtfPacking, RefusesOtherDirections) {
  EXPECT_THAT(messageOf([] { packBtf(samplesOf(*madeBtfFile()), 8, {}); }), HasSubstr("local_side"));
  formats::BtfInfo info = madeBtfFile()->info();
  info.lights[3].polar_rad += 0.05;
  const std::vector<float> values(4 * 16 * 8 * 3, 0.5F);
  EXPECT_THAT(messageOf([&] { packBtf(samplesOf(*formats::btfOf(info, values)), kLights, {}); }),
              HasSubstr("its lights"));
  info = madeBtfFile()->info();
  info.views.pop_back();
  EXPECT_THAT(messageOf([&] {
                packBtf(samplesOf(*formats::btfOf(info, std::vector<float>(3 * 16 * 8 * 3, 0.5F))), kLights,
                        {});
              }),
              HasSubstr("its views"));
}

// ---- whole packs

formats::TensorFile transferFile(const TriangleMesh& mesh) {
  const formats::PixelTransfer transfer = madePixelTransfer(mesh);
  const formats::PixelTransferRows rows(transfer);
  const formats::PixelCodes codes = rows.view();
  const auto entries = static_cast<std::uint64_t>(codes.codes.size());
  std::vector<float> tangents;
  for (const formats::Float4& t : transfer.tangents) tangents.insert(tangents.end(), t.begin(), t.end());
  formats::TensorFile file;
  file.metadata = {{"technique", "pixel"},
                   {"cube_side", "3"},
                   {"local_side", "4"},
                   {"subsamples", "2"},
                   {"mesh_hash", formats::geometryHash(mesh)}};
  file.tensors["codes"] = formats::Tensor::from(formats::ElementType::kUint8, {entries}, codes.codes);
  file.tensors["columns"] = formats::Tensor::from(formats::ElementType::kUint16, {entries}, codes.columns);
  file.tensors["row_offsets"] =
      formats::Tensor::from(formats::ElementType::kInt64,
                            {static_cast<std::uint64_t>(codes.row_offsets.size())}, codes.row_offsets);
  file.tensors["tangents"] = formats::Tensor::from(formats::ElementType::kFloat32, {mesh.vertexCount(), 4},
                                                   std::span<const float>(tangents));
  return file;
}

TriangleMesh texturedBall() {
  TriangleMesh mesh = icosphere(1);
  addSphericalTexcoords(mesh);
  return mesh;
}

TEST(PixelPack, IsMadeOfTransferAndBtf) {
  const TriangleMesh mesh = texturedBall();
  PatchSources patches;
  patches.btfs[""] = madeBtfFile();
  std::vector<TextureFigures> figures;
  const formats::Pack pack =
      assemblePack(mesh, transferFile(mesh), nullptr, {}, {"mesh", "transfer", ""}, patches, &figures);
  const auto* transfer = pack.transfer.as<formats::PixelTransfer>();
  ASSERT_NE(transfer, nullptr);
  EXPECT_EQ(transfer->codes.data, madePixelTransfer(mesh).codes.data);
  EXPECT_EQ(transfer->row_lengths.data, madePixelTransfer(mesh).row_lengths.data);
  const auto* btf = pack.appearances.front().reflection.as<formats::BtfReflection>();
  ASSERT_NE(btf, nullptr);
  EXPECT_GT(btf->patch_width, 0);
  ASSERT_EQ(figures.size(), 1U);
  // What is played of the pack is what was measured.
  const formats::Pack read = formats::decodePack(formats::encodePack(pack, {}, "file"), "file");
  const auto* again = read.appearances.front().reflection.as<formats::BtfReflection>();
  ASSERT_NE(again, nullptr);
  EXPECT_EQ(again->factors.data, btf->factors.data);
  EXPECT_EQ(again->error, btf->error);
  const formats::Json json = toJson(figures);
  EXPECT_EQ(json.at(0).at("stored_bytes"), figures[0].stored_bytes);
  EXPECT_NEAR(json.at(0).at("storage_ratio").at("float16").get<double>(),
              2.0 * 4 * 8 * 16 * 3 / static_cast<double>(figures[0].stored_bytes), 1e-9);
}

// Two materials of a mesh, a table each.
TEST(PixelPack, HasABtfForEachMaterial) {
  TriangleMesh mesh = texturedBall();
  mesh.material_names = {"wall", "roof"};
  mesh.triangle_materials.assign(mesh.triangleCount(), 0);
  mesh.triangle_materials.front() = 1;
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "btfs.safetensors";
  formats::BtfTableWriter writer(path, {{"roof", 1, 4, 1, 1}, {"wall", 1, 4, 2, 1}});
  writer.append("roof", std::vector<float>(48, 0.5F));
  writer.append("wall", std::vector<float>(96, 0.25F));
  writer.finish();
  PatchSources patches;
  for (const formats::BtfTable& table : formats::readBtfTables(path))
    patches.tables.emplace(table.material, table);
  patches.own_materials = {"wall", "roof"};
  PackingOptions options;
  options.material.reflections.assign(2, formats::Lambert{});
  options.material.names = mesh.material_names;
  options.material.of_triangle.assign(mesh.triangle_materials.begin(), mesh.triangle_materials.end());
  std::vector<TextureFigures> figures;
  const formats::Pack pack =
      assemblePack(mesh, transferFile(mesh), nullptr, options, {"mesh", "transfer", ""}, patches, &figures);
  ASSERT_EQ(pack.appearances.size(), 2U);
  for (const formats::Appearance& appearance : pack.appearances) {
    const auto* btf = appearance.reflection.as<formats::BtfReflection>();
    ASSERT_NE(btf, nullptr);
    EXPECT_EQ(btf->width, appearance.material == "wall" ? 2 : 1);
  }
  EXPECT_EQ(figures.size(), 2U);
}

// Heights of the texture of the same run; a texture alone is for the other basis, and is not dropped without a word.
TEST(PixelPack, TakesHeightsOfTheTextureBesideTheBtf) {
  const TriangleMesh mesh = texturedBall();
  PatchSources patches;
  patches.btfs[""] = madeBtfFile();
  const formats::BtfInfo& info = patches.btfs[""]->info();
  formats::RadianceTransferTexture texture{
      .material = "",
      .order = 1,
      .views = static_cast<int>(std::lround(std::sqrt(info.views.size()))),
      .width = info.width,
      .height = info.height};
  texture.allocate();
  texture.heights.assign(texture.responseCount(), 0.25F);
  patches.textures = {texture};
  const auto packed = [&] {
    return assemblePack(mesh, transferFile(mesh), nullptr, {}, {"mesh", "transfer", "", "", "rtt.exr"},
                        patches);
  };
  const formats::Pack pack = packed();
  const auto* btf = pack.appearances.front().reflection.as<formats::BtfReflection>();
  ASSERT_NE(btf, nullptr);
  ASSERT_TRUE(btf->heights);
  ASSERT_EQ(btf->heights->rows, btf->factors.rows);
  // Within an eighth of a texel's width.
  for (const float height : btf->heights->decode()) ASSERT_NEAR(height, 0.25F, 0.125 / info.width + 1e-3);
  patches.btfs.clear();
  EXPECT_THAT(messageOf(packed), HasSubstr("rtt.exr"));
}

TEST(PixelPack, RefusesWhatDoesNotFit) {
  const TriangleMesh mesh = texturedBall();
  const auto messageWith = [&](const std::function<void(formats::TensorFile&, PackingOptions&)>& change) {
    formats::TensorFile file = transferFile(mesh);
    PackingOptions options;
    change(file, options);
    return messageOf([&] { assemblePack(mesh, file, nullptr, options, {"mesh", "transfer", ""}); });
  };
  EXPECT_EQ(messageWith([](auto&, auto&) {}), "");
  EXPECT_THAT(messageWith([](auto& file, auto&) { file.metadata["cube_side"] = "200"; }),
              HasSubstr("cube_side"));
  EXPECT_THAT(messageWith([](auto& file, auto&) { file.metadata["local_side"] = "3"; }),
              HasSubstr("row_offsets"));
  EXPECT_THAT(messageWith([](auto& file, auto&) { file.metadata["mesh_hash"] = "x"; }),
              HasSubstr("mesh_hash"));
  EXPECT_THAT(messageWith([](auto& file, auto&) {
                std::vector<std::int64_t> offsets;
                for (const auto value : file.tensors["row_offsets"].template as<std::int64_t>())
                  offsets.push_back(value);
                offsets[2] = offsets.back() + 5;
                const auto count = static_cast<std::uint64_t>(offsets.size());
                file.tensors["row_offsets"] = formats::Tensor::from(formats::ElementType::kInt64, {count},
                                                                    std::span<const std::int64_t>(offsets));
              }),
              HasSubstr("row 1"));
  EXPECT_THAT(
      messageWith([](auto&, auto& options) { options.material.reflections = {formats::PhongReflection{}}; }),
      HasSubstr("pixel basis"));
}

}  // namespace
}  // namespace bakelight::packing
