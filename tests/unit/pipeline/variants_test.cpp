#include "pipeline/variants.h"

#include <nlohmann/json.hpp>

#include "formats/error.h"

namespace bakelight::pipeline {
namespace {

using testing::ElementsAre;

std::vector<std::string> names(const std::vector<std::string>& vary) {
  std::vector<std::string> names;
  for (const Variant& variant : variantsOf(vary)) names.push_back(variant.name);
  return names;
}

TEST(Variants, AllCombinationsTheLastRunningFastest) {
  EXPECT_THAT(names({"transfer.order=2..3", "pack.precision=float32,uint8"}),
              ElementsAre("order=2,precision=float32", "order=2,precision=uint8", "order=3,precision=float32",
                          "order=3,precision=uint8"));
}

TEST(Variants, NothingVariedIsOneVariant) {
  ASSERT_THAT(names({}), ElementsAre("base"));
  EXPECT_TRUE(variantsOf({}).front().settings.empty());
}

TEST(Variants, AChoiceBringsFurtherSettings) {
  const auto variants = variantsOf({"transfer.storage=cpca,visibility+transfer.transport=shadowed"});
  ASSERT_EQ(variants.size(), 2u);
  EXPECT_EQ(variants[0].settings.size(), 1u);
  EXPECT_EQ(variants[1].name, "storage=visibility");
  EXPECT_EQ(parametersOf(variants[1]),
            formats::Json({{"transfer.storage", "visibility"}, {"transfer.transport", "shadowed"}}));
}

TEST(Variants, ListsAndNegativeRangesAreValues) {
  EXPECT_THAT(names({"a.x=[1,2],[3,4]"}), ElementsAre("x=[1,2]", "x=[3,4]"));
  EXPECT_THAT(names({"a.x=-1..1"}), ElementsAre("x=-1", "x=0", "x=1"));
  EXPECT_EQ(parametersOf(variantsOf({"a.x=[1,2]"}).front()), formats::Json({{"a.x", {1, 2}}}));
}

TEST(Variants, ParametersOfOneNameKeepTheirStages) {
  EXPECT_THAT(names({"a.x=1", "b.x=2"}), ElementsAre("a.x=1,b.x=2"));
}

TEST(Variants, WhatIsNoVariationIsAUsageError) {
  for (const std::vector<std::string>& vary :
       std::vector<std::vector<std::string>>{{"order=2..3"},
                                             {"transfer.order"},
                                             {"transfer.order="},
                                             {"transfer.order=5..2"},
                                             {"transfer.order=a..b"},
                                             {"transfer.order=1,1"},
                                             {"transfer.order=1", "transfer.order=2"},
                                             {"transfer.order=1+storage=x"},
                                             {"transfer.order=1..100000"}}) {
    try {
      variantsOf(vary);
      ADD_FAILURE() << "accepted " << vary.front();
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kUsage);
      EXPECT_TRUE(error.place().file.starts_with("--vary ")) << error.paragraph();
    }
  }
}

}  // namespace
}  // namespace bakelight::pipeline
