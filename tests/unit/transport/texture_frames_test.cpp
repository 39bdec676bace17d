#include "transport/texture_frames.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "transport/vector_types.h"

namespace bakelight::transport {
namespace {

// A square in the plane of x and z that faces up, u along `u` and v along `v`.
formats::TriangleMesh square(const Vec3& u, const Vec3& v) {
  formats::TriangleMesh mesh;
  for (const Vec3& corner : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 0, -1), Vec3(0, 0, -1)}) {
    mesh.positions.push_back(float3(corner));
    mesh.normals.push_back({0, 1, 0});
    mesh.texcoords.push_back({static_cast<float>(corner.dot(u)), static_cast<float>(corner.dot(v))});
  }
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TEST(TextureFrames, FollowTextureCoordinates) {
  const TextureFrames frames = textureFrames(square(Vec3(0, 0, -2), Vec3(-2, 0, 0)));
  EXPECT_EQ(frames.undetermined, 0U);
  EXPECT_EQ(frames.mirrored, 0U);
  for (const formats::Float4& tangent : frames.tangents) {
    EXPECT_NEAR(tangent[2], -1, 1e-6);
    EXPECT_EQ(tangent[3], 1);
    // normal × tangent runs along v.
    EXPECT_TRUE(Vec3(0, 1, 0).cross(Vec3(tangent[0], tangent[1], tangent[2])).isApprox(Vec3(-1, 0, 0), 1e-6));
  }
}

TEST(TextureFrames, MirroredOnesAreLeftHanded) {
  const TextureFrames frames = textureFrames(square(Vec3(-1, 0, 0), Vec3(0, 0, -1)));
  EXPECT_EQ(frames.mirrored, 4U);
  for (const formats::Float4& tangent : frames.tangents) {
    EXPECT_NEAR(tangent[0], -1, 1e-6);
    EXPECT_EQ(tangent[3], -1);
  }
}

TEST(TextureFrames, WithoutADirectionAnyTangent) {
  formats::TriangleMesh mesh = square(Vec3(1, 0, 0), Vec3(0, 0, -1));
  for (auto& texcoord : mesh.texcoords) texcoord = {0.5F, 0.5F};
  const TextureFrames frames = textureFrames(mesh);
  EXPECT_EQ(frames.undetermined, 4U);
  for (const formats::Float4& tangent : frames.tangents) {
    const Vec3 t(tangent[0], tangent[1], tangent[2]);
    EXPECT_NEAR(t.norm(), 1, 1e-6);
    EXPECT_NEAR(t.y(), 0, 1e-6);
  }
  mesh.texcoords.clear();
  EXPECT_THROW(textureFrames(mesh), std::invalid_argument);
}

TEST(TextureFrames, UnitOfTextureCoordinates) {
  EXPECT_NEAR(surfaceUnitOf(square(Vec3(4, 0, 0), Vec3(0, 0, -4))), 0.25, 1e-6);
  EXPECT_EQ(surfaceUnitOf(square(Vec3(1, 0, 0), Vec3(1, 0, 0))), 1);
}

}  // namespace
}  // namespace bakelight::transport
