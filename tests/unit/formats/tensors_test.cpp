#include "formats/tensors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <cstring>
#include <iterator>

#include "formats/error.h"
#include "formats/tensor_writer.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;

TensorFile sample() {
  TensorFile file;
  const std::vector<float> values = {1.5F, -0.0F, 1e-45F, 3.4e38F, std::nextafter(1.0F, 2.0F), 6};
  const std::vector<std::uint16_t> halves = {0x3C00, 0x7BFF, 0x0001};  // 1, 65504, the least subnormal
  const std::vector<std::uint8_t> bytes = {7, 255, 0};
  const std::vector<std::int64_t> wide = {-1, std::int64_t{1} << 62};
  file.tensors["table"] = Tensor::from<float>(ElementType::kFloat32, {2, 3}, values);
  file.tensors["half"] = Tensor::from<std::uint16_t>(ElementType::kFloat16, {3}, halves);
  file.tensors["codes"] = Tensor::from<std::uint8_t>(ElementType::kUint8, {3, 1}, bytes);
  file.tensors["wide"] = Tensor::from<std::int64_t>(ElementType::kInt64, {2}, wide);
  file.tensors["empty"] = Tensor::from<float>(ElementType::kFloat32, {0, 25}, {});
  file.metadata = {{"order", "5"}, {"unit", "sr⁻¹"}};
  return file;
}

std::string errorOf(std::span<const std::byte> bytes) {
  try {
    decodeSafetensors(bytes, "t.safetensors");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

// A file of this header and `data_size` zeros.
std::string errorOfHeader(const std::string& header, std::size_t data_size) {
  Bytes bytes(8 + header.size() + data_size);
  const std::uint64_t length = header.size();
  std::memcpy(bytes.data(), &length, 8);
  std::memcpy(bytes.data() + 8, header.data(), header.size());
  return errorOf(bytes);
}

TEST(Tensors, RoundTripIsExact) {
  const TensorFile file = sample();
  const TensorFile read = decodeSafetensors(encodeSafetensors(file), "t");
  EXPECT_EQ(read.metadata, file.metadata);
  ASSERT_EQ(read.tensors.size(), 5U);
  for (const auto& [name, tensor] : file.tensors) {
    EXPECT_EQ(read.tensors.at(name).type, tensor.type) << name;
    EXPECT_EQ(read.tensors.at(name).shape, tensor.shape) << name;
    EXPECT_EQ(read.tensors.at(name).data, tensor.data) << name;
  }
}

TEST(Tensors, ArraysAreAlignedForTheirType) {
  const Bytes bytes = encodeSafetensors(sample());
  std::uint64_t length = 0;
  std::memcpy(&length, bytes.data(), 8);
  EXPECT_EQ(length % 8, 0U);
  const TensorFile read = decodeSafetensors(bytes, "t");
  const std::string data(reinterpret_cast<const char*>(bytes.data()) + 8 + length, bytes.size() - 8 - length);
  for (const auto& [name, tensor] : read.tensors) {
    const std::string part(reinterpret_cast<const char*>(tensor.data.data()), tensor.data.size());
    EXPECT_EQ(data.find(part) % sizeOf(tensor.type), 0U) << name;
  }
}

TEST(Tensors, EveryTruncationIsAnError) {
  const Bytes bytes = encodeSafetensors(sample());
  ASSERT_EQ(errorOf(bytes), "no error");
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THAT(errorOf(std::span(bytes).first(size)), HasSubstr("t.safetensors")) << size;
  }
}

TEST(Tensors, EveryFlippedHeaderBitIsReadOrRefused) {
  Bytes bytes = encodeSafetensors(sample());
  std::uint64_t length = 0;
  std::memcpy(&length, bytes.data(), 8);
  int refused = 0;
  for (std::size_t i = 0; i < 8 + length; ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      bytes[i] ^= static_cast<std::byte>(1 << bit);
      refused += errorOf(bytes) != "no error";  // anything but Error would end the test
      bytes[i] ^= static_cast<std::byte>(1 << bit);
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(Tensors, HostileHeadersAreErrors) {
  const auto entry = [](const std::string& shape, const std::string& offsets) {
    return R"({"a":{"dtype":"F32","shape":)" + shape + R"(,"data_offsets":)" + offsets + "}}";
  };
  ASSERT_EQ(errorOfHeader(entry("[2]", "[0,8]"), 8), "no error");
  for (
      const auto& [header, size] : std::vector<std::pair<std::string, std::size_t>>{
          {entry("[4611686018427387905]", "[0,4]"), 4},    // × 4 wraps to 4
          {entry("[4294967296,4294967296]", "[0,0]"), 0},  // wraps to 0
          {entry("[2]", "[0,18446744073709551615]"), 8},
          {entry("[2]", "[8,0]"), 8},
          {entry("[2]", "[0,8]"), 9},  // a byte after the last tensor
          {entry("[1]", "[4,8]"), 8},  // a hole before it
          {entry("[-2]", "[0,8]"), 8},
          {entry("[2.0]", "[0,8]"), 8},
          {entry("2", "[0,8]"), 8},
          {entry("[2]", "[0]"), 8},
          {R"({"a":{"dtype":"F33","shape":[2],"data_offsets":[0,8]}})", 8},
          {R"({"a":{"dtype":"F32","shape":[2]}})", 8},
          {R"({"a":7})", 0},
          {R"({"__metadata__":{"k":1}})", 0},
          {R"([1])", 0},
          {R"({"a":)", 0},
          {"", 0},
          {R"({"a":{"dtype":"U8","shape":[6],"data_offsets":[0,6]},"b":{"dtype":"U8","shape":[6],"data_offsets":[4,10]}})",
           10}}) {
    EXPECT_THAT(errorOfHeader(header, size), HasSubstr("t.safetensors")) << header;
  }
  EXPECT_THAT(errorOfHeader(entry("[3]", "[0,8]"), 8),
              testing::AllOf(HasSubstr("tensor a"), HasSubstr("12 bytes")));
}

TEST(Tensors, RequireNamesWhatIsMissing) {
  const TensorFile file = sample();
  EXPECT_EQ(file.require("table", ElementType::kFloat32, 2, "t").shape[1], 3U);
  EXPECT_THROW(file.require("table", ElementType::kFloat32, 1, "t"), Error);
  EXPECT_THROW(file.require("table", ElementType::kFloat64, 2, "t"), Error);
  EXPECT_THROW(file.requireMetadata("frame", "t"), Error);
  try {
    file.require("tabel", ElementType::kFloat32, 2, "t");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("table"));
  }
}

class TensorFiles : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::size_t fileCount() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("bakelight-tensors-" + std::to_string(::getpid()));
  const std::filesystem::path path_ = folder_ / "t.safetensors";
  const std::map<std::string, TensorShape> shapes_ = {{"codes", {ElementType::kUint8, {3}}},
                                                      {"table", {ElementType::kFloat32, {2, 3}}}};
  const std::vector<float> values_ = {1, 2, 3, 4, 5, 6};
  const std::vector<std::uint8_t> codes_ = {7, 8, 9};
};

TEST_F(TensorFiles, WrittenInBlocksHaveTheBytesOfTheWhole) {
  TensorWriter writer(path_, shapes_, {{"order", "5"}});
  writer.append<float>("table", std::span(values_).first(1));
  writer.append<std::uint8_t>("codes", std::span(codes_).first(2));
  writer.append<float>("table", {});
  writer.append<float>("table", std::span(values_).subspan(1));
  EXPECT_FALSE(std::filesystem::exists(path_));
  EXPECT_THROW(writer.append<float>("table", values_), std::logic_error);
  EXPECT_THROW(writer.append<std::uint16_t>("table", {}), std::logic_error);
  EXPECT_THROW(writer.append<float>("tabel", {}), std::logic_error);
  EXPECT_THROW(writer.finish(), std::logic_error);
  writer.append<std::uint8_t>("codes", std::span(codes_).subspan(2));
  writer.finish();

  TensorFile whole;
  whole.metadata = {{"order", "5"}};
  whole.tensors["table"] = Tensor::from<float>(ElementType::kFloat32, {2, 3}, values_);
  whole.tensors["codes"] = Tensor::from<std::uint8_t>(ElementType::kUint8, {3}, codes_);
  EXPECT_EQ(readFile(path_), encodeSafetensors(whole));
  EXPECT_EQ(fileCount(), 1U);
}

TEST_F(TensorFiles, NothingIsLeftOfOneThatWasNotFinished) {
  writeSafetensors(path_, sample());
  {
    TensorWriter writer(path_, shapes_, {});
    writer.append<float>("table", values_);
    EXPECT_EQ(fileCount(), 2U);
  }
  EXPECT_EQ(fileCount(), 1U);
  EXPECT_EQ(readSafetensors(path_).tensors.size(), 5U);
}

TEST_F(TensorFiles, AreMappedAndOutliveTheirName) {
  writeSafetensors(path_, sample());
  const TensorFile read = readSafetensors(path_);
  std::filesystem::remove(path_);
  for (const auto& [name, tensor] : sample().tensors)
    EXPECT_EQ(read.tensors.at(name).data, tensor.data) << name;
}

// By another program: its header is not padded.
TEST_F(TensorFiles, ArraysAtOddPlacesAreAlignedWhenRead) {
  const std::string header = R"({"a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}} )";
  ASSERT_EQ(header.size() % 4, 3U);
  Bytes bytes(8 + header.size() + 4);
  const std::uint64_t length = header.size();
  const float value = 1.5F;
  std::memcpy(bytes.data(), &length, 8);
  std::memcpy(bytes.data() + 8, header.data(), header.size());
  std::memcpy(bytes.data() + 8 + header.size(), &value, 4);
  writeFileAtomically(path_, bytes);
  const auto read = readSafetensors(path_).tensors.at("a");
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(read.data.data()) % 4, 0U);
  EXPECT_EQ(read.as<float>()[0], value);
}

TEST_F(TensorFiles, ThatAreWrongAreNamed) {
  const auto errorOfFile = [&] {
    try {
      readSafetensors(path_);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(errorOfFile(), HasSubstr("t.safetensors"));
  const Bytes bytes = encodeSafetensors(sample());
  for (const std::size_t size : {std::size_t{0}, std::size_t{7}, std::size_t{50}, bytes.size() - 1}) {
    writeFileAtomically(path_, std::span(bytes).first(size));
    EXPECT_THAT(errorOfFile(), HasSubstr("t.safetensors")) << size;
  }
}

}  // namespace
}  // namespace bakelight::formats
