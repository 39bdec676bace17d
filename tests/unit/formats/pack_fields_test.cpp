// Each field of a pack is in every list: what changes is compared, written, read, and follows its vertex.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "formats/compare.h"
#include "formats/error.h"
#include "formats/pack.h"
#include "formats/rtt_reflection.h"
#include "tests/support/compressed_transfer.h"
#include "tests/support/made_pixel_pack.h"
#include "tests/support/made_rtt.h"
#include "tests/unit/formats/test_packs.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;

// Finds out each field of a part, and changes one of them.
class FieldChanger final : public FieldVisitor {
 public:
  explicit FieldChanger(std::size_t changed) : changed_(changed) {}
  const std::string& changedName() const { return name_; }  // empty: there are fewer fields

  void integer(const char* name, int& value, const Range&) override {
    change(name, [&] { ++value; });
  }
  void number(const char* name, float& value, const Range&) override {
    change(name, [&] { value += 0.125F; });
  }
  void vector(const char* name, Float3& value, const Range&) override {
    change(name, [&] { value[1] += 0.125F; });
  }
  void constant(const char*, const char*) override {}
  void choice(const char* name, int& value, std::span<const char* const> names) override {
    // Another operator would be another list.
    if (std::string_view(name) == "operator") return;
    change(name, [&] { value = (value + 1) % static_cast<int>(names.size()); });
  }
  void table(const char* name, EncodedTable& table, Rows, std::size_t) override {
    change(name,
           [&] { setByte(table, table.rowBytes() + 1, table.data[table.rowBytes() + 1] ^ std::byte{4}); });
  }
  void floats(const char* name, std::vector<float>& values, std::size_t) override {
    change(name, [&] { values[1] += 1; });
  }
  void integers(const char* name, IntegerArray& values, std::size_t) override {
    change(name, [&] {
      Bytes bytes(values.data.begin(), values.data.end());
      bytes[2] ^= std::byte{1};
      values.data = std::move(bytes);
    });
  }
  void indices(const char* name, std::vector<std::uint32_t>& values, std::size_t) override {
    change(name, [&] { values[1] = 1 - values[1]; });
  }
  void tangents(const char* name, std::vector<Float4>& values) override {
    change(name, [&] { values[1][3] *= -1; });
  }
  void image(const char* name, PackImage& image) override { table(name, image.texels, Rows::kOther, 0); }
  bool open(const char*, bool is_there) override { return is_there; }
  void close() override {}
  void require(bool, const char*, const std::string&, const std::string&, const std::string&) override {}

 private:
  template <class Change>
  void change(const char* name, const Change& change_field) {
    if (next_++ != changed_) return;
    name_ = name;
    change_field();
  }

  std::size_t changed_, next_ = 0;
  std::string name_;
};

// Sizes follow from these: a pack with another value is none.
bool isSize(const std::string& name) {
  return name == "order" || name == "outputOrder" || name == "channels" || name == "angles";
}

class EveryField : public testing::TestWithParam<std::tuple<Storage, Lobe>> {
 protected:
  // Calls test(pack, name of what was changed) for each field of the transfer and the reflection.
  template <class Test>
  void forEachChange(const Test& test) {
    TriangleMesh grid = wavyGrid(4);
    grid.texcoords.clear();  // they are turned over, which may round
    const Pack source =
        glossyPack(std::move(grid), std::get<0>(GetParam()), Precision::kUint8, std::get<1>(GetParam()));
    std::size_t tested = 0;
    for (const bool of_transfer : {true, false})
      for (std::size_t i = 0;; ++i) {
        Pack pack = source;
        FieldChanger changer(i);
        (of_transfer ? pack.transfer : reflectionOf(pack)).describe(changer);
        if (changer.changedName().empty()) break;
        if (isSize(changer.changedName())) continue;
        SCOPED_TRACE(changer.changedName());
        test(source, pack);
        ++tested;
      }
    EXPECT_GE(tested, 8U);
  }
};

TEST_P(EveryField, IsCompared) {
  forEachChange([](const Pack& source, const Pack& changed) {
    EXPECT_FALSE(comparePacks(changed, source, {}).passes());
  });
}

TEST_P(EveryField, IsWrittenAndRead) {
  forEachChange([](const Pack&, const Pack& changed) {
    const Comparison comparison = comparePacks(roundTrip(changed, {}), changed, {});
    EXPECT_TRUE(comparison.passes()) << testing::PrintToString(comparison.mismatches);
  });
}

// Those of a radiance transfer texture, too; its sizes but for `repeats` and the width follow from each other.
TEST(EveryFieldOfATexture, IsComparedWrittenAndRead) {
  Pack source = glossyPack(wavyGrid(4), Storage::kMatrix, Precision::kFloat32, Lobe::kNone);
  RttReflection rtt = tests::madeRtt(3, 2, 4, 3, 5);
  rtt.index = tests::madeIndex(8, 4);
  reflectionOf(source) = rtt;
  std::set<std::string> tested;
  for (std::size_t i = 0;; ++i) {
    Pack pack = source;
    FieldChanger changer(i);
    reflectionOf(pack).describe(changer);
    const std::string& name = changer.changedName();
    if (name.empty()) break;
    if (isSize(name) || name == "views" || name == "width" || name == "height" || name == "components")
      continue;
    SCOPED_TRACE(name);
    EXPECT_FALSE(comparePacks(pack, source, {}).passes());
    for (const bool draco : {false, true}) {
      const Pack read = roundTrip(pack, {.draco = draco});
      const auto* texture = reflectionOf(const_cast<Pack&>(read)).as<RttReflection>();
      ASSERT_NE(texture, nullptr);
      const auto& changed = reflectionAs<RttReflection>(pack);
      EXPECT_EQ(texture->factors.data, changed.factors.data);
      EXPECT_EQ(texture->basis, changed.basis);
      EXPECT_EQ(texture->heights->data, changed.heights->data);
      EXPECT_EQ(texture->index->texels.data, changed.index->texels.data);
      EXPECT_EQ(texture->patch_width, changed.patch_width);
      EXPECT_EQ(texture->repeats, changed.repeats);
    }
    tested.insert(name);
  }
  EXPECT_EQ(tested,
            (std::set<std::string>{"patchWidth", "factors", "basis", "heights", "repeats", "places"}));
}

// A pack in a pixel basis with a BTF; of its sizes nothing can be changed alone.
TEST(EveryFieldOfAPixelPack, IsComparedWrittenAndReadAndFollowsItsVertex) {
  Pack source = tests::madePixelPack(wavyGrid(4));
  source.mesh.texcoords.clear();  // they are turned over, which may round
  const std::set<std::string> sizes = {"cubeSide", "localSide", "subsamples", "lights",    "rowLengths",
                                       "views",    "width",     "height",     "components"};
  std::set<std::string> tested;
  for (const bool of_transfer : {true, false})
    for (std::size_t i = 0;; ++i) {
      Pack pack = source;
      FieldChanger changer(i);
      (of_transfer ? pack.transfer : reflectionOf(pack)).describe(changer);
      const std::string& name = changer.changedName();
      if (name.empty()) break;
      if (sizes.contains(name)) continue;
      SCOPED_TRACE(name);
      EXPECT_FALSE(comparePacks(pack, source, {}).passes());
      EXPECT_TRUE(comparePacks(roundTrip(pack, {}), pack, {}).passes());
      tested.insert(name);
    }
  EXPECT_EQ(tested, (std::set<std::string>{"creaseAngle", "tangents", "blocks", "columns", "codes", "error",
                                           "storageRatio", "patchWidth", "factors", "basis", "heights",
                                           "repeats", "places"}));

  const Pack read = roundTrip(source, {.draco = true});
  const auto& mine = *read.transfer.as<PixelTransfer>();
  const auto& theirs = *source.transfer.as<PixelTransfer>();
  std::map<Float3, std::size_t> source_at;
  for (std::size_t v = 0; v < source.mesh.vertexCount(); ++v) source_at[source.mesh.positions[v]] = v;
  ASSERT_NE(read.mesh.positions, source.mesh.positions);
  for (std::size_t v = 0; v < read.mesh.vertexCount(); ++v) {
    const std::size_t before = source_at.at(read.mesh.positions[v]);
    EXPECT_EQ(mine.blocks[v], theirs.blocks[before]);
    EXPECT_EQ(mine.tangents[v], theirs.tangents[before]);
  }
  EXPECT_EQ(mine.columns.data, theirs.columns.data);
}

// Likewise, with sums; what their streams say is told by what is decoded, and a byte more or less of them by no more than a difference.
TEST(EveryFieldOfAPixelPack, OfSumsIsComparedWrittenAndRead) {
  Pack source = tests::madePixelPack(wavyGrid(4));
  source.mesh.texcoords.clear();
  auto& transfer = *source.transfer.as<PixelTransfer>();
  transfer = tests::compressed(transfer);
  transfer.changes = {0.25F, 0.25F, 0.125F};
  std::set<std::string> tested;
  for (std::size_t i = 0;; ++i) {
    Pack pack = source;
    FieldChanger changer(i);
    pack.transfer.describe(changer);
    const std::string& name = changer.changedName();
    if (name.empty()) break;
    SCOPED_TRACE(name);
    tested.insert(name);
    EXPECT_FALSE(comparePacks(pack, source, {}).passes());
    if (name.find("Side") != std::string::npos || name == "subsamples" || name == "blockCount") continue;
    if (std::find(kSumStreamKeys.begin(), kSumStreamKeys.end(), name) != kSumStreamKeys.end()) continue;
    EXPECT_TRUE(comparePacks(roundTrip(pack, {}), pack, {}).passes());
  }
  for (const char* stream : kSumStreamKeys) EXPECT_TRUE(tested.contains(stream)) << stream;
  for (const char* name : {"blockCount", "tolerance", "largestError", "rmsError", "blocks", "creaseAngle"})
    EXPECT_TRUE(tested.contains(name)) << name;
  const Pack read = roundTrip(source, {});
  const PixelSums& sums = read.transfer.as<PixelTransfer>()->sums.value();
  EXPECT_EQ(sums.grammar->terms, transfer.sums->grammar->terms);
  EXPECT_EQ(sums.grammar->row_places, transfer.sums->grammar->row_places);

  transfer.sums->streams[kTermSteps].data = transfer.sums->streams[kTermRanks].data;
  EXPECT_THROW(roundTrip(source, {}), Error);
}

TEST(EveryFieldOfAPixelPack, IsJudged) {
  const auto messageOf = [](const auto& spoil) -> std::string {
    Pack pack = tests::madePixelPack(wavyGrid(4));
    spoil(*pack.transfer.as<PixelTransfer>());
    try {
      encodePack(pack, {}, "file");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  const auto with = [](IntegerArray& array, std::size_t at, unsigned value) {
    Bytes bytes(array.data.begin(), array.data.end());
    bytes[at] = static_cast<std::byte>(value);
    array.data = std::move(bytes);
  };
  EXPECT_EQ(messageOf([](PixelTransfer&) {}), "");
  EXPECT_THAT(messageOf([&](PixelTransfer& t) { with(t.columns, 1, 255); }), HasSubstr("columns"));
  EXPECT_THAT(messageOf([&](PixelTransfer& t) { with(t.codes, 3, 0); }), HasSubstr("codes"));
  EXPECT_THAT(messageOf([&](PixelTransfer& t) { with(t.codes, 3, 5); }), HasSubstr("1 to 4"));
  EXPECT_THAT(messageOf([&](PixelTransfer& t) { with(t.row_lengths, 0, 77); }), HasSubstr("columns"));
  EXPECT_THAT(messageOf([&](PixelTransfer& t) { t.blocks[2] = 1000; }), HasSubstr("blocks"));
  EXPECT_THAT(messageOf([&](PixelTransfer& t) { t.crease_angle = -1; }), HasSubstr("creaseAngle"));
}

// Each row that belongs to a vertex stands where Draco has put the vertex, told by its position; the test
// permutes nothing itself.
TEST_P(EveryField, FollowsItsVertex) {
  forEachChange([](const Pack&, const Pack& changed) {
    const Pack read = roundTrip(changed, {.draco = true});
    ASSERT_NE(read.mesh.positions, changed.mesh.positions);
    const std::size_t count = changed.mesh.vertexCount();
    ASSERT_EQ(read.mesh.vertexCount(), count);
    std::map<Float3, std::size_t> source_at;
    for (std::size_t v = 0; v < count; ++v) source_at[changed.mesh.positions[v]] = v;
    std::vector<std::size_t> source_of;
    for (const Float3& position : read.mesh.positions) source_of.push_back(source_at.at(position));
    std::size_t followed = 0;
    for (const auto& [mine, theirs] :
         {std::pair(fieldsOf(read.transfer), fieldsOf(changed.transfer)),
          std::pair(fieldsOf(read.appearances[0].reflection), fieldsOf(changed.appearances[0].reflection))}) {
      ASSERT_EQ(mine.size(), theirs.size());
      for (std::size_t f = 0; f < mine.size(); ++f) {
        SCOPED_TRACE(mine[f].name);
        const bool has_vertex_rows = (mine[f].table != nullptr && mine[f].table->rows == count) ||
                                     (mine[f].plain.is_array() && mine[f].plain.size() == count) ||
                                     mine[f].name == "glossy.tangents";
        followed += has_vertex_rows ? 1 : 0;
        for (std::size_t v = 0; v < count; ++v) {
          const std::size_t source = has_vertex_rows ? source_of[v] : v;
          if (mine[f].table != nullptr && v < mine[f].table->rows) {
            ASSERT_EQ(rowOf(*mine[f].table, v), rowOf(*theirs[f].table, source));
          } else if (mine[f].name == "glossy.tangents") {
            for (std::size_t c = 0; c < 4; ++c)
              ASSERT_EQ(mine[f].values[4 * v + c], theirs[f].values[4 * source + c]);
          } else if (has_vertex_rows) {
            ASSERT_EQ(mine[f].plain[v], theirs[f].plain[source]);
          }
        }
        if (!has_vertex_rows) {
          EXPECT_EQ(mine[f].plain, theirs[f].plain);
          EXPECT_EQ(mine[f].values, theirs[f].values);
        }
      }
    }
    EXPECT_GE(followed, 4U);
  });
}

INSTANTIATE_TEST_SUITE_P(Pack, EveryField,
                         testing::Combine(testing::Values(Storage::kMatrix, Storage::kVisibility,
                                                          Storage::kCpca),
                                          testing::Values(Lobe::kPhong, Lobe::kGgx, Lobe::kTable)));

}  // namespace
}  // namespace bakelight::formats
