#include "tools/transfer/pixel_file.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "formats/tensors.h"
#include "tests/support/shapes.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;
using formats::ElementType;

PixelFileFigures writeTo(const std::filesystem::path& path, const TriangleMesh& mesh,
                         const PixelOptions& options) {
  stage::Progress silent(stage::ProgressStyle::kNone, "", 0, "");
  return writePixelTransfer(path, mesh, options, silent);
}

template <class T>
std::vector<T> valuesOf(const formats::TensorFile& file, const char* name) {
  const auto values = file.tensors.at(name).as<T>();
  return {values.begin(), values.end()};
}

// Of more than one block of vertices.
TEST(PixelFile, HoldsWhatIsBaked) {
  const TemporaryFolder folder;
  TriangleMesh mesh = icosphere(3);
  append(mesh, icosphere(3, 0.4, Vec3(1.4, 0.3, 0)));
  ASSERT_GT(mesh.vertexCount(), 1024U);
  const PixelOptions options{.cube_side = 8, .local_side = 4};
  const auto path = folder.path() / "deeper" / "pixel.safetensors";
  const PixelFileFigures figures = writeTo(path, mesh, options);
  const formats::TensorFile file = formats::readSafetensors(path);
  const PixelBlock whole = bakePixelTransfer(mesh, options);
  EXPECT_EQ(valuesOf<std::uint8_t>(file, "codes"), whole.rows.codes);
  EXPECT_EQ(valuesOf<std::uint16_t>(file, "columns"), whole.rows.columns);
  EXPECT_EQ(valuesOf<std::uint64_t>(file, "row_offsets"), whole.rows.row_offsets);
  EXPECT_EQ(figures.entries, whole.rows.codes.size());
  EXPECT_EQ(figures.rays, whole.figures.rays);
  const std::vector<float> normals = valuesOf<float>(file, "normals"),
                           tangents = valuesOf<float>(file, "tangents");
  ASSERT_EQ(normals.size(), 3 * mesh.vertexCount());
  ASSERT_EQ(tangents.size(), 4 * mesh.vertexCount());
  EXPECT_EQ(normals[3 * 700 + 1], mesh.normals[700][1]);
  EXPECT_EQ(file.metadata.at("technique"), "pixel");
  EXPECT_EQ(file.metadata.at("cube_side"), "8");
  EXPECT_EQ(file.metadata.at("local_side"), "4");
  EXPECT_EQ(file.metadata.at("subsamples"), "2");
  EXPECT_EQ(file.metadata.at("mesh_hash"), formats::geometryHash(mesh));
  for (const auto& entry : std::filesystem::directory_iterator(path.parent_path()))
    EXPECT_EQ(entry.path(), path) << "left behind";

  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto again = folder.path() / "again.safetensors";
  writeTo(again, mesh, options);
  EXPECT_EQ(formats::readFile(again), formats::readFile(path));
}

TEST(PixelFile, RefusesWhatItHasNot) {
  const auto pointerOf = [](const TransferSettings& settings) -> std::string {
    try {
      pixelOptions(settings);
    } catch (const Error& error) {
      return error.place().pointer;
    }
    return "";
  };
  TransferSettings settings;
  settings.options.bias = 0.01;
  EXPECT_EQ(pointerOf(settings), "");
  EXPECT_EQ(pixelOptions(settings).bias, 0.01);
  EXPECT_TRUE(pixelOptions(settings).shadows);
  settings.options.transport = Transport::kUnshadowed;
  EXPECT_FALSE(pixelOptions(settings).shadows);
  settings.options.transport = Transport::kInterreflected;
  EXPECT_EQ(pointerOf(settings), "/transport");
  settings = {};
  settings.near_field = true;
  EXPECT_EQ(pointerOf(settings), "/near_field");
  settings = {};
  settings.technique = Technique::kGlossy;
  EXPECT_EQ(pointerOf(settings), "/technique");
}

TEST(PixelFile, CannotBeWrittenIntoAFile) {
  const TemporaryFolder folder;
  formats::writeFileAtomically(folder.path() / "file", formats::Bytes());
  EXPECT_THROW(writeTo(folder.path() / "file" / "pixel.safetensors", icosphere(0), {.cube_side = 2}), Error);
}

}  // namespace
}  // namespace bakelight::transfer
