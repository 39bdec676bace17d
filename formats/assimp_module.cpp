#include "formats/mesh_assimp.h"
#include "formats/mesh_module.h"

extern "C" const void* bakelight_mesh_readers() {
  static constexpr bakelight::formats::MeshReaders kReaders = {bakelight::formats::readWithAssimp};
  return &kReaders;
}
