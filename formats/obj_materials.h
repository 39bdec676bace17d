// The materials that an OBJ file names, found in its libraries. Private to formats/mesh_obj.cpp.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/mesh_mtl.h"
#include "formats/mesh_parts.h"
#include "formats/named_file.h"
#include "formats/obj_statements.h"

namespace bakelight::formats {

struct ObjMaterials {
  std::vector<PartMaterial> materials;  // as many as there are names
  std::vector<MtlTexture> lookups;      // of each material; used if it has a texture
  std::vector<AlbedoTexture> textures;
  std::vector<std::string> notes;
};

// A library or picture that is missing is noted: its materials keep their names. Throws like readMtl.
ObjMaterials objMaterials(const std::vector<std::string>& names,
                          const std::vector<ObjStatements::Library>& libraries,
                          const std::filesystem::path& folder, const FileLookup& files);

// All files that the libraries are and name, whether they are there or not.
std::vector<std::filesystem::path> filesOfLibraries(const std::vector<ObjStatements::Library>& libraries,
                                                    const std::filesystem::path& folder,
                                                    const FileLookup& files);

}  // namespace bakelight::formats
