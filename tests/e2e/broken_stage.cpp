// broken_stage BREAK TOOL ARGUMENTS...: runs a real tool, then spoils what it wrote, as a mistake in its code
// would. Tests put a script that calls it in the tool's place (broken_tools.h).
//   dropped_pi      transfer vectors lack their 1/π
//   flipped_axis    transfer vectors have x the wrong way round
//   turned_vectors  transfer vectors are in a frame turned by 90° about y
//   turned_frames   the vertices' tangents are turned by 30° about their normals (glossy transfer)
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "formats/mesh_ply.h"
#include "formats/tensors.h"
#include "transport/sh.h"
#include "transport/vector_types.h"

using namespace bakelight;
using transport::Vec3;

namespace {

constexpr double kPi = std::numbers::pi;

int runTool(char** command) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::execv(command[0], command);
    ::_exit(127);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::string valueOf(const std::vector<std::string>& arguments, const std::string& option) {
  for (std::size_t i = 0; i + 1 < arguments.size(); ++i)
    if (arguments[i] == option) return arguments[i + 1];
  return "";
}

std::vector<float> valuesOf(const formats::Tensor& tensor) {
  const auto values = tensor.as<float>();
  return {values.begin(), values.end()};
}

void replace(formats::Tensor& tensor, const std::vector<float>& values) {
  tensor = formats::Tensor::from<float>(tensor.type, tensor.shape, std::span<const float>(values));
}

void dropPi(std::vector<float>& vectors) {
  for (float& value : vectors) value *= static_cast<float>(kPi);
}

// With x turned round, cos(mφ) gains (−1)^m and sin(mφ) −(−1)^m.
void flipX(std::vector<float>& vectors, int order) {
  const auto count = static_cast<std::size_t>(order) * order;
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    const auto index = static_cast<int>(i % count);
    const int l = static_cast<int>(std::sqrt(index + 0.5)), m = index - l * (l + 1);
    if ((m > 0 && m % 2 != 0) || (m < 0 && m % 2 == 0)) vectors[i] = -vectors[i];
  }
}

void turnVectors(std::vector<float>& vectors, int order) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(kPi / 2, Vec3::UnitY()).toRotationMatrix();
  const transport::ShRotation rotation(order, turn);
  const auto count = static_cast<std::size_t>(order) * order;
  for (std::size_t begin = 0; begin < vectors.size(); begin += count) {
    std::vector<formats::Float3> vector;
    for (std::size_t i = 0; i < count; ++i) vector.push_back({vectors[begin + i], 0, 0});
    const auto turned = rotation.apply(vector);
    for (std::size_t i = 0; i < count; ++i) vectors[begin + i] = turned[i][0];
  }
}

void turnTangents(std::vector<float>& tangents, const formats::TriangleMesh& mesh) {
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    float* const tangent = &tangents[4 * v];
    const Vec3 turned = Eigen::AngleAxisd(kPi / 6, transport::vec3(mesh.normals[v]).normalized()) *
                        Vec3(tangent[0], tangent[1], tangent[2]);
    for (int axis = 0; axis < 3; ++axis) tangent[axis] = static_cast<float>(turned[axis]);
  }
}

void spoil(const std::string& kind, const std::filesystem::path& file, const std::filesystem::path& mesh) {
  formats::TensorFile transfer = formats::readSafetensors(file);
  const int order = std::stoi(transfer.metadata.at("order"));
  formats::Tensor& tensor = transfer.tensors.at(kind == "turned_frames" ? "tangent" : "transfer");
  std::vector<float> values = valuesOf(tensor);
  if (kind == "dropped_pi")
    dropPi(values);
  else if (kind == "flipped_axis")
    flipX(values, order);
  else if (kind == "turned_vectors")
    turnVectors(values, order);
  else if (kind == "turned_frames")
    turnTangents(values, formats::readPly(mesh));
  else
    throw std::invalid_argument("broken_stage knows no " + kind);
  replace(tensor, values);
  formats::writeSafetensors(file, transfer);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 1;
  const int status = runTool(argv + 2);
  const std::vector<std::string> arguments(argv + 3, argv + argc);
  const std::string file = valueOf(arguments, "--transfer");
  if (status != 0 || file.empty()) return status;  // --describe, or a mistake
  try {
    spoil(argv[1], file, valueOf(arguments, "--mesh"));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "broken_stage: %s\n", error.what());
    return 2;
  }
  return 0;
}
