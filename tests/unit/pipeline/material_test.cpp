// Materials of an asset: how asset.json says them, and that each tool is handed what it looks at.
#include <nlohmann/json.hpp>

#include "workshop.h"

namespace bakelight::pipeline {
namespace {

using Json = nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Json port(const std::string& name, const std::string& kind, bool required = true) {
  return {{"name", name}, {"kind", kind}, {"required", required}, {"help", ""}};
}

// "transfer" looks at the albedo alone, "pack" at all of a material.
class MaterialTest : public testing::Test {
 protected:
  MaterialTest() {
    recipe_ = Json::parse(R"({
      "asset": { "mesh": { "kind": "mesh", "endings": [".obj"] },
                 "texture": { "kind": "image", "required": false, "endings": [] },
                 "material": { "kind": "material", "required": false, "endings": [] } },
      "stages": {
        "transfer": { "inputs": { "mesh": "asset.mesh", "texture": "asset.texture", "material": "asset.material" },
                      "outputs": { "transfer": "t.safetensors" } },
        "pack": { "inputs": { "transfer": "transfer.transfer", "material": "asset.material" },
                  "outputs": { "pack": "{asset}.glb" } }
      },
      "deliver": { "pack": "pack.pack" }
    })");
    install();
  }

  void install() {
    const auto keeping = [this](const char* output) {
      return [this, output](const auto& inputs, const Json&) {
        std::string made;
        for (const auto& [name, content] : inputs) made += name + ": " + content + "\n";
        const auto material = inputs.find("material");
        given_[output] = material == inputs.end() ? Json() : Json::parse(material->second);
        return std::map<std::string, std::string>{{output, made}};
      };
    };
    Json albedo_alone = port("material", "material", false);
    albedo_alone["parts"] = {"albedo"};
    workshop_.runner.install(
        "transfer", {{{"tool", "transfer"},
                      {"inputs", {port("mesh", "mesh"), port("texture", "image", false), albedo_alone}},
                      {"outputs", {port("transfer", "tensors")}},
                      {"parameters", Json::array()},
                      {"retired", {{{"name", "albedo"}, {"instead", "\"material\": { \"albedo\": ... }"}}}}},
                     keeping("transfer")});
    workshop_.runner.install("pack",
                             {{{"tool", "pack"},
                               {"inputs", {port("transfer", "tensors"), port("material", "material", false)}},
                               {"outputs", {port("pack", "pack")}},
                               {"parameters", Json::array()}},
                              keeping("pack")});
  }

  void asset(Json json) {
    json["mesh"] = "cube.obj";
    workshop_.disk.write("recipes/prt.json", recipe_.dump());
    workshop_.writeAssetFile("cube", json);
  }

  std::vector<std::string> rerun() {
    EXPECT_EQ(workshop_.run().exitStatus(), 0);
    return workshop_.toolsStarted();
  }

  Workshop workshop_;
  Json recipe_;
  std::map<std::string, Json> given_;  // by output: the file that the tool was handed
};

TEST_F(MaterialTest, EachToolIsHandedWhatItLooksAt) {
  const Json ggx = {{"model", "ggx"}, {"roughness", 0.25}};
  asset({{"material", {{"name", "glaze"}, {"albedo", {0.5, 0.25, 0.125}}, {"reflection", ggx}}}});
  EXPECT_THAT(rerun(), ElementsAre("transfer", "pack"));
  EXPECT_EQ(given_["transfer"], (Json{{"material", {{"albedo", {0.5, 0.25, 0.125}}}}}));
  EXPECT_EQ(given_["pack"]["material"]["name"], "glaze");
  EXPECT_EQ(given_["pack"]["material"]["reflection"]["roughness"], 0.25);
  EXPECT_EQ(given_["pack"]["material"]["reflection"]["fresnel"], false);

  EXPECT_THAT(rerun(), IsEmpty());
  asset({{"material",
          {{"albedo", {0.5, 0.25, 0.125}}, {"reflection", {{"model", "ggx"}, {"roughness", 0.5}}}}}});
  EXPECT_THAT(workshop_.explain()["pack"], HasSubstr("input material changed (assets/cube/asset.json)"));
  EXPECT_THAT(rerun(), ElementsAre("pack")) << "light bounces off the albedo alone";
  asset({{"material",
          {{"albedo", {0.5, 0.25, 0.25}}, {"reflection", {{"model", "ggx"}, {"roughness", 0.5}}}}}});
  EXPECT_THAT(rerun(), ElementsAre("transfer", "pack"));
}

TEST_F(MaterialTest, AFileIsTheSameAsItsContentInline) {
  const Json material = {{"albedo", {0.5, 0.25, 0.125}}};
  asset({{"material", material}, {"materials", {{"lid", {{"albedo", {1, 0, 0}}}}}}});
  rerun();
  workshop_.disk.write("assets/cube/clay.json", material.dump());
  workshop_.disk.write("assets/cube/red.json", R"({ "albedo": [1, 0, 0] })");
  asset({{"material", "clay.json"}, {"materials", {{"lid", "red.json"}}}});
  EXPECT_THAT(rerun(), IsEmpty());
  EXPECT_EQ(given_["transfer"]["materials"]["lid"]["albedo"], Json({1.0, 0.0, 0.0}));
}

TEST_F(MaterialTest, ATableCountsByItsContent) {
  workshop_.disk.write("assets/cube/cloth.safetensors", "warp");
  asset({{"material", {{"reflection", {{"model", "table"}, {"file", "cloth.safetensors"}}}}}});
  rerun();
  const std::string path = given_["pack"]["material"]["reflection"]["file"];
  EXPECT_TRUE(path.starts_with('/') && path.ends_with("assets/cube/cloth.safetensors")) << path;
  workshop_.disk.write("assets/cube/cloth.safetensors", "weft");
  EXPECT_THAT(rerun(), ElementsAre("pack"));
  workshop_.disk.rename("assets/cube/cloth.safetensors", "assets/cube/linen.safetensors");
  asset({{"material", {{"reflection", {{"model", "table"}, {"file", "linen.safetensors"}}}}}});
  EXPECT_THAT(rerun(), IsEmpty()) << "another name of the same";
}

TEST_F(MaterialTest, TheRecipeSaysTheRest) {
  recipe_["asset"]["material"]["default"] = {{"reflection", {{"model", "ggx"}, {"roughness", 0.4}}}};
  asset({{"material", {{"albedo", {0.5, 0.5, 0.5}}}}, {"materials", {{"lid", {{"albedo", {1, 0, 0}}}}}}});
  rerun();
  EXPECT_EQ(given_["pack"]["material"]["reflection"]["roughness"], 0.4);
  EXPECT_EQ(given_["pack"]["materials"]["lid"]["reflection"]["roughness"], 0.4);
  asset(Json::object());
  rerun();
  EXPECT_EQ(given_["pack"]["material"]["reflection"]["roughness"], 0.4);
  asset({{"material", {{"reflection", {{"model", "none"}}}}}});
  rerun();
  EXPECT_FALSE(given_["pack"]["material"].contains("reflection"));
}

TEST_F(MaterialTest, ATextureGoesWhereTexturesGo) {
  workshop_.disk.write("assets/cube/wood.png", "rings");
  asset({{"material", {{"albedo", "wood.png"}}}});
  EXPECT_EQ(workshop_.graph().tasks[0].inputs.at("texture").file, "assets/cube/wood.png");
  EXPECT_EQ(workshop_.graph().tasks[0].inputs.at("material").value, Json({{"material", Json::object()}}));
  asset({{"material", {{"albedo", "wood.png"}}}, {"texture", "wood.png"}});
  EXPECT_THAT(workshop_.problems(), ElementsAre(HasSubstr("/material")));
  asset({{"materials", {{"lid", {{"albedo", "wood.png"}}}}}});
  EXPECT_THAT(workshop_.problems(), ElementsAre(HasSubstr("/materials/lid")));
}

TEST_F(MaterialTest, MistakesAreToldWithTheirPlaces) {
  asset({{"material", {{"albedo", {0.5, 0.5, 1.5}}}}, {"materials", {{"lid", {{"reflexion", 1}}}}}});
  EXPECT_THAT(workshop_.problems(),
              ElementsAre(AllOf(HasSubstr("asset.json, at /material/albedo"), HasSubstr("from 0 to 1"))));
  asset({{"materials", {{"lid", {{"reflexion", 1}}}, {"foot", "nowhere.json"}}}});
  EXPECT_THAT(workshop_.problems(),
              ElementsAre(HasSubstr("there is no file assets/cube/nowhere.json"),
                          AllOf(HasSubstr("/materials/lid/reflexion"), HasSubstr("\"reflection\""))));
  asset({{"materiel", Json::object()}});
  EXPECT_THAT(workshop_.problems(), ElementsAre(HasSubstr("write \"material\"")));
  asset({{"stages", {{"transfer", {{"albedo", {1, 1, 1}}}}}}});
  EXPECT_THAT(workshop_.problems(), ElementsAre(AllOf(HasSubstr("asset.json, at /stages/transfer/albedo"),
                                                      HasSubstr("\"material\": { \"albedo\": ... }"))));
}

}  // namespace
}  // namespace bakelight::pipeline
