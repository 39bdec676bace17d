#include "tools/player/techniques/glossy_pass.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "transport/glossy.h"

namespace bakelight::player {
namespace {

using formats::Float3;
using transport::Vec3;

std::vector<float> kernelOf(const formats::PackPart& reflection, int output_order) {
  std::vector<double> kernel;
  if (const auto* phong = reflection.as<formats::PhongLobe>())
    kernel = transport::phongKernel(output_order, phong->exponent);
  if (const auto* ggx = reflection.as<formats::GgxLobe>())
    kernel = transport::ggxKernel(output_order, ggx->roughness);
  return {kernel.begin(), kernel.end()};
}

Float3 specularColorOf(const formats::PackPart& reflection) {
  if (const auto* phong = reflection.as<formats::PhongLobe>()) return phong->specular_color;
  if (const auto* ggx = reflection.as<formats::GgxLobe>()) return ggx->specular_color;
  return {1, 1, 1};
}

std::string definitionsOf(int output_order, const formats::BrdfTable* table, bool object_frame) {
  const auto unsignedText = [](int value) { return std::to_string(value) + "u\n"; };
  std::string text = "#define ROW_ORDER " + unsignedText(output_order);
  if (object_frame) text += "#define OBJECT_FRAME\n";
  if (table != nullptr) {
    text += "#define BRDF_ANGLES " + unsignedText(table->angles);
    text += "#define BRDF_COEFFICIENTS " + unsignedText(transport::coefficientCount(table->order));
  }
  return text;
}

Buffer bufferOf(const auto& values) {
  return makeBuffer(values.size() * sizeof(values[0]), values.data());
}

}  // namespace

GlossyPass::GlossyPass(const formats::Pack& pack, const SurfaceMesh& mesh, bool object_frame,
                       std::size_t largest_block_bytes)
    : mesh_(mesh),
      transferred_bytes_(transport::coefficientCount(pack.sh().glossy.value().output_order) * sizeof(Float3)),
      ranges_(rowRanges(pack.mesh.vertexCount(), transferred_bytes_, 1, largest_block_bytes)) {
  const formats::GlossyTransfer& transfer = *pack.sh().glossy;
  const std::size_t count = pack.mesh.vertexCount();
  if (pack.mesh.normals.size() != count || transfer.tangents.size() != count)
    throw std::invalid_argument("a glossy pack needs a frame a vertex");
  const std::vector<formats::VertexRange> vertices = formats::appearanceRanges(pack);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const formats::PackPart& part = pack.appearances[i].reflection;
    if (part.as<formats::LambertReflection>() != nullptr) {
      some_are_diffuse_ = true;
      continue;
    }
    const auto* table = part.as<formats::BrdfTable>();
    if (table != nullptr && (object_frame || table->order < transfer.output_order))
      throw std::invalid_argument("BRDF table and transfer do not fit together");
    reflections_.push_back(
        {vertices[i],
         makeComputeProgram({kGlossyComp}, definitionsOf(transfer.output_order, table, object_frame)),
         kernelOf(part, transfer.output_order), specularColorOf(part),
         table != nullptr ? bufferOf(table->values) : Buffer()});
    if (table == nullptr && reflections_.back().kernel.empty())
      throw std::invalid_argument(std::string("reflection ") + part.kind() + " is none at vertices");
  }
  normals_ = bufferOf(pack.mesh.normals);
  tangents_ = bufferOf(transfer.tangents);
  radiance_ = makeBuffer(count * sizeof(Float3), nullptr);
  throwIfGlFailed("preparing the glossy pass");
}

void GlossyPass::evaluate(const Vec3& eye, const Buffer& transferred, const Buffer& diffuse) const {
  const Float3 eye_from_origin = transport::float3(eye - mesh_.origin());
  if (some_are_diffuse_)
    glCopyNamedBufferSubData(diffuse.name(), radiance_.name(), 0, 0,
                             static_cast<GLsizeiptr>(sizeInBytes(radiance_)));
  for (const Reflection& reflection : reflections_)
    evaluate(reflection, transferred, diffuse, eye_from_origin);
  glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  throwIfGlFailed("reflecting towards the eye");
}

void GlossyPass::evaluate(const Reflection& reflection, const Buffer& transferred, const Buffer& diffuse,
                          const Float3& eye_from_origin) const {
  glUseProgram(reflection.program.name());
  glUniform3fv(1, 1, eye_from_origin.data());
  if (reflection.kernel.empty()) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, reflection.brdf.name());
  } else {
    glUniform3fv(2, 1, reflection.specular_color.data());
    glUniform1fv(3, static_cast<GLsizei>(reflection.kernel.size()), reflection.kernel.data());
  }
  for (const RowRange& range : ranges_) {
    const std::size_t first = std::max(range.first, reflection.vertices.first);
    const std::size_t end = std::min(range.first + range.count, reflection.vertices.end);
    if (first >= end) continue;
    bindRows(0, transferred, range, transferred_bytes_);
    bindRows(1, mesh_.positions(), range, sizeof(Float3));
    bindRows(2, radiance_, range, sizeof(Float3));
    bindRows(3, normals_, range, sizeof(Float3));
    bindRows(4, tangents_, range, sizeof(formats::Float4));
    bindRows(5, diffuse, range, sizeof(Float3));
    glUniform1ui(0, static_cast<GLuint>(end - range.first));
    glUniform1ui(13, static_cast<GLuint>(first - range.first));
    dispatchItems(end - first);
  }
}

std::size_t GlossyPass::gpuBytes() const {
  std::size_t bytes = sizeInBytes(normals_) + sizeInBytes(tangents_) + sizeInBytes(radiance_);
  for (const Reflection& reflection : reflections_) bytes += sizeInBytes(reflection.brdf);
  return bytes;
}

}  // namespace bakelight::player
