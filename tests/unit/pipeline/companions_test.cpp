#include "pipeline/companions.h"

#include <gtest/gtest.h>

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
    "emitters": [{"shape": "mesh", "mesh": "lamp.gltf"}, {"shape": "sphere"}]})");
  disk.write("rigs/sky.exr", "blue");
  disk.write("rigs/lamp.gltf", R"({"buffers": [{"uri": "lamp.bin"}]})");
  disk.write("rigs/lamp.bin", "1");
  const std::string before = hashOf(disk, "rigs/room.json");
  EXPECT_EQ(hashOf(disk, "rigs/room.json"), before);
  std::string last = before;
  for (const char* companion : {"rigs/sky.exr", "rigs/lamp.bin"}) {
    disk.write(companion, "changed");
    const std::string after = hashOf(disk, "rigs/room.json");
    EXPECT_NE(after, last) << companion;
    last = after;
  }
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
