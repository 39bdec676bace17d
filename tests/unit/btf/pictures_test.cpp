#include "formats/btf_pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "formats/btf_names.h"
#include "formats/error.h"
#include "formats/file.h"
#include "formats/image.h"
#include "formats/radiance_transfer_texture.h"
#include "tests/unit/btf/btf_maker.h"

namespace bakelight::formats {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

fs::path emptyFolder(const std::string& name) {
  const fs::path path = fs::path(testing::TempDir()) / "btf_pictures_test" / name;
  fs::remove_all(path);
  fs::create_directories(path);
  return path;
}

// A Radiance picture, 2 × 2, without run lengths: few bits, but quickly written.
void writeHdr(const fs::path& path, double value, const std::string& size = "-Y 2 +X 2") {
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);
  std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + size + "\n";
  for (int i = 0; i < 4; ++i) {
    for (int c = 0; c < 3; ++c) text += static_cast<char>(std::lround(mantissa * 256 - 0.5));
    text += static_cast<char>(exponent + 128);
  }
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

double valueOf(const BtfDirection& view, const BtfDirection& light) {
  return 0.25 + 0.125 * view.polar_rad + 0.0625 * std::cos(light.azimuth_rad) * light.polar_rad;
}

// With rings at whole degrees, named as UBO2003's.
std::vector<BtfDirection> fewDirections() {
  static constexpr Ring kRings[] = {{0, 1, 0}, {30, 4, 0}, {60, 8, 0}};
  return ringsOf(kRings);
}
int whole(double radians) {
  return static_cast<int>(std::lround(radians / kDegree + 360)) % 360;
}
template <class NameOf>
void writeSet(const fs::path& folder, const NameOf& nameOf) {
  for (const BtfDirection& view : fewDirections())
    for (const BtfDirection& light : fewDirections())
      writeHdr(folder / nameOf(whole(view.polar_rad), whole(view.azimuth_rad), whole(light.polar_rad),
                               whole(light.azimuth_rad)),
               valueOf(view, light));
}
std::string padded(int number) {
  const std::string text = std::to_string(number);
  return std::string(3 - text.size(), '0') + text;
}
std::string uboName(int tv, int pv, int tl, int pl) {
  return "MANYFILES/tv" + padded(tv) + "_pv" + padded(pv) + "/00008 tl" + padded(tl) + " pl" + padded(pl) +
         " tv" + padded(tv) + " pv" + padded(pv) + ".hdr";
}

void expectValues(const Btf& btf, double tolerance) {
  const BtfInfo& info = btf.info();
  for (std::size_t v = 0; v < info.views.size(); ++v) {
    const std::vector<int> lights = btf.lightsOf(static_cast<int>(v));
    std::vector<float> rgb(3 * lights.size() * btf.texelCount());
    btf.view(static_cast<int>(v))->decode(lights, {0, btf.texelCount()}, rgb);
    for (std::size_t i = 0; i < lights.size(); ++i)
      ASSERT_NEAR(rgb[i * btf.texelCount()],
                  valueOf(info.views[v], info.lights[static_cast<std::size_t>(lights[i])]), tolerance)
          << v << ", " << i;
  }
}

void writeQuickly(const fs::path& path, std::span<const std::byte> bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

std::string problemOf(const fs::path& path, const BtfPictureOptions& options = {}) {
  try {
    const auto btf = openBtfPictures(path, options);
    for (std::size_t v = 0; v < btf->info().views.size(); ++v) btf->view(static_cast<int>(v));
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.paragraph();
  }
  return "";
}

TEST(BtfNames, StateDirectionsInEveryNaming) {
  const auto expect = [](const std::string& name, double tv, double pv, double tl, double pl) {
    const auto picture = pictureOfName(name);
    ASSERT_TRUE(picture) << name;
    EXPECT_NEAR(picture->view.polar_rad, tv * kDegree, 1e-12) << name;
    EXPECT_NEAR(picture->view.azimuth_rad, pv * kDegree, 1e-12) << name;
    EXPECT_NEAR(picture->light.polar_rad, tl * kDegree, 1e-12) << name;
    EXPECT_NEAR(picture->light.azimuth_rad, pl * kDegree, 1e-12) << name;
  };
  expect("UBO2003/MANYFILES/tv030_pv000/00008 tl015 pl120 tv030 pv090.jpg", 30, 90, 15, 120);
  expect("tv075_pv345/tl000_pl000_tv075_pv345.png", 75, 345, 0, 0);
  expect("tv12.3_pv45.25_tl67_pl180.5.exr", 12.3, 45.25, 67, 180.5);
  expect("tv12.3_pv45_tl67_pl180.exr", 12.3, 45, 67, 180);
  expect("wool-pl-90-tl10-pv5-tv6.bmp", 6, 5, 10, -90);
  EXPECT_FALSE(pictureOfName("tv030_pv000/tl000_pl000.png")) << "the folder does not count";
  EXPECT_FALSE(pictureOfName("tl000_pl000_tv_pv000.png"));
  EXPECT_EQ(nameOfDirections({30 * kDegree, 0}, {7.5 * kDegree, 90 * kDegree}), "tv030_pv000_tl7.5_pl090");
}

TEST(BtfPictures, OfAFolderAreRead) {
  const fs::path folder = emptyFolder("ubo");
  writeSet(folder, uboName);
  writeHdr(folder / "cover.hdr", 1);
  std::ofstream(folder / "readme.txt") << "tl000";
  const auto btf = openBtfPictures(folder);
  EXPECT_EQ(btf->info().views.size(), 13U);
  EXPECT_EQ(btf->info().lights.size(), 13U);
  EXPECT_EQ(btf->info().width, 2);
  EXPECT_TRUE(btf->info().cosine_inside);
  EXPECT_THAT(btf->info().notes,
              testing::ElementsAre(HasSubstr("1 pictures whose names state no directions")));
  expectValues(*btf, 2e-3);
}

TEST(BtfPictures, OfAZipAreRead) {
  const fs::path folder = emptyFolder("zip");
  writeSet(folder / "UBO2003", uboName);
  const fs::path zip = folder / "set.zip";
  ASSERT_EQ(
      std::system(
          (BAKELIGHT_PYTHON " -m zipfile -c " + zip.string() + " " + (folder / "UBO2003").string()).c_str()),
      0);
  ASSERT_TRUE(isPictureSet(zip));
  const auto btf = openBtfPictures(zip);
  EXPECT_EQ(btf->info().views.size(), 13U);
  expectValues(*btf, 2e-3);
}

TEST(BtfPictures, OfADamagedZipAreRefused) {
  const fs::path folder = emptyFolder("damaged"), zip = folder / "set.zip";
  for (const int tl : {0, 30, 60}) writeHdr(folder / "set" / uboName(0, 0, tl, 0), 0.5);
  ASSERT_EQ(
      std::system(
          (BAKELIGHT_PYTHON " -m zipfile -c " + zip.string() + " " + (folder / "set").string()).c_str()),
      0);
  const Bytes bytes = readFile(zip);
  ASSERT_EQ(problemOf(zip), "");
  for (const std::size_t size : {bytes.size() - 1, bytes.size() - 40, bytes.size() / 2, std::size_t{30}}) {
    writeQuickly(folder / "cut.zip", std::span(bytes).first(size));
    EXPECT_THAT(problemOf(folder / "cut.zip"), HasSubstr("zip")) << size;
  }
  for (std::size_t at = 0; at < bytes.size(); at += 7) {
    Bytes turned = bytes;
    turned[at] ^= std::byte{0xFF};
    writeQuickly(folder / "turned.zip", turned);
    problemOf(folder / "turned.zip");  // an error, or other names: no crash
  }
}

TEST(BtfPictures, ThatAreMissingAreNamed) {
  const fs::path folder = emptyFolder("gaps");
  writeSet(folder, uboName);
  fs::remove(folder / uboName(30, 90, 60, 45));
  fs::remove(folder / uboName(60, 0, 0, 0));
  writeHdr(folder / "again tl000 pl090 tv000 pv000.hdr", 0.5);  // the zenith has no azimuth
  const auto btf = openBtfPictures(folder);
  EXPECT_THAT(btf->info().notes, testing::Contains(HasSubstr("2 of 169 pairs")));
  EXPECT_THAT(btf->info().notes, testing::Contains(HasSubstr("tv030_pv090_tl060_pl045")));
  EXPECT_THAT(btf->info().notes, testing::Contains(HasSubstr("tv060_pv000_tl000_pl000")));
  EXPECT_THAT(btf->info().notes, testing::Contains(HasSubstr("1 pictures show a pair of directions again")));
  expectValues(*btf, 2e-3);
}

TEST(BtfPictures, AreFoundByATable) {
  const fs::path folder = emptyFolder("table");
  for (const char* name : {"01.hdr", "02.hdr", "03.hdr"}) writeHdr(folder / name, 0.5);
  const std::string header = "file,view_polar_deg,view_azimuth_deg,light_polar_deg,light_azimuth_deg\n";
  writeFileAtomically(folder / "t.csv",
                      header + "01.hdr, 10, 20, 30, 40\r\n# two\n02.hdr,10,20,50,60\n04.hdr,1,2,3,4\n");
  const auto by_csv = openBtfPictures(folder, {.table = folder / "t.csv"});
  EXPECT_EQ(by_csv->info().views.size(), 1U);
  EXPECT_EQ(by_csv->info().lights.size(), 2U);
  EXPECT_NEAR(by_csv->info().lights[1].azimuth_rad, 60 * kDegree, 1e-12);
  EXPECT_THAT(by_csv->info().notes, testing::Contains(HasSubstr("04.hdr")));
  writeFileAtomically(folder / "t.json", std::string(R"({ "pictures": [
      { "file": "01.hdr", "view": [10, 20], "light": [30, 40] }, { "file": "03.hdr", "view": [0, 0], "light": [5, -90] }] })"));
  const auto by_json = openBtfPictures(folder, {.table = folder / "t.json"});
  EXPECT_EQ(by_json->info().views.size(), 2U);
  EXPECT_EQ(by_json->lightsOf(0).size(), 1U);

  const auto csv_problem = [&](const std::string& text) {
    writeFileAtomically(folder / "wrong.csv", text);
    return problemOf(folder, {.table = folder / "wrong.csv"});
  };
  EXPECT_THAT(csv_problem("a,b\n"), HasSubstr("line 1"));
  EXPECT_THAT(csv_problem(header + "01.hdr,1,2,3\n"), HasSubstr("line 2"));
  EXPECT_THAT(csv_problem(header + "01.hdr,1,2,95,4\n"), HasSubstr("polar"));
  EXPECT_THAT(csv_problem(header + "01.hdr,1,nan,5,4\n"), HasSubstr("azimuth"));
  EXPECT_THAT(csv_problem(header), HasSubstr("names no picture"));
  EXPECT_THAT(csv_problem(header + "x.hdr,1,2,3,4\n"), HasSubstr("x.hdr"));
  writeFileAtomically(
      folder / "wrong.json",
      std::string(R"({ "pictures": [{ "file": "01.hdr", "view": [10], "light": [1, 2] }] })"));
  EXPECT_THAT(problemOf(folder, {.table = folder / "wrong.json"}), HasSubstr("/pictures/0/view"));
}

// Codes of sRGB, CIE XYZ, spectra: what a picture's channels are.
TEST(BtfPictures, AreLinearRedGreenAndBlue) {
  const fs::path folder = emptyFolder("colors");
  const auto colorOf = [&](const Image& image, const std::string& ending,
                           const BtfPictureOptions& options = {}) {
    fs::remove_all(folder);
    const fs::path path = folder / ("tl000_pl000_tv000_pv000" + ending);
    if (ending == ".png")
      writePng(path, image);
    else
      writeExr(path, image, ExrPrecision::kFloat);
    return decoded(*openBtfPictures(folder, options));
  };
  Image gray(1, 1, {"R", "G", "B"});
  gray.values = {0.5F, 0.5F, 0.5F};
  EXPECT_NEAR(colorOf(gray, ".png")[0], std::pow((128.0 / 255 + 0.055) / 1.055, 2.4), 1e-4);
  Image white(1, 1, {"X", "Y", "Z"});  // D65
  white.values = {0.95047F, 1, 1.08883F};
  EXPECT_THAT(colorOf(white, ".exr"), testing::Each(testing::FloatNear(1, 1e-3F)));
  white.channel_names = {"R", "G", "B"};
  EXPECT_NEAR(colorOf(white, ".exr")[2], 1.08883, 1e-5);
  EXPECT_THAT(colorOf(white, ".exr", {.colors = BtfPictureColors::kXyz}),
              testing::Each(testing::FloatNear(1, 1e-3F)));
  Image spectrum(1, 1, {"400nm", "450nm", "500nm", "550nm", "600nm", "650nm", "700nm"});
  spectrum.values.assign(7, 0.4F);
  EXPECT_THAT(colorOf(spectrum, ".exr"), testing::Each(testing::FloatNear(0.4F, 1e-5F)));
  spectrum.values = {0, 0, 0, 0, 0.5F, 1, 1};
  const std::vector<float> red = colorOf(spectrum, ".exr");
  EXPECT_GT(red[0], 3 * std::abs(red[1]));
}

TEST(BtfPictures, ThatCannotBeReadAreRefused) {
  const fs::path folder = emptyFolder("wrong");
  EXPECT_THAT(problemOf(folder), HasSubstr("holds no picture"));
  EXPECT_THAT(problemOf(folder / "none"), HasSubstr("no such folder"));
  writeHdr(folder / "01.hdr", 1);
  EXPECT_THAT(problemOf(folder), HasSubstr("01.hdr"));
  writeHdr(folder / "tl000_pl000_tv100_pv000.hdr", 1);
  EXPECT_THAT(problemOf(folder), HasSubstr("below the horizon"));
  fs::remove(folder / "tl000_pl000_tv100_pv000.hdr");
  writeHdr(folder / "tl000_pl000_tv010_pv000.hdr", 1);
  writeHdr(folder / "tl010_pl000_tv010_pv000.hdr", 1, "-Y 1 +X 4");
  EXPECT_THAT(problemOf(folder), HasSubstr("4 × 1"));
  std::ofstream(folder / "tl010_pl000_tv010_pv000.hdr") << "no picture";
  EXPECT_THAT(problemOf(folder), HasSubstr("tl010_pl000_tv010_pv000.hdr"));
}

// Folder in, texture and .btf out, and that in again.
TEST(BtfTool, ProjectsAndRewrites) {
  const fs::path folder = emptyFolder("tool"), set = folder / "set";
  writeSet(set, uboName);
  const std::string run = std::string(BAKELIGHT_BIN_DIR) + "/btf --progress none --measured ";
  const auto path = [&](const char* name) { return (folder / name).string(); };
  ASSERT_EQ(std::system((run + set.string() + " --scale 1 --precision float --rtt " + path("a.exr") +
                         " --written " + path("a.btf") + " --stats " + path("a.json") + " 2> " + path("log"))
                            .c_str()),
            0);
  ASSERT_EQ(std::system((run + path("a.btf") + " --precision float --rtt " + path("b.exr") + " --stats " +
                         path("b.json"))
                            .c_str()),
            0);
  const RadianceTransferTexture a = readRadianceTransferTextures(folder / "a.exr").at(0);
  const RadianceTransferTexture b = readRadianceTransferTextures(folder / "b.exr").at(0);
  ASSERT_EQ(a.values.size(), b.values.size());
  EXPECT_EQ(a.width, 2);
  EXPECT_EQ(a.views, 8);
  for (std::size_t i = 0; i < a.values.size(); ++i) ASSERT_NEAR(a.values[i], b.values[i], 1e-5);
  const std::string stats = readTextFile(folder / "a.json");
  for (const char* name :
       {"written_error", "view_gap_deg", "missing_pictures", "channel_errors", "expanded_bytes"})
    EXPECT_THAT(stats, HasSubstr(name));
  ASSERT_EQ(
      std::system((run + path("a.btf") + " --layout raw --resolution 1 --written " + path("c.btf")).c_str()),
      0);
  EXPECT_EQ(openBtf(folder / "c.btf")->info().layout, "BDI");
  EXPECT_EQ(openBtf(folder / "c.btf")->info().width, 1);
  EXPECT_NE(std::system((run + path("log") + " 2> /dev/null").c_str()), 0);
}

}  // namespace
}  // namespace bakelight::formats
