#include "formats/material.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/json.h"
#include "formats/tensors.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

Materials parsed(const std::string& text) {
  return materialsFromJson(parseJson(text, "m.json"), "m.json", "", relativeTo("/nowhere"));
}

std::string problemWith(const std::string& text) {
  try {
    parsed(text);
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "no error";
}

// Of files that nobody looks at.
Materials unresolved(const std::string& text) {
  return materialsFromJson(parseJson(text, "m.json"), "m.json", "",
                           [](const std::string& name, const ErrorPlace&) { return name; });
}
std::string unresolvedProblem(const std::string& text) {
  try {
    unresolved(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Material, SaysNothingWhereNothingIsSaid) {
  const Material material = parsed("{}").base;
  EXPECT_FALSE(material.albedo.has_value());
  EXPECT_TRUE(std::holds_alternative<Lambert>(material.reflection));
}

TEST(Material, HasWhatItsFileSays) {
  const Material material = parsed(R"({ "name": "glaze", "albedo": [0.35, 0.12, 0.06], // fired
    "reflection": { "model": "ggx", "specular_color": [0.1, 0.2, 0.3], "roughness": 0.45, "fresnel": true,
                    "multiple_scattering": true } })")
                                .base;
  EXPECT_EQ(material.name, "glaze");
  EXPECT_EQ(material.albedo, (Float3{0.35F, 0.12F, 0.06F}));
  EXPECT_EQ(std::get<GgxReflection>(material.reflection),
            (GgxReflection{{0.1F, 0.2F, 0.3F}, 0.45, true, true}));
  const Material phong = parsed(R"({ "reflection": { "model": "phong", "exponent": 7 } })").base;
  EXPECT_EQ(std::get<PhongReflection>(phong.reflection), (PhongReflection{{0.2F, 0.2F, 0.2F}, 7}));
}

TEST(Material, HasAPatch) {
  const FileResolver any = [](const std::string& name, const ErrorPlace&) { return "/there/" + name; };
  const auto patchOf = [&](const std::string& text) {
    return materialsFromJson(parseJson(text, "m.json"), "m.json", "", any).base.patch;
  };
  EXPECT_FALSE(patchOf("{}").has_value());
  EXPECT_EQ(patchOf(R"({ "patch": { "file": "w.png" } })"), (Patch{"/there/w.png", {}, true}));
  const std::string whole = R"({ "patch": { "file": "w.png", "width": 0.25, "periodic": false } })";
  EXPECT_EQ(patchOf(whole), (Patch{"/there/w.png", 0.25, false}));
  const Materials materials = materialsFromJson(parseJson(whole, "m.json"), "m.json", "", any);
  EXPECT_EQ(materialsFromJson(toJson(materials), "m.json", "",
                              [](const std::string& name, const ErrorPlace&) { return name; })
                .base.patch,
            materials.base.patch);
  EXPECT_FALSE(toJson(materials, {"albedo"}).at("material").contains("patch"));
  EXPECT_THAT(problemWith(R"({ "patch": { "width": 1 } })"), HasSubstr("file"));
  EXPECT_THAT(problemWith(R"({ "patch": { "file": "w.png" } })"), HasSubstr("/patch/file"));
}

TEST(Material, PatchMayBeASurface) {
  const Materials heights = unresolved(
      R"({ "patch": { "height": { "file": "h.png", "depth": 0.2 }, "texture": { "file": "t.png" } } })");
  const Patch& patch = *heights.base.patch;
  EXPECT_TRUE(patch.hasSurface());
  EXPECT_TRUE(patch.file.empty());
  EXPECT_EQ(patch.height, (PatchHeight{"h.png", 0.2}));
  EXPECT_EQ(patch.texture, "t.png");
  const Materials mesh = unresolved(
      R"({ "patch": { "geometry": { "file": "w.ply", "up": "y", "period": [2, 3] }, "albedo": [1, 0, 0.5] } })");
  EXPECT_EQ(mesh.base.patch->geometry, (PatchMesh{"w.ply", PatchMesh::Up::kY, std::array{2.0, 3.0}}));
  for (const Materials& each : {heights, mesh})
    EXPECT_EQ(unresolved(toJson(each).dump()).base.patch, each.base.patch);

  EXPECT_THAT(
      unresolvedProblem(R"({ "patch": { "geometry": { "file": "w.ply" }, "height": { "file": "h.png" } } })"),
      HasSubstr("/patch/geometry"));
  EXPECT_THAT(unresolvedProblem(R"({ "patch": { "geometry": { "file": "w.ply", "period": [0, 1] } } })"),
              HasSubstr("/patch/geometry/period/0"));
  EXPECT_THAT(unresolvedProblem(R"({ "patch": { "albedo": [1, 1, 1] } })"),
              HasSubstr("neither a picture nor a surface"));
  EXPECT_TRUE(unresolved(R"({ "patch": { "file": "w.png" } })").base.patch->hasSurface());  // a flat one
}

TEST(Material, MayBeTranslucent) {
  EXPECT_FALSE(parsed("{}").base.medium.has_value());
  const Medium marble = *parsed(R"({ "medium": { "name": "marble", "unit_mm": 25 } })").base.medium;
  EXPECT_EQ(marble, (Medium{{2.19F, 2.62F, 3.00F}, {.0021F, .0041F, .0071F}, 1.5, 25, {}}));
  const Medium own = *parsed(R"({ "medium": { "reduced_scattering": [1, 2, 3], "absorption": [0, 0, 0.5],
                                  "eta": 1, "model": "better_dipole" } })")
                          .base.medium;
  EXPECT_EQ(own, (Medium{{1, 2, 3}, {0, 0, 0.5F}, 1, 1, DiffusionModel::kBetterDipole}));
  for (const std::string& name : namesOfMedia())
    EXPECT_TRUE(parsed(R"({ "medium": { "name": ")" + name + R"(" } })").base.medium.has_value());
  EXPECT_EQ(
      translucentMaterials(parsed(R"({ "materials": { "a": { "medium": { "name": "cream" } }, "b": {} } })")),
      std::vector<std::string>{"a"});
  EXPECT_THAT(problemWith(R"({ "medium": { "name": "marbel" } })"),
              AllOf(HasSubstr("/medium/name"), HasSubstr("marble")));
  EXPECT_EQ(
      *parsed(
           R"({ "medium": { "name": "cream", "veins": { "name": "apple", "spacing": 3, "width": 0.5, "seed": 7 } } })")
           .base.medium->veins,
      (Veins{{2.29F, 2.39F, 1.97F}, {.0030F, .0034F, .046F}, 3, 0.5, 7}));
  EXPECT_THAT(
      problemWith(
          R"({ "medium": { "name": "cream", "veins": { "name": "apple", "spacing": 3, "width": 3 } } })"),
      HasSubstr("/medium/veins/width"));
  EXPECT_THAT(problemWith(R"({ "medium": { "name": "cream", "veins": { "name": "apple", "width": 3 } } })"),
              HasSubstr("spacing"));
  EXPECT_THAT(problemWith(R"({ "medium": {} })"), HasSubstr("1/mm"));
  EXPECT_THAT(problemWith(R"({ "medium": { "name": "cream", "absorption": [1, 1, 1] } })"),
              HasSubstr("/medium/absorption"));
  EXPECT_THAT(problemWith(R"({ "medium": { "reduced_scattering": [0, 1, 1], "absorption": [0, 0, 0] } })"),
              HasSubstr("/medium/reduced_scattering"));
}

TEST(Material, MediumMayReflectTheAlbedo) {
  const Materials painted =
      parsed(R"({ "albedo": [0.2, 0.4, 0.6], "medium": { "name": "marble", "reflectance": "albedo" } })");
  EXPECT_EQ(painted.base.medium->reflectance, ReflectanceSource::kAlbedo);
  EXPECT_THAT(problemWith(R"({ "medium": { "name": "marble", "reflectance": "mesh" } })"),
              AllOf(HasSubstr("/medium/reflectance"), HasSubstr("albedo")));
  EXPECT_THAT(problemWith(R"({ "medium": { "name": "cream", "reflectance": "albedo",
                       "veins": { "name": "apple", "spacing": 3, "width": 0.5 } } })"),
              AllOf(HasSubstr("/medium/reflectance"), HasSubstr("veins")));
  // What bakes the medium is baked anew for another albedo then, and only then.
  EXPECT_TRUE(toJson(painted, {"medium"})["material"].contains("albedo"));
  const Materials stained = parsed(R"({ "albedo": [0.2, 0.4, 0.6], "medium": { "name": "marble" } })");
  EXPECT_FALSE(toJson(stained, {"medium"})["material"].contains("albedo"));

  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {}, {}, {{0, 1, 2}, {1, 3, 2}}};
  const SurfaceMaterials one = materialsOn(mesh, painted, "m.ply", "m.json");
  EXPECT_EQ(one.medium_reflectance, std::vector<Float3>(4, {0.2F, 0.4F, 0.6F}));
  EXPECT_EQ(one.albedo, (Float3{1, 1, 1})) << "no stain besides";
  EXPECT_TRUE(one.vertex_albedo.empty());
  EXPECT_TRUE(materialsOn(mesh, stained, "m.ply", "m.json").medium_reflectance.empty());

  Materials by_mesh = painted;
  by_mesh.base.albedo.reset();
  EXPECT_THROW(materialsOn(mesh, by_mesh, "m.ply", "m.json"), Error);
  mesh.colors = {{0, 0, 0}, {0.1F, 0.2F, 0.3F}, {1, 1, 1}, {0.5F, 0.5F, 0.5F}};
  EXPECT_EQ(materialsOn(mesh, by_mesh, "m.ply", "m.json").medium_reflectance, mesh.colors);
  mesh.colors[2][0] = std::numeric_limits<float>::infinity();
  EXPECT_THROW(materialsOn(mesh, by_mesh, "m.ply", "m.json"), Error);
}

// Beside a material that is stained: each vertex has the one or the other.
TEST(Material, MediaThatReflectAndStainsGoTogether) {
  TriangleMesh mesh{
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {3, 0, 0}, {2, 1, 0}}, {}, {}, {{0, 1, 2}, {3, 4, 5}}};
  mesh.triangle_materials = {0, 1};
  mesh.material_names = {"candy", "wood"};
  const SurfaceMaterials surface =
      materialsOn(mesh, parsed(R"({ "materials": { "wood": { "albedo": [0.3, 0.2, 0.1] },
                  "candy": { "albedo": [0.9, 0.1, 0.1], "medium": { "name": "marble", "reflectance": "albedo" } } } })"),
                  "m.ply", "m.json");
  EXPECT_EQ(surface.medium_reflectance[0], (Float3{0.9F, 0.1F, 0.1F}));
  EXPECT_EQ(surface.vertex_albedo[0], (Float3{1, 1, 1}));
  EXPECT_EQ(surface.medium_reflectance[3], (Float3{1, 1, 1}));
  EXPECT_EQ(surface.vertex_albedo[3], (Float3{0.3F, 0.2F, 0.1F}));
}

TEST(Material, PatchMayBeMeasured) {
  const Materials measured = unresolved(R"({ "patch": { "btf": { "file": "wool.btf" }, "width": 0.5 } })");
  const Patch& patch = *measured.base.patch;
  EXPECT_EQ(patch.btf, "wool.btf");
  EXPECT_EQ(patch.width, 0.5);
  EXPECT_FALSE(patch.hasSurface());
  EXPECT_EQ(unresolved(toJson(measured).dump()).base.patch, measured.base.patch);
  EXPECT_THAT(
      unresolvedProblem(R"({ "patch": { "btf": { "file": "w.btf" }, "height": { "file": "h.png" } } })"),
      HasSubstr("/patch/"));
  EXPECT_THAT(unresolvedProblem(R"({ "patch": { "btf": { "file": "w.btf" }, "rtt": { "file": "r.exr" } } })"),
              HasSubstr("/patch/"));
  EXPECT_THAT(unresolvedProblem(R"({ "patch": { "btf": {} } })"), HasSubstr("/patch/btf"));
}

TEST(Material, OfSomeFacesHasAName) {
  const Materials materials =
      parsed(R"({ "material": { "albedo": [1, 1, 1] }, "materials": { "lid": { "albedo": [0, 0, 1] } } })");
  EXPECT_EQ(materials.of("lid").albedo, (Float3{0, 0, 1}));
  EXPECT_EQ(materials.of("pot").albedo, (Float3{1, 1, 1}));
}

TEST(Material, ComesBackFromJsonAsItWas) {
  for (
      const char* text :
      {"{}", R"({ "albedo": [0.35, 0.12, 0.06] })",
       R"({ "name": "a", "reflection": { "model": "ggx", "roughness": 0.123, "fresnel": true } })",
       R"({ "reflection": { "model": "phong", "exponent": 12.5, "specular_color": [0.1, 0.2, 0.3] } })",
       R"({ "medium": { "name": "skin1", "unit_mm": 3.5, "model": "normalized_diffusion" } })",
       R"({ "medium": { "name": "marble", "veins": { "name": "ketchup", "spacing": 0.5, "width": 0.1, "seed": 4 } } })",
       R"({ "material": {}, "materials": { "a/b": { "albedo": [0, 0, 0.7] } } })"}) {
    const Materials before = parsed(text);
    const Json json = toJson(before);
    EXPECT_EQ(toJson(parsed(json.dump())), json) << text;
    EXPECT_EQ(parsed(json.dump()).base.reflection, before.base.reflection);
    EXPECT_EQ(parsed(json.dump()).base.albedo, before.base.albedo) << "to the bit";
    EXPECT_EQ(parsed(json.dump()).base.medium, before.base.medium);
  }
  const Materials two = parsed(R"({ "materials": { "a": { "name": "x", "albedo": [0, 0, 1],
                                                          "reflection": { "model": "ggx" } } } })");
  EXPECT_EQ(toJson(two, {"albedo"}),
            Json::parse(R"({ "material": {}, "materials": { "a": { "albedo": [0.0, 0.0, 1.0] } } })"));
}

TEST(Material, MistakesAreToldWithTheirPlaces) {
  EXPECT_THAT(problemWith(R"({ "albdo": [1, 1, 1] })"),
              AllOf(HasSubstr("m.json, at /albdo"), HasSubstr("\"albedo\"")));
  EXPECT_THAT(problemWith(R"({ "albedo": [1, 1, 2] })"),
              AllOf(HasSubstr("/albedo"), HasSubstr("from 0 to 1")));
  EXPECT_THAT(problemWith(R"({ "albedo": 0.5 })"), AllOf(HasSubstr("/albedo"), HasSubstr("three numbers")));
  EXPECT_THAT(problemWith(R"({ "albedo": "wood.png" })"), AllOf(HasSubstr("/albedo"), HasSubstr("no file")));
  EXPECT_THAT(problemWith(R"({ "reflection": { "roughness": 1 } })"), HasSubstr("\"model\" is missing"));
  EXPECT_THAT(problemWith(R"({ "reflection": { "model": "gx" } })"), HasSubstr("/reflection/model"));
  EXPECT_THAT(problemWith(R"({ "reflection": { "model": "ggx", "exponent": 3 } })"),
              HasSubstr("/reflection/exponent"));
  EXPECT_THAT(problemWith(R"({ "reflection": { "model": "phong", "exponent": -1 } })"),
              HasSubstr("0 to 100000"));
  EXPECT_THAT(problemWith(R"({ "reflection": { "model": "table" } })"), HasSubstr("\"file\" is missing"));
  EXPECT_THAT(problemWith(R"({ "materials": { "lid": { "albedo": [1, 1, -1] } } })"),
              HasSubstr("/materials/lid/albedo"));
  EXPECT_THAT(problemWith(R"({ "materials": { }, "material": { }, "mesh": "a.obj" })"), HasSubstr("/mesh"));
  EXPECT_THAT(problemWith(R"([])"), HasSubstr("JSON object"));
}

TEST(Material, ReadsItsTable) {
  const tests::TemporaryFolder folder;
  TensorFile file;
  file.metadata = {{"order", "2"}, {"basis", "real_sh_cartesian"}, {"frame", "local"}, {"cosine", "inside"}};
  const std::vector<float> values(3 * 3 * 4, 0.25F);
  file.tensors["brdf"] = Tensor::from<float>(ElementType::kFloat32, {3, 3, 4}, values);
  writeSafetensors(folder / "cloth.safetensors", file);
  writeFileAtomically(folder / "cloth.json",
                      std::string(R"({ "reflection": { "model": "table", "file": "cloth.safetensors" } })"));
  const Materials materials = readMaterials(folder / "cloth.json");
  const auto& table = std::get<TableReflection>(materials.base.reflection).table;
  EXPECT_EQ(table.angles, 3);
  EXPECT_EQ(table.order, 2);
  EXPECT_EQ(table.values, values);
  EXPECT_STREQ(runtimeLobe(materials.base.reflection).kind(), "table");
  for (const char* key : {"order", "basis", "frame", "cosine"}) {
    TensorFile spoiled = file;
    spoiled.metadata[key] = "other";
    EXPECT_THROW(brdfTableFrom(spoiled, "b"), Error) << key;
  }
  file.tensors["brdf"].shape = {3, 4, 3};
  EXPECT_THROW(brdfTableFrom(file, "b"), Error);
}

// Two triangles of materials "a" and "b" that share no vertex, or two.
TriangleMesh twoMaterials(bool shared) {
  TriangleMesh mesh;
  mesh.positions.resize(shared ? 4 : 6);
  mesh.triangles = {{0, 1, 2}, shared ? Triangle{1, 2, 3} : Triangle{3, 4, 5}};
  mesh.triangle_materials = {0, 1};
  mesh.material_names = {"a", "b"};
  return mesh;
}

TEST(SurfaceMaterials, HaveTheAlbedoOfEachFace) {
  const Materials materials = parsed(R"({ "material": { "albedo": [1, 1, 1] },
    "materials": { "b": { "albedo": [0, 0, 1], "reflection": { "model": "ggx" } } } })");
  const SurfaceMaterials surface = materialsOn(twoMaterials(false), materials, "m.ply", "m.json");
  EXPECT_EQ(surface.vertex_albedo[2], (Float3{1, 1, 1}));
  EXPECT_EQ(surface.vertex_albedo[3], (Float3{0, 0, 1}));
  EXPECT_THAT(surface.of_triangle, ElementsAre(0, 1));
  EXPECT_TRUE(std::holds_alternative<Lambert>(surface.reflections[0]));
  EXPECT_TRUE(std::holds_alternative<GgxReflection>(surface.reflections[1]));
  EXPECT_EQ(surface.only(), nullptr);
}

TEST(SurfaceMaterials, ColorsOfTheMeshAreTheAlbedoWhereNoneIsGiven) {
  TriangleMesh mesh = twoMaterials(false);
  mesh.colors.assign(6, {0.5F, 0.25F, 0.125F});
  EXPECT_EQ(materialsOn(mesh, {}, "", "").vertex_albedo, mesh.colors);
  const SurfaceMaterials white = materialsOn(mesh, parsed(R"({ "albedo": [1, 1, 1] })"), "", "");
  EXPECT_TRUE(white.vertex_albedo.empty());
  EXPECT_EQ(white.albedo, (Float3{1, 1, 1}));
  EXPECT_TRUE(white.replaces_colors);
  const SurfaceMaterials one =
      materialsOn(mesh, parsed(R"({ "materials": { "a": { "albedo": [1, 1, 1] } } })"), "", "");
  EXPECT_EQ(one.vertex_albedo[0], (Float3{1, 1, 1}));
  EXPECT_EQ(one.vertex_albedo[3], mesh.colors[3]);
  mesh.colors.clear();
  EXPECT_EQ(materialsOn(mesh, {}, "", "").albedo, kDefaultAlbedo);
}

TEST(SurfaceMaterials, WhatCannotBeRightIsRefused) {
  const auto problem = [](const TriangleMesh& mesh, const std::string& text) -> std::string {
    try {
      materialsOn(mesh, parsed(text), "m.ply", "m.json");
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  const char* blue = R"({ "materials": { "b": { "albedo": [0, 0, 1] } } })";
  EXPECT_THAT(problem(twoMaterials(true), blue), AllOf(HasSubstr("m.ply, vertex 1"), HasSubstr("simplify")));
  EXPECT_EQ(problem(twoMaterials(false), blue), "no error");
  EXPECT_EQ(problem(twoMaterials(true), R"({ "materials": { "b": { "albedo": [0.8, 0.8, 0.8] } } })"),
            "no error");
  EXPECT_THAT(problem(twoMaterials(false), R"({ "materials": { "bb": {} } })"),
              AllOf(HasSubstr("m.json, at /materials/bb"), HasSubstr("write \"b\"")));
  TriangleMesh plain = twoMaterials(false);
  plain.triangle_materials.clear(), plain.material_names.clear();
  EXPECT_THAT(problem(plain, blue), HasSubstr("a mesh that gives its faces materials"));
  Materials textured;
  textured.base.texture = "wood.png";
  EXPECT_THROW(materialsOn(plain, textured, "", ""), Error);
}

}  // namespace
}  // namespace bakelight::formats
