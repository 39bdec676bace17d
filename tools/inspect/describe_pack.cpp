#include "formats/pack.h"
#include "tools/inspect/describe.h"
#include "tools/inspect/describe_parts.h"
#include "tools/inspect/moments.h"
#include "transport/sh.h"

namespace bakelight::inspect {

using formats::EncodedTable;
using formats::GlossyMaterial;
using formats::LobeModel;
using formats::MatrixStorage;
using formats::RadianceTransfer;

namespace {

Section packSection(const formats::Pack& pack, std::span<const std::byte> bytes, const std::string& file) {
  return {"pack",
          {{"version", formats::packVersion(bytes, file), ""},
           {"extension", "BAKELIGHT_radiance_transfer", ""},
           {"name", pack.name, ""},
           {"base_color", listOf(pack.base_color), "linear"},
           {"vertex_colors", !pack.colors.empty(), ""},
           {"bytes_per_vertex",
            static_cast<double>(bytes.size()) / static_cast<double>(pack.mesh.vertexCount()), ""}},
          {},
          {}};
}

Section fileSections(const formats::Pack& pack, std::span<const std::byte> bytes, const std::string& file) {
  // packSections throws unless every checksum holds.
  Section table{"sections",
                {},
                {"section", "offset_bytes", "size_bytes", "bytes_per_vertex", "checksum", "verified"},
                {}};
  for (const formats::PackSection& section : formats::packSections(bytes, file))
    table.rows.push_back(
        {section.name, section.offset_bytes, section.size_bytes,
         static_cast<double>(section.size_bytes) / static_cast<double>(pack.mesh.vertexCount()),
         section.checksum, true});
  return table;
}

Section transferSection(const RadianceTransfer& transfer) {
  Section section{"transfer",
                  {{"order", transfer.order, "bands"},
                   {"coefficients", transport::coefficientCount(transfer.order), ""},
                   {"transport", transfer.transport, ""},
                   {"channels", transfer.channels, ""},
                   {"storage", nameOf(transfer.storage), ""}},
                  {},
                  {}};
  if (!transfer.near_vectors.empty()) {
    section.figures.push_back({"sphere_center", listOf(transfer.sphere_center), ""});
    section.figures.push_back({"sphere_radius", numberOf(transfer.sphere_radius), ""});
  }
  if (transfer.storage != MatrixStorage::kNone)
    section.figures.push_back({"row_order", transfer.row_order, "bands"});
  if (transfer.storage == MatrixStorage::kCpca) {
    section.figures.push_back({"clusters", transfer.basis.rows / (1 + transfer.matrices.columns), ""});
    section.figures.push_back({"weights", transfer.matrices.columns, "per vertex"});
  }
  return section;
}

Section lobeSection(const GlossyMaterial& material) {
  Section section{"lobe", {{"model", nameOf(material.model), ""}}, {}, {}};
  if (material.model == LobeModel::kTable) {
    section.figures.push_back({"angles", material.table.angles, ""});
    section.figures.push_back({"order", material.table.order, "bands"});
    return section;
  }
  if (material.model == LobeModel::kPhong)
    section.figures.push_back({"exponent", numberOf(material.exponent), ""});
  if (material.model == LobeModel::kGgx)
    section.figures.push_back({"roughness", numberOf(material.roughness), ""});
  section.figures.push_back({"specular_color", listOf(material.specular_color), "linear"});
  return section;
}

Section tableSection(const RadianceTransfer& transfer) {
  Section section{
      "tables", {}, {"table", "precision", "rows", "columns", "minimum", "mean", "maximum", "rms"}, {}};
  const auto add = [&](const char* name, const EncodedTable& table) {
    if (table.empty()) return;
    Moments moments;
    for (const float value : table.decode()) moments.add(value);
    section.rows.push_back({name, nameOf(table.precision), table.rows, table.columns, moments.minimum(),
                            moments.mean(), moments.maximum(), moments.rootMeanSquare()});
  };
  add("vectors", transfer.vectors);
  add("near_vectors", transfer.near_vectors);
  add(transfer.storage == MatrixStorage::kVisibility ? "visibility"
      : transfer.storage == MatrixStorage::kCpca     ? "weights"
                                                     : "matrices",
      transfer.matrices);
  add("basis", transfer.basis);
  return section;
}

}  // namespace

std::vector<Section> describePack(const formats::Pack& pack, std::span<const std::byte> bytes,
                                  const std::string& file) {
  const RadianceTransfer& transfer = pack.transfer;
  std::vector<Section> sections = {packSection(pack, bytes, file), fileSections(pack, bytes, file),
                                   transferSection(transfer)};
  if (transfer.material.model != LobeModel::kNone) sections.push_back(lobeSection(transfer.material));
  sections.push_back(tableSection(transfer));
  sections.push_back(bandSection("energy_per_sh_band", transfer.vectors.decode(), transfer.order));
  if (!transfer.near_vectors.empty())
    sections.push_back(
        bandSection("near_energy_per_sh_band", transfer.near_vectors.decode(), transfer.order));
  for (Section& section : describeMesh(pack.mesh, {})) sections.push_back(std::move(section));
  return sections;
}

}  // namespace bakelight::inspect
