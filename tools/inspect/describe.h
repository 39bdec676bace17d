// Turns figures into sections, for each kind of file.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "formats/file.h"
#include "formats/image.h"
#include "formats/json.h"
#include "formats/material.h"
#include "formats/pack.h"
#include "formats/tensors.h"
#include "formats/triangle_mesh.h"
#include "tools/inspect/summary.h"

namespace bakelight::inspect {

std::vector<Section> describeMesh(const formats::TriangleMesh& mesh, const std::vector<std::string>& notes);
std::vector<Section> describeImage(const formats::Image& image, const std::string& file);
std::vector<Section> describeTensors(const formats::TensorFile& tensors);
// `bytes` are the whole file that `pack` was read from.
std::vector<Section> describePack(const formats::Pack& pack, std::span<const std::byte> bytes,
                                  const std::string& file);
std::vector<Section> describeMaterials(const formats::Materials& materials);
// A stage's stats.json or an asset's record.json. Throws Error(kBadInput) for any other JSON.
std::vector<Section> describeRecord(const formats::Json& json, const std::string& file);

}  // namespace bakelight::inspect
