#include "pipeline/companions.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "tests/unit/pipeline/fakes.h"

namespace bakelight::pipeline {
namespace {

// Hashes with a memo of its own, so that nothing is remembered.
std::string hashOf(FakeDisk& disk, const char* path) {
  Memo memo("memo.json", disk);
  return hashWithCompanions(path, disk, memo);
}

TEST(Companions, ImagesAndMeshesOfALightRigBelongToItsContent) {
  FakeDisk disk;
  disk.write("rigs/room.json", R"({
    // comments are allowed in rigs
    "lights": [{"type": "environment", "image": "sky.exr"}, {"type": "sky"}],
    "emitters": [{"shape": "mesh", "mesh": "lamp.gltf"}, {"shape": "sphere"}],
    "punctual": [{"type": "slide", "image": "slide.png"}, {"type": "point"}]})");
  disk.write("rigs/sky.exr", "blue");
  disk.write("rigs/slide.png", "squares");
  disk.write("rigs/lamp.gltf", R"({"buffers": [{"uri": "lamp.bin"}]})");
  disk.write("rigs/lamp.bin", "1");
  const std::string before = hashOf(disk, "rigs/room.json");
  EXPECT_EQ(hashOf(disk, "rigs/room.json"), before);
  std::string last = before;
  for (const char* companion : {"rigs/sky.exr", "rigs/lamp.bin", "rigs/slide.png"}) {
    disk.write(companion, "changed");
    const std::string after = hashOf(disk, "rigs/room.json");
    EXPECT_NE(after, last) << companion;
    last = after;
  }
}

// Each of `companions` counts, and none of `others`.
void expectCounted(FakeDisk& disk, const char* path, const std::vector<const char*>& companions,
                   const std::vector<const char*>& others) {
  std::string last = hashOf(disk, path);
  EXPECT_EQ(hashOf(disk, path), last);
  for (const char* companion : companions) {
    disk.write(companion, disk.isFile(companion) ? disk.read(companion) + " " : "new");
    const std::string after = hashOf(disk, path);
    EXPECT_NE(after, last) << companion;
    last = after;
  }
  for (const char* other : others) {
    disk.write(other, "changed");
    EXPECT_EQ(hashOf(disk, path), last) << other;
  }
}

TEST(Companions, LibrariesOfAPatchsMeshBelongToItsMaterial) {
  FakeDisk disk;
  const formats::Json material = {{"material", {{"patch", {{"geometry", {{"file", "weave.obj"}}}}}}}};
  const auto hash = [&] {
    Memo memo("memo.json", disk);
    return hashWithNamedFiles(material, disk, memo);
  };
  disk.write("weave.obj", "mtllib yarn.mtl\nusemtl a\n");
  disk.write("yarn.mtl", "newmtl a\nKd 1 0 0\nmap_Kd wool.png\n");
  std::set<std::string> hashes = {hash()};
  EXPECT_EQ(hash(), *hashes.begin());
  for (const char* changed : {"weave.obj", "yarn.mtl", "wool.png"}) {
    disk.write(changed, disk.isFile(changed) ? disk.read(changed) + " " : "new");
    EXPECT_TRUE(hashes.insert(hash()).second) << changed;
  }
}

TEST(Companions, LibrariesOfAnObjAndTheirTexturesBelongToIt) {
  FakeDisk disk;
  disk.write("models/A.OBJ", "v 0 0 0\r\nmtllib my colours.mtl\r\nmtllib none.mtl\r\nusemtl a\r\n");
  disk.write("models/My Colours.mtl", "newmtl a\nmap_Kd -s 2 2 maps\\wood.png\nmap_Ks gloss.png\n");
  disk.write("models/maps/wood.png", "brown");
  expectCounted(disk, "models/A.OBJ", {"models/My Colours.mtl", "models/maps/wood.png", "models/none.mtl"},
                {"models/gloss.png", "models/other.mtl"});
}

TEST(Companions, TexturesOfAPlyBelongToIt) {
  FakeDisk disk;
  disk.write("models/a.ply", "ply\nformat ascii 1.0\ncomment TextureFile a b.png\nend_header\n");
  disk.write("models/a b.png", "blue");
  expectCounted(disk, "models/a.ply", {"models/a b.png"}, {"models/c.png"});
}

TEST(Companions, PicturesOfOtherFormatsBelongToTheMesh) {
  FakeDisk disk;
  disk.write("models/a.dae", "<image><init_from>maps/my%20wood.PNG</init_from></image> 1.5 2.0");
  disk.write("models/maps/my wood.PNG", "brown");
  expectCounted(disk, "models/a.dae", {"models/maps/my wood.PNG"}, {"models/c.png"});
  disk.write("models/b.fbx", std::string("Kaydara\0\x1AS\x0C\0\0\0C:\\x\\b1.tgaS", 26));
  disk.write("models/b1.tga", "red");
  expectCounted(disk, "models/b.fbx", {"models/b1.tga"}, {"models/c.png"});
  disk.write("models/c.3ds", std::string("\0\xA3\x0E\0\0\0T1.JPG\0", 13));
  disk.write("models/T1.JPG", "green");
  expectCounted(disk, "models/c.3ds", {"models/T1.JPG"}, {"models/c.png"});
}

// With what the driver remembers between its runs.
TEST(Companions, AFileThatFitsANameBetterIsSeen) {
  FakeDisk disk;
  Memo memo("memo.json", disk);
  disk.write("models/a.ply", "ply\nformat ascii 1.0\ncomment TextureFile maps/tex.png\nend_header\n");
  const auto next = [&](const char* file) {
    const std::string before = hashWithCompanions("models/a.ply", disk, memo);
    EXPECT_EQ(hashWithCompanions("models/a.ply", disk, memo), before);
    disk.write(file, std::string("of ") + file);
    return hashWithCompanions("models/a.ply", disk, memo) != before;
  };
  EXPECT_FALSE(next("models/other.png"));
  EXPECT_TRUE(next("models/TEX.png")) << "by its last part";
  EXPECT_TRUE(next("models/maps/Tex.PNG")) << "in other capitals";
  EXPECT_TRUE(next("models/maps/TEX.png")) << "the first in order";
  EXPECT_TRUE(next("models/maps/tex.png")) << "by its very name";
  EXPECT_FALSE(next("models/maps/TEx.png"));
  disk.removeAll("models/maps/tex.png");
  const std::string without = hashWithCompanions("models/a.ply", disk, memo);
  Memo fresh("fresh.json", disk);
  EXPECT_EQ(without, hashWithCompanions("models/a.ply", disk, fresh));
  const int reads = disk.reads;
  hashWithCompanions("models/a.ply", disk, memo);
  EXPECT_EQ(disk.reads, reads) << "remembered";
}

TEST(Companions, EscapedNamesOfAGltfAreUnderstood) {
  FakeDisk disk;
  disk.write("models/a.GLTF",
             R"({"buffers": [{"uri": "my%20data.bin"}, {"uri": "data:,x"}], "images": [{"uri": "b.png"}]})");
  disk.write("models/my data.bin", "1");
  disk.write("models/b.png", "blue");
  expectCounted(disk, "models/a.GLTF", {"models/my data.bin", "models/b.png"}, {"models/c.bin"});
}

TEST(Companions, AFileThatNamesNoneIsItself) {
  FakeDisk disk;
  disk.write("a.json", R"({"lights": [{"type": "sky"}]})");
  disk.write("b.json", "no JSON at all");
  disk.write("c.gltf", R"({"buffers": [{"uri": "c.gltf"}]})");  // refers to itself: still an answer
  Memo memo("memo.json", disk);
  EXPECT_EQ(hashWithCompanions("a.json", disk, memo), memo.hashOf("a.json"));
  EXPECT_EQ(hashWithCompanions("b.json", disk, memo), memo.hashOf("b.json"));
  EXPECT_NE(hashWithCompanions("c.gltf", disk, memo), "");
}

}  // namespace
}  // namespace bakelight::pipeline
