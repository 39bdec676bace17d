#include "tools/player/surroundings/ground.h"

#include <algorithm>
#include <string>

#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_timer.h"

namespace bakelight::player {
namespace {

transport::GroundFade fadeFrom(const formats::GroundTransfer& ground, const transport::Vec3& origin) {
  transport::GroundFade fade = transport::fadeOf(ground);
  fade.middle = {static_cast<float>(static_cast<double>(fade.middle[0]) - origin.x()),
                 static_cast<float>(static_cast<double>(fade.middle[1]) - origin.z())};
  return fade;
}

double farthest(const formats::TriangleMesh& mesh, const transport::Vec3& origin) {
  double result = 0;
  for (const formats::Float3& position : mesh.positions)
    result = std::max(result, (transport::vec3(position) - origin).norm());
  return result;
}

formats::EncodedTable tableOf(const formats::Neighborhood& neighborhood) {
  const std::vector<float> vectors = transport::groundVectors(neighborhood);
  return formats::encodeTable(vectors, neighborhood.ground->vectors.columns, formats::Precision::kFloat32,
                              "neighborhood", "ground");
}

}  // namespace

Ground::Ground(const formats::Neighborhood& neighborhood, const transport::Vec3& origin,
               const formats::Float3& albedo)
    : fade_(fadeFrom(neighborhood.ground.value(), origin)),
      radius_(farthest(transport::groundMesh(*neighborhood.ground), origin)),
      mesh_(transport::groundMesh(*neighborhood.ground), origin),
      vectors_(tableOf(neighborhood)),
      pass_(vectors_, neighborhood.order, neighborhood.channels, {albedo, nullptr}, false),
      program_(makeProgram({{GL_VERTEX_SHADER, {kGroundVert}},
                            {GL_FRAGMENT_SHADER,
                             {kGroundFrag},
                             "#define FADE_START " + std::to_string(transport::kFadeStart) + "\n"}})),
      vertices_(makeVertexArray(mesh_.indices(), {{0, &mesh_.positions()}, {1, &pass_.buffer()}})) {
  throwIfGlFailed("preparing the ground");
}

void Ground::setLight(const Buffer& light) {
  const GpuPass pass("ground light");
  pass_.evaluate(light);
}

void Ground::draw(const Eigen::Matrix4f& clip_from_position) const {
  const GpuPass pass("ground");
  glEnable(GL_CULL_FACE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glUseProgram(program_.name());
  glUniformMatrix4fv(0, 1, GL_FALSE, clip_from_position.data());
  glUniform2fv(1, 1, fade_.middle.data());
  glUniform2fv(2, 1, fade_.half_size.data());
  glBindVertexArray(vertices_.name());
  glDrawElements(GL_TRIANGLES, mesh_.indexCount(), GL_UNSIGNED_INT, nullptr);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
}

std::size_t Ground::gpuBytes() const {
  return mesh_.gpuBytes() + vectors_.gpuBytes() + sizeInBytes(pass_.buffer());
}

}  // namespace bakelight::player
