#include "formats/meso_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>
#include <string>

#include "formats/compare.h"
#include "formats/error.h"
#include "formats/file.h"
#include "formats/mesh_import.h"
#include "formats/mesh_ply.h"
#include "tests/unit/formats/test_meshes.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;

MesoMesh sample() {
  MesoMesh meso;
  meso.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, -0.0F}};
  meso.mesh.normals.assign(3, {0, 0, 1});
  meso.mesh.triangles = {{0, 1, 2}};
  meso.mesh.triangle_materials = {1};
  meso.mesh.material_names = {"red paint", "cloth"};
  meso.tangents = {{1, 0, 0}, {0, -1, 0}, {0.6F, 0.8F, 0}};
  meso.patch = {{0, 0.25F}, {0.999F, 0.5F}, {0.125F, 0}};
  meso.materials = {1, 0, 1};
  meso.symmetry = 4;
  return meso;
}

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(MesoMesh, RoundTripKeepsOrderAndBits) {
  const ScratchFolder folder;
  for (const bool with_colors : {false, true})
    for (const bool with_materials : {false, true}) {
      MesoMesh meso = sample();
      if (with_colors) meso.mesh.colors.assign(3, {0.1F, 0.2F, 0.3F});
      if (!with_materials) {
        meso.mesh.triangle_materials.clear(), meso.mesh.material_names.clear();
        meso.materials.assign(3, 0);
      }
      writeMesoMesh(folder / "a.ply", meso);
      const MesoMesh read = readMesoMesh(folder / "a.ply");
      EXPECT_EQ(read.mesh.positions, meso.mesh.positions);
      EXPECT_EQ(read.mesh.normals, meso.mesh.normals);
      EXPECT_EQ(read.mesh.colors, meso.mesh.colors);
      EXPECT_EQ(read.mesh.triangles, meso.mesh.triangles);
      EXPECT_EQ(read.mesh.triangle_materials, meso.mesh.triangle_materials);
      EXPECT_EQ(read.mesh.material_names, meso.mesh.material_names);
      EXPECT_EQ(read.tangents, meso.tangents);
      EXPECT_EQ(read.patch, meso.patch);
      EXPECT_EQ(read.materials, meso.materials);
      EXPECT_EQ(read.symmetry, 4);
    }
}

TEST(MesoMesh, IsAMeshToOthers) {
  const ScratchFolder folder;
  writeMesoMesh(folder / "a.ply", sample());
  EXPECT_EQ(readPly(folder / "a.ply").positions, sample().mesh.positions);
  EXPECT_EQ(importMesh(folder / "a.ply").mesh.triangles, sample().mesh.triangles);
}

TEST(MesoMesh, WhatIsWrongIsNamed) {
  const ScratchFolder folder;
  const auto errorWith = [&](const std::function<void(MesoMesh&)>& change) {
    MesoMesh meso = sample();
    change(meso);
    writeMesoMesh(folder / "a.ply", meso);
    return errorOf([&] { readMesoMesh(folder / "a.ply"); });
  };
  EXPECT_EQ(errorWith([](MesoMesh&) {}), "no error");
  EXPECT_THAT(errorWith([](MesoMesh& m) {
                m.tangents[1] = {0, 2, 0};
              }),
              AllOf(HasSubstr("vertex 1"), HasSubstr("unit length")));
  EXPECT_THAT(errorWith([](MesoMesh& m) { m.tangents[1] = {std::nanf(""), 0, 0}; }), HasSubstr("vertex 1"));
  EXPECT_THAT(errorWith([](MesoMesh& m) {
                m.tangents[2] = {0, 0.6F, 0.8F};
              }),
              AllOf(HasSubstr("vertex 2"), HasSubstr("perpendicular")));
  EXPECT_THAT(errorWith([](MesoMesh& m) { m.patch[2][1] = 1; }),
              AllOf(HasSubstr("vertex 2"), HasSubstr("exemplar")));
  EXPECT_THAT(errorWith([](MesoMesh& m) { m.materials[0] = 2; }),
              AllOf(HasSubstr("vertex 0"), HasSubstr("material 2")));

  writePly(folder / "plain.ply", sample().mesh);
  EXPECT_THAT(errorOf([&] { readMesoMesh(folder / "plain.ply"); }),
              AllOf(HasSubstr("no meso-mesh"), HasSubstr("tangent_x")));
  writeMesoMesh(folder / "a.ply", sample());
  Bytes bytes = readFile(folder / "a.ply");
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string other = text;
    other.replace(other.find(from), from.size(), to);
    writeFileAtomically(folder / "b.ply", std::string_view(other));
    return errorOf([&] { readMesoMesh(folder / "b.ply"); });
  };
  EXPECT_THAT(replaced("symmetry 4", "symmetry 3"), HasSubstr("symmetry is 3"));
  EXPECT_THAT(replaced("meso_mesh symmetry 4", "something"), HasSubstr("no comment says"));
  EXPECT_THAT(replaced("float patch_u", "float patch_w"), HasSubstr("no patch_u"));
  bytes.resize(bytes.size() - 5);
  writeFileAtomically(folder / "b.ply", bytes);
  EXPECT_THAT(errorOf([&] { readMesoMesh(folder / "b.ply"); }), HasSubstr("the file ends here"));
  MesoMesh uneven = sample();
  uneven.patch.pop_back();
  EXPECT_THROW(writeMesoMesh(folder / "c.ply", uneven), std::logic_error);
}

TEST(MesoMesh, ComparisonSeesEachOfItsParts) {
  const auto passes = [](const std::function<void(MesoMesh&)>& change) {
    MesoMesh meso = sample();
    change(meso);
    return compareMesoMeshes(meso, sample(), {}).passes();
  };
  EXPECT_TRUE(passes([](MesoMesh&) {}));
  EXPECT_FALSE(passes([](MesoMesh& m) { m.tangents[0] = {0, 1, 0}; }));
  EXPECT_FALSE(passes([](MesoMesh& m) { m.patch[1][0] = 0.5F; }));
  EXPECT_FALSE(passes([](MesoMesh& m) { m.materials[1] = 1; }));
  EXPECT_FALSE(passes([](MesoMesh& m) { m.symmetry = 1; }));
  EXPECT_FALSE(passes([](MesoMesh& m) { m.mesh.positions[1][0] = 2; }));
}

}  // namespace
}  // namespace bakelight::formats
