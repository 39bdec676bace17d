// What bicluster writes, as pack takes it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "compression/shared_sums.h"
#include "formats/error.h"
#include "formats/pack.h"
#include "formats/sum_grammar_file.h"
#include "tests/support/pixel_transfer_file.h"
#include "tests/support/shapes.h"
#include "tests/support/temporary_folder.h"
#include "tools/pack/packing.h"

namespace bakelight {
namespace {

using namespace bakelight::tests;
using testing::HasSubstr;

class BiclusterTool : public testing::Test {
 protected:
  void SetUp() override {
    addSphericalTexcoords(mesh_);
    formats::writeSafetensors(folder_.path() / "transfer", pixelTransferFile(mesh_));
  }
  int run(const std::string& options) const {
    return std::system((std::string(BAKELIGHT_BIN_DIR) + "/bicluster --transfer " +
                        (folder_.path() / "transfer").string() + " --progress none " + options + " 2>" +
                        (folder_.path() / "errors").string())
                           .c_str());
  }
  formats::TensorFile written(const std::string& options) const {
    const std::filesystem::path path = folder_.path() / "out";
    EXPECT_EQ(run("--out " + path.string() + " " + options), 0);
    return formats::readSafetensors(path);
  }
  formats::Pack packed(const formats::TensorFile& file) const {
    return packing::assemblePack(mesh_, file, nullptr, {}, {"mesh", "sums.safetensors", ""});
  }

  TemporaryFolder folder_;
  formats::TriangleMesh mesh_ = icosphere(2);
};

TEST_F(BiclusterTool, WritesWhatPacksHold) {
  const formats::TensorFile file = written("");
  const formats::Pack pack = packed(file);
  const auto& transfer = *pack.transfer.as<formats::PixelTransfer>();
  const formats::PixelTransfer rows = madePixelTransfer(mesh_);
  ASSERT_TRUE(transfer.sums);
  EXPECT_EQ(transfer.tangents, rows.tangents);
  EXPECT_EQ(transfer.blocks, rows.blocks);
  EXPECT_EQ(transfer.changes.has_value(), false);
  const formats::PixelTransferRows read(rows);
  EXPECT_FALSE(transfer.sums->grammar->sum_parts.empty());
  EXPECT_EQ(compression::reconstructionErrors(*transfer.sums->grammar, read.view()), 0U);

  const formats::Pack again = formats::decodePack(formats::encodePack(pack, {}, "pack"), "pack");
  const auto& opened = *again.transfer.as<formats::PixelTransfer>();
  ASSERT_TRUE(opened.sums && opened.sums->grammar);
  EXPECT_EQ(compression::reconstructionErrors(*opened.sums->grammar, read.view()), 0U);
}

TEST_F(BiclusterTool, TellsTheToleranceAndItsError) {
  for (const char* method : {"sums", "csr"}) {
    const formats::TensorFile file = written(std::string("--tolerance 0.3 --method ") + method);
    EXPECT_EQ(file.metadata.at("tolerance"), "0.3");
    EXPECT_GT(std::stod(file.metadata.at("largest_error")), 0);
    EXPECT_LE(std::stod(file.metadata.at("largest_error")), 0.3);
    const formats::Pack pack = packed(file);
    const auto& transfer = *pack.transfer.as<formats::PixelTransfer>();
    EXPECT_EQ(transfer.sums.has_value(), method == std::string("sums"));
    ASSERT_TRUE(transfer.changes);
    EXPECT_FLOAT_EQ(transfer.changes->tolerance, 0.3F);
    EXPECT_FLOAT_EQ(transfer.changes->rms_error, std::stof(file.metadata.at("rms_error")));
  }
}

TEST_F(BiclusterTool, RowsStayWhatTheyAre) {
  const formats::TensorFile file = written("--method csr"), transfer = pixelTransferFile(mesh_);
  for (const auto& [name, tensor] : transfer.tensors)
    EXPECT_EQ(file.tensors.at(name).data, tensor.data) << name;
  EXPECT_EQ(file.metadata, transfer.metadata);
}

TEST_F(BiclusterTool, HasNoFileForTheGreedyMethod) {
  EXPECT_EQ(run("--method greedy"), 0);
  EXPECT_NE(run("--method greedy --out " + (folder_.path() / "greedy").string()), 0);
}

TEST_F(BiclusterTool, PackRefusesWhatDoesNotFit) {
  const auto messageWith = [&](const auto& spoil) -> std::string {
    formats::TensorFile file = written("");
    spoil(file);
    try {
      packed(file);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(messageWith([](auto&) {}), "");
  EXPECT_THAT(messageWith([](auto& file) { file.metadata["rows"] = "16"; }), HasSubstr("metadata rows"));
  EXPECT_THAT(messageWith([](auto& file) { file.metadata["mesh_hash"] = "x"; }), HasSubstr("mesh_hash"));
  EXPECT_THAT(messageWith([](auto& file) { file.metadata["tolerance"] = "much"; }), HasSubstr("tolerance"));
  EXPECT_THAT(messageWith([](auto& file) { file.tensors.erase("term_ranks"); }), HasSubstr("digest"));
  EXPECT_THAT(messageWith([](auto& file) { file.tensors.erase("tangents"); }), HasSubstr("tangents"));
}

}  // namespace
}  // namespace bakelight
