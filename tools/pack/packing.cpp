#include "tools/pack/packing.h"

#include <charconv>
#include <utility>

#include "formats/error.h"
#include "formats/mesh_ply.h"

namespace bakelight::packing {
namespace {

void requireValue(const formats::TensorFile& transfer, const char* key, const std::string& expected,
                  const std::string& file) {
  const std::string& value = transfer.requireMetadata(key, file);
  if (value == expected) return;
  throw badInput({file, std::string("metadata ") + key, ""}, "it is '" + value + "'", "'" + expected + "'",
                 "bake it with the transfer tool of this version");
}

int orderIn(const formats::TensorFile& transfer, const std::string& file) {
  const std::string& text = transfer.requireMetadata("order", file);
  int order = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), order);
  if (status != std::errc() || end != text.data() + text.size() || order < 1 || order > 10) {
    throw badInput({file, "metadata order", ""}, "it is '" + text + "'", "1 to 10");
  }
  return order;
}

void checkBits(int bits, int least, const char* pointer) {
  if (bits == 0 || (bits >= least && bits <= 30)) return;
  throw badInput({"", "", pointer}, std::to_string(bits) + " is out of range",
                 "0 (lossless), or " + std::to_string(least) + " to 30");
}

}  // namespace

formats::Pack assemblePack(formats::TriangleMesh mesh, const formats::TensorFile& transfer,
                           const std::string& name, const formats::Float3& albedo, const SourceNames& files) {
  const std::string& file = files.transfer;
  requireValue(transfer, "technique", "diffuse_vector", file);
  requireValue(transfer, "basis", "real_sh_cartesian", file);
  requireValue(transfer, "frame", "object", file);
  requireValue(transfer, "albedo", "outside", file);
  requireValue(transfer, "inverse_pi", "inside", file);
  const int order = orderIn(transfer, file);

  const formats::Tensor& table = transfer.require("transfer", formats::ElementType::kFloat32, 2, file);
  const auto coefficients = static_cast<std::uint64_t>(order) * static_cast<std::uint64_t>(order);
  if (table.shape[0] != mesh.vertexCount() || table.shape[1] != coefficients) {
    throw badInput({file, "tensor transfer", ""},
                   "its shape is " + std::to_string(table.shape[0]) + " × " + std::to_string(table.shape[1]),
                   std::to_string(mesh.vertexCount()) + " × " + std::to_string(coefficients) +
                       ", the vertices of " + files.mesh + " and order²",
                   "bake the transfer again, for this mesh");
  }
  if (transfer.requireMetadata("mesh_hash", file) != formats::geometryHash(mesh)) {
    throw badInput({file, "metadata mesh_hash", ""},
                   "the transfer was baked for another mesh than " + files.mesh, formats::geometryHash(mesh),
                   "bake the transfer again, for this mesh");
  }
  const auto vectors = table.as<float>();
  return {name,
          std::move(mesh),
          albedo,
          {order, transfer.requireMetadata("visibility", file),
           std::vector<float>(vectors.begin(), vectors.end())}};
}

void checkOptions(const formats::PackOptions& options) {
  checkBits(options.position_bits, 8, "/position_bits");
  checkBits(options.normal_bits, 6, "/normal_bits");
}

}  // namespace bakelight::packing
