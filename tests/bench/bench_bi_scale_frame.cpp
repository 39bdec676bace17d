// A frame of bi-scale shading beside a plain textured one: the same mesh, camera and GL, in turn, at 512 × 512.
//
// frame_ratio = time of a bi-scale frame ÷ time of a frame in which a texture is multiplied by the radiance of vertices. Both
// with a new view and the same light: radiance transfer is evaluated once and for all.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <vector>

#include "formats/pack.h"
#include "tests/support/made_rtt.h"
#include "tests/support/rippled_ball.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/renderer.h"
#include "tools/player/techniques/technique.h"
#include "transport/lighting.h"
#include "transport/mesh_topology.h"
#include "transport/texture_frames.h"

namespace bakelight {
namespace {

constexpr int kOrder = 5, kSize = 512, kIndexSize = 2048;

constexpr player::ShaderSource kTexturedVert = {"textured.vert", R"glsl(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 radiance;
layout(location = 2) in vec3 texcoord;
layout(location = 0) uniform mat4 clip_from_position;
out vec3 exit_radiance;
out vec2 surface_texcoord;
void main() {
  exit_radiance = radiance;
  surface_texcoord = texcoord.xy;
  gl_Position = clip_from_position * vec4(position, 1.0);
}
)glsl"};
constexpr player::ShaderSource kTexturedFrag = {"textured.frag", R"glsl(
in vec3 exit_radiance;
in vec2 surface_texcoord;
layout(binding = 0) uniform sampler2D albedo;
layout(location = 0) out vec4 linear;
void main() { linear = vec4(exit_radiance * texture(albedo, surface_texcoord).rgb, 1.0); }
)glsl"};

// What games did before: a mip-mapped texture times interpolated light.
class Textured final : public player::Technique {
 public:
  Textured(const formats::Pack& pack, const player::SurfaceMesh& mesh) : mesh_(mesh) {
    std::vector<transport::Float3> texcoords;
    for (const auto& uv : pack.mesh.texcoords) texcoords.push_back({uv[0], uv[1], 0});
    radiance_ = player::makeBuffer(pack.mesh.normals.size() * 12, pack.mesh.normals.data());
    texcoords_ = player::makeBuffer(texcoords.size() * 12, texcoords.data());
    GLuint name = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &name);
    texture_ = player::Texture(name);
    glTextureStorage2D(name, 12, GL_SRGB8_ALPHA8, kIndexSize, kIndexSize);
    std::vector<std::uint32_t> texels(static_cast<std::size_t>(kIndexSize) * kIndexSize);
    for (std::size_t i = 0; i < texels.size(); ++i) texels[i] = static_cast<std::uint32_t>(i * 2654435761U);
    glTextureSubImage2D(name, 0, 0, 0, kIndexSize, kIndexSize, GL_RGBA, GL_UNSIGNED_BYTE, texels.data());
    glGenerateTextureMipmap(name);
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    program_ =
        player::makeProgram({{GL_VERTEX_SHADER, {kTexturedVert}}, {GL_FRAGMENT_SHADER, {kTexturedFrag}}});
    vertices_ =
        player::makeVertexArray(mesh.indices(), {{0, &mesh.positions()}, {1, &radiance_}, {2, &texcoords_}});
  }
  void setLight(const player::GpuLight&, const player::GpuLight*) override {}
  void lookFrom(const transport::ViewPoint&) override {}
  void draw(const Eigen::Matrix4f& clip_from_position) const override {
    glUseProgram(program_.name());
    glUniformMatrix4fv(0, 1, GL_FALSE, clip_from_position.data());
    glBindTextureUnit(0, texture_.name());
    glBindVertexArray(vertices_.name());
    glDrawElements(GL_TRIANGLES, mesh_.indexCount(), GL_UNSIGNED_INT, nullptr);
  }
  std::size_t gpuBytes() const override { return 0; }

 private:
  const player::SurfaceMesh& mesh_;
  player::Buffer radiance_, texcoords_;
  player::Texture texture_;
  player::Program program_;
  player::VertexArray vertices_;
};

// 20,000 triangles under a texture of 64 × 64 texels and 8 × 8 views, 2048² texels of index.
formats::Pack madePack(int components) {
  formats::Pack pack;
  pack.mesh = tests::rippledBall(20000);
  tests::addSphericalTexcoords(pack.mesh);
  std::vector<transport::Vec3> normals(pack.mesh.vertexCount(), transport::Vec3::Zero());
  for (const auto& [a, b, c] : pack.mesh.triangles) {
    const transport::Vec3 origin = transport::vec3(pack.mesh.positions[a]);
    for (const auto v : {a, b, c})
      normals[v] += (transport::vec3(pack.mesh.positions[b]) - origin)
                        .cross(transport::vec3(pack.mesh.positions[c]) - origin);
  }
  for (const transport::Vec3& normal : normals)
    pack.mesh.normals.push_back(transport::float3(transport::Vec3(normal.normalized())));
  formats::ShTransfer transfer;
  transfer.order = kOrder;
  const std::size_t count = pack.mesh.vertexCount(), values = 25 * 25;
  const auto zeros = [&](std::size_t columns) {
    return formats::encodeTable(std::vector<float>(count * columns, 0.01F), columns,
                                formats::Precision::kFloat16, "made", "table");
  };
  transfer.vectors = zeros(25);
  formats::GlossyTransfer& glossy = transfer.glossy.emplace();
  glossy.output_order = kOrder;
  glossy.tangents = transport::textureFrames(pack.mesh).tangents;
  glossy.transfer = formats::MatrixOperator{zeros(values)};
  pack.transfer = transfer;
  formats::RttReflection rtt = tests::madeRtt(kOrder, 8, 64, 64, components);
  rtt.patch_width = 0.3F;
  rtt.index = tests::madeIndex(kIndexSize, kIndexSize);
  pack.appearances.front().reflection = rtt;
  return pack;
}

double millisecondsOf(player::Renderer& renderer, const formats::FrameSettings& settings) {
  const auto start = std::chrono::steady_clock::now();
  renderer.draw(settings);
  glFinish();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

void frameOf(benchmark::State& state) {
  const player::HeadlessContext context;
  formats::Pack pack = madePack(static_cast<int>(state.range(0)));
  player::Renderer bi_scale(pack, transport::defaultLighting(kOrder));
  pack.appearances.front().reflection = formats::LambertReflection();
  player::techniques().push_back(
      {"textured", [](const formats::Pack&) { return true; },
       [](const formats::Pack&) { return transport::LightNeeds{kOrder}; },
       [](const formats::Pack& played, const player::SurfaceMesh& mesh,
          bool) -> std::unique_ptr<player::Technique> { return std::make_unique<Textured>(played, mesh); }});
  player::Renderer plain(pack, transport::defaultLighting(kOrder));
  player::techniques().pop_back();
  formats::FrameSettings settings{.width_px = kSize, .height_px = kSize};
  settings.supersampling = 1;
  std::vector<double> of_plain, of_bi_scale;
  for (auto _ : state) {
    settings.yaw_deg += 7;
    of_plain.push_back(millisecondsOf(plain, settings));
    of_bi_scale.push_back(millisecondsOf(bi_scale, settings));
  }
  // The first frames compile shaders.
  const auto median = [](std::vector<double> times) {
    std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2),
                     times.end());
    return times[times.size() / 2];
  };
  state.counters["plain_ms"] = median(of_plain);
  state.counters["bi_scale_ms"] = median(of_bi_scale);
  state.counters["frame_ratio"] = median(of_bi_scale) / median(of_plain);
}
BENCHMARK(frameOf)
    ->Name("bi_scale_frame/components")
    ->Arg(8)
    ->Arg(16)
    ->Arg(28)
    ->Iterations(25)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bakelight

BENCHMARK_MAIN();
