#include "tools/inspect/inspect.h"

#include <array>
#include <cstdio>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/mesh_ply.h"
#include "tools/inspect/file_kind.h"

namespace bakelight::inspect {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class InspectFileTest : public ::testing::Test {
 protected:
  InspectFileTest() { fs::create_directories(folder_); }
  ~InspectFileTest() override { fs::remove_all(folder_); }

  fs::path written(const std::string& name, const std::string& text) const {
    formats::writeFileAtomically(folder_ / name, text);
    return folder_ / name;
  }
  std::string errorOf(const fs::path& path, const std::optional<PreviewOptions>& preview = {}) const {
    try {
      inspectFile(path, preview);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  const fs::path folder_ =
      fs::temp_directory_path() /
      (std::string("bakelight_inspect_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

constexpr const char* kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

formats::Pack trianglePack() {
  formats::Pack pack;
  pack.name = "one";
  pack.sh().order = 1;
  pack.sh().vectors =
      formats::encodeTable(std::vector<float>{1, 1, 1}, 1, formats::Precision::kFloat32, "test", "table");
  pack.mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}};
  pack.mesh.normals.assign(3, {0, 0, 1});
  pack.mesh.triangles = {{0, 1, 2}};
  return pack;
}

TEST_F(InspectFileTest, AMeshOfAnotherFormat) {
  const Inspection inspection = inspectFile(written("a.obj", kObj), PreviewOptions{.size_px = 16});
  EXPECT_EQ(inspection.summary.kind, "mesh");
  EXPECT_EQ(inspection.summary.file_bytes, std::string(kObj).size());
  EXPECT_EQ(asJson(inspection.summary)["size"]["triangles"], 1);
  ASSERT_TRUE(inspection.preview);
  EXPECT_EQ(inspection.preview->image.width, 16);
}

TEST_F(InspectFileTest, OurPlyKeepsItsVertices) {
  formats::TriangleMesh mesh = trianglePack().mesh;
  mesh.positions.push_back({9, 9, 9});  // in no triangle
  mesh.normals.push_back({0, 0, 1});
  formats::writePly(folder_ / "a.ply", mesh);
  const auto json = asJson(inspectFile(folder_ / "a.ply", {}).summary);
  EXPECT_EQ(json["size"]["vertices"], 4);
  EXPECT_EQ(json["topology"]["isolated_vertices"], 1);
  EXPECT_EQ(json["attributes"]["geometry_hash"], formats::geometryHash(mesh));
}

TEST_F(InspectFileTest, AGlbOfOursIsAPackAndDamageIsFound) {
  formats::writePack(folder_ / "a.glb", trianglePack(), {});
  EXPECT_EQ(inspectFile(folder_ / "a.glb", {}).summary.kind, "pack");
  formats::Bytes bytes = formats::readFile(folder_ / "a.glb");
  bytes[bytes.size() - 8] ^= std::byte{1};
  formats::writeFileAtomically(folder_ / "a.glb", bytes);
  EXPECT_THAT(errorOf(folder_ / "a.glb"), HasSubstr("checksum"));
}

TEST_F(InspectFileTest, AnImageWithNanIsShownNotRefused) {
  // Radiance HDR cannot hold NaN, so a float EXR is patched: written with 12345, which becomes a NaN's bits.
  formats::Image image(1, 1, {"Y"});
  image.values[0] = 12345;
  formats::writeExr(folder_ / "a.exr", image, formats::ExrPrecision::kFloat);
  formats::Bytes bytes = formats::readFile(folder_ / "a.exr");
  const std::array<std::byte, 4> value = {std::byte{0}, std::byte{0xE4}, std::byte{0x40}, std::byte{0x46}};
  const auto place = std::search(bytes.begin(), bytes.end(), value.begin(), value.end());
  ASSERT_NE(place, bytes.end());
  const std::array<std::byte, 4> nan = {std::byte{0}, std::byte{0}, std::byte{0xC0}, std::byte{0x7F}};
  std::copy(nan.begin(), nan.end(), place);
  formats::writeFileAtomically(folder_ / "a.exr", bytes);
  EXPECT_EQ(asJson(inspectFile(folder_ / "a.exr", {}).summary)["channels"][0]["nan"], 1);
}

TEST_F(InspectFileTest, UnknownFilesAreToldWhatCanBeOpened) {
  const std::string error = errorOf(written("a.xyz", "?"));
  EXPECT_THAT(error, HasSubstr("nothing here opens .xyz files"));
  for (const char* known : {".obj", ".ply", ".exr", ".safetensors", ".glb", "stats.json"})
    EXPECT_THAT(error, HasSubstr(known));
  EXPECT_THAT(errorOf(folder_ / "missing.ply"), HasSubstr("there is no such file"));
}

TEST_F(InspectFileTest, AMaterialIsShownMemberByMember) {
  const fs::path material =
      written("glaze.json", R"({ "albedo": [0.5, 0.25, 0.125], "reflection": { "model": "ggx" } })");
  const Inspection inspected = inspectFile(material, {});
  EXPECT_EQ(inspected.summary.kind, "material");
  EXPECT_THAT(asText(inspected.summary), HasSubstr("reflection.roughness"));
  EXPECT_THAT(errorOf(material, PreviewOptions{}), HasSubstr("nothing to draw"));
  EXPECT_THAT(errorOf(written("typo.json", R"({ "albedo": [2, 0, 0] })")), HasSubstr("/albedo"));
}

TEST_F(InspectFileTest, ARecordHasNoPreview) {
  const fs::path record =
      written("stats.json", R"({"tool": "pack", "wall_s": 1, "cpu_s": 1, "peak_memory_bytes": 1,
                                                    "warnings": [], "stats": {}})");
  EXPECT_EQ(inspectFile(record, {}).summary.kind, "record");
  EXPECT_THAT(errorOf(record, PreviewOptions{}), HasSubstr("nothing to draw"));
}

TEST_F(InspectFileTest, TheToolTakesItsFileWithoutAnOption) {
  const fs::path mesh = written("a.obj", kObj), preview = folder_ / "a.png";
  const std::string command = std::string(BAKELIGHT_BIN_DIR) + "/inspect --format json " + mesh.string() +
                              " --preview " + preview.string() + " --size 32";
  FILE* pipe = ::popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string text;
  std::array<char, 4096> block{};
  while (const std::size_t count = std::fread(block.data(), 1, block.size(), pipe))
    text.append(block.data(), count);
  ASSERT_EQ(::pclose(pipe), 0);
  const formats::Json json = formats::Json::parse(text);
  EXPECT_EQ(json["kind"], "mesh");
  EXPECT_EQ(json["size"]["vertices"], 3);
  EXPECT_EQ(formats::readImage(preview).width, 32);
}

}  // namespace
}  // namespace bakelight::inspect
