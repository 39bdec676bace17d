// 3DS files: their axes, transforms, materials by face, texture coordinates.

#include <gmock/gmock.h>

#include "tests/unit/formats/dialects.h"
#include "tests/unit/formats/painted_bracket.h"

namespace bakelight::formats {
namespace {

using testing::Contains;
using testing::HasSubstr;

class Files3ds : public DialectTest {
 protected:
  Files3ds() : DialectTest(".3ds") {}
};

// The chunk's length counts its head of 6 bytes.
std::string chunk(std::uint16_t id, const std::string& content) {
  std::string bytes;
  append(bytes, id);
  append(bytes, static_cast<std::uint32_t>(content.size() + 6));
  return bytes + content;
}

template <class... Values>
std::string bytesOf(const Values&... values) {
  std::string bytes;
  (append(bytes, values), ...);
  return bytes;
}

std::string named(const std::string& name) {
  return name + '\0';
}

std::string material(std::size_t paint, bool by_bytes, const std::string& picture = "") {
  const Float3& c = kPaints[paint];
  const auto code = [](float value) { return static_cast<std::uint8_t>(value * 255); };
  const std::string color =
      by_bytes ? chunk(0x0011, bytesOf(code(c[0]), code(c[1]), code(c[2]))) : chunk(0x0010, bytesOf(c));
  return chunk(0xAFFF, chunk(0xA000, named(kPaintNames[paint])) + chunk(0xA020, color) +
                           (picture.empty() ? ""
                                            : chunk(0xA200, chunk(0x0030, bytesOf(std::uint16_t{100})) +
                                                                chunk(0xA300, named(picture)))));
}

struct Body {
  Float3 (*placed)(const Float3&) = [](const Float3& p) { return p; };  // in the file
  std::string materials = {};
  bool painted = false, textured = false;
  std::string scene = {};   // chunks before the body
  std::string tracks = {};  // of keyframes: chunks
  std::string matrix = {};  // of the body's own frame: a chunk
};

std::string facesOf(const Body& body) {
  const TriangleMesh mesh = bracket();
  std::string faces = bytesOf(std::uint16_t{20});
  std::array<std::string, 2> painted;
  for (std::size_t t = 0; t < 20; ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) append(faces, static_cast<std::uint16_t>(v));
    append(faces, std::uint16_t{7});  // all edges are visible
    append(painted[paintOf(t)], static_cast<std::uint16_t>(t));
  }
  for (std::size_t m = 0; body.painted && m < 2; ++m)
    faces += chunk(0x4130, named(kPaintNames[m]) +
                               bytesOf(static_cast<std::uint16_t>(painted[m].size() / 2)) + painted[m]);
  return chunk(0x4120, faces);
}

std::string file3ds(const Body& body = {}) {
  std::string vertices = bytesOf(std::uint16_t{12}), texcoords = vertices;
  for (const Float3& p : bracket().positions) {
    append(vertices, body.placed(p));
    append(texcoords, texcoordAt(p));
  }
  const std::string mesh =
      chunk(0x4110, vertices) + (body.textured ? chunk(0x4140, texcoords) : "") + body.matrix + facesOf(body);
  return chunk(0x4D4D,
               chunk(0x0002, bytesOf(std::uint32_t{3})) +
                   chunk(0x3D3D, chunk(0x3D3E, bytesOf(std::uint32_t{3})) + body.materials + body.scene +
                                     chunk(0x4000, named("body") + chunk(0x4100, mesh))) +
                   (body.tracks.empty() ? "" : chunk(0xB000, body.tracks)));
}

Float3 upright(const Float3& p) {
  return {p[0], p[2], -p[1]};
}

TEST_F(Files3ds, AreTurnedUpright) {
  const MeshImport read = import(file3ds());
  expectMovedBracket(read.mesh, upright, 1, "3DS");
  EXPECT_THAT(read.notes, Contains(HasSubstr("+Z up: turned to +Y up")));
}

// Vertices stand where the body does; its own frame is of no matter.
TEST_F(Files3ds, AFrameOfItsOwnMovesNothing) {
  const Body body{
      .matrix = chunk(0x4160, bytesOf(Float3{0, 1, 0}, Float3{-1, 0, 0}, Float3{0, 0, 1}, Float3{5, 6, 7}))};
  expectMovedBracket(import(file3ds(body)).mesh, upright, 1, "frame");
}

// A keyframe's track of three numbers: one key, at frame 0.
std::string track(std::uint16_t id, const Float3& value) {
  return chunk(id,
               std::string(10, '\0') + bytesOf(std::uint32_t{1}, std::uint32_t{0}, std::uint16_t{0}, value));
}

std::string bodyTracks(const std::string& tracks) {
  return chunk(0xB002, chunk(0xB030, bytesOf(std::uint16_t{0})) +
                           chunk(0xB010, named("body") + bytesOf(std::uint32_t{0}, std::uint16_t{0xFFFF})) +
                           tracks);
}

TEST_F(Files3ds, KeyframesPlaceTheBodyAtFrame0) {
  const auto moved = [](const Float3& p) { return upright({p[0] + 5, p[1] + 6, p[2] + 7}); };
  expectMovedBracket(import(file3ds({.tracks = bodyTracks(track(0xB020, {5, 6, 7}))})).mesh, moved, 1,
                     "position");
  // The pivot comes to lie at the position.
  expectMovedBracket(import(file3ds({.tracks = bodyTracks(chunk(0xB013, bytesOf(Float3{1, 2, 3})) +
                                                          track(0xB020, {6, 8, 10}))}))
                         .mesh,
                     moved, 1, "pivot");
  expectMovedBracket(
      import(file3ds({.tracks = bodyTracks(track(0xB020, {5, 6, 7}) + track(0xB022, {2, 2, 2}))})).mesh,
      [](const Float3& p) {
        return upright({2 * p[0] + 5, 2 * p[1] + 6, 2 * p[2] + 7});
      },
      2, "scale");
}

TEST_F(Files3ds, AMasterScaleIsAppliedAndNoted) {
  for (const float scale : {2.0F, 0.1F}) {
    const MeshImport read = import(file3ds({.scene = chunk(0x0100, bytesOf(scale))}));
    const auto scaled = [&](const Float3& p) { return upright({p[0] / scale, p[1] / scale, p[2] / scale}); };
    expectMovedBracket(read.mesh, scaled, 1 / scale, "scale");
    EXPECT_THAT(read.notes, Contains(HasSubstr(scale == 2 ? "multiplied by 0.5" : "multiplied by 10")));
  }
  EXPECT_EQ(import(file3ds({.scene = chunk(0x0100, bytesOf(1.0F))})).notes, import(file3ds()).notes);
}

TEST_F(Files3ds, MaterialsByFace) {
  for (const bool by_bytes : {false, true}) {
    const MeshImport read =
        import(file3ds({.materials = material(0, by_bytes) + material(1, by_bytes), .painted = true}));
    expectMovedBracket(read.mesh, upright, 1, "materials");
    if (!by_bytes) expectPaints(read, "materials");
    ASSERT_EQ(read.mesh.triangle_materials.size(), 20U);
    for (std::size_t t = 0; t < 20; ++t) {
      EXPECT_EQ(read.mesh.material_names.at(read.mesh.triangle_materials[t]), kPaintNames[paintOf(t)]) << t;
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(read.mesh.colors.at(read.mesh.triangles[t][0])[c], kPaints[paintOf(t)][c], 1 / 255.0);
    }
  }
}

TEST_F(Files3ds, PicturesOfMaterials) {
  write("wood.png", "no picture, only its name counts here");
  const MeshImport read = import(file3ds(
      {.materials = material(0, true, "WOOD.PNG") + material(1, true), .painted = true, .textured = true}));
  ASSERT_EQ(read.textures.size(), 1U);
  EXPECT_EQ(read.textures[0].path, folder_ / "wood.png");
  EXPECT_THAT(read.notes, Contains(HasSubstr("'WOOD.PNG' is taken to mean wood.png")));
  ASSERT_EQ(read.mesh.triangle_materials.size(), 20U);
  for (std::size_t t = 0; t < 20; ++t)
    EXPECT_EQ(read.material_textures.at(read.mesh.triangle_materials[t]), paintOf(t) == 0 ? 0 : -1) << t;
  expectTexcoords(read.mesh.texcoords, read.mesh, "texture coordinates");
}

TEST_F(Files3ds, CutOnesAreErrors) {
  const std::string whole = file3ds();
  ASSERT_EQ(errorOf(whole), "no error");
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THAT(errorOf(whole.substr(0, size)), HasSubstr("a.3ds")) << size;
}

}  // namespace
}  // namespace bakelight::formats
