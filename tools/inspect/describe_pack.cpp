#include <cstring>

#include "formats/field_list.h"
#include "formats/pack.h"
#include "tools/inspect/describe.h"
#include "tools/inspect/describe_parts.h"
#include "tools/inspect/moments.h"
#include "transport/sh.h"

namespace bakelight::inspect {

using formats::FieldValue;

namespace {

Section packSection(const formats::Pack& pack, std::span<const std::byte> bytes, const std::string& file) {
  return {"pack",
          {{"version", formats::packVersion(bytes, file), ""},
           {"extension", "BAKELIGHT_radiance_transfer", ""},
           {"name", pack.name, ""},
           {"materials", pack.appearances.size(), ""},
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

formats::Json shown(const formats::Json& value) {
  if (value.is_number_float()) return numberOf(value.get<float>());
  if (!value.is_array()) return value;
  formats::Json list = formats::Json::array();
  for (const formats::Json& element : value) list.push_back(shown(element));
  return list;
}

// Kind and plain fields of a part.
Section partSection(const std::string& name, const formats::PackPart& part) {
  Section section{name, {{"kind", part.kind(), ""}}, {}, {}};
  for (const FieldValue& field : formats::fieldsOf(part)) {
    const bool is_short = !field.plain.is_array() || field.plain.size() <= 4;
    if (field.isPlain() && is_short) section.figures.push_back({field.name, shown(field.plain), ""});
  }
  return section;
}

Section materialSection(std::size_t index, const formats::Appearance& appearance) {
  Section section = partSection("material " + std::to_string(index), appearance.reflection);
  section.figures.insert(section.figures.begin(), {{"name", appearance.material, ""},
                                                   {"base_color", listOf(appearance.base_color), "linear"}});
  return section;
}

std::vector<float> integersOf(const formats::IntegerArray& integers) {
  std::vector<float> values(integers.count());
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::uint32_t value = 0;
    std::memcpy(&value, integers.data.data() + i * integers.width, integers.width);  // little-endian
    values[i] = static_cast<float>(value);
  }
  return values;
}

// Of a table, a list or integers.
std::vector<float> valuesOf(const FieldValue& field) {
  if (field.table != nullptr) return field.table->decode();
  return field.integers != nullptr ? integersOf(*field.integers) : field.values;
}
const char* typeOf(const FieldValue& field) {
  if (field.table != nullptr) return nameOf(field.table->precision);
  return field.integers != nullptr ? formats::nameOfIntegers(field.integers->width) : "float32";
}

void addTables(Section& section, const std::string& prefix, const formats::PackPart& part) {
  for (const FieldValue& field : formats::fieldsOf(part)) {
    if (field.isPlain()) continue;
    Moments moments;
    const std::vector<float> values = valuesOf(field);
    for (const float value : values) moments.add(value);
    const std::size_t columns = field.table != nullptr ? field.table->columns : 1;
    const std::size_t rows = field.table != nullptr ? field.table->rows : values.size();
    section.rows.push_back({prefix + field.name, typeOf(field), rows, columns, moments.minimum(),
                            moments.mean(), moments.maximum(), moments.rootMeanSquare()});
  }
}

Section tableSection(const formats::Pack& pack) {
  Section section{
      "tables", {}, {"table", "precision", "rows", "columns", "minimum", "mean", "maximum", "rms"}, {}};
  addTables(section, "", pack.transfer);
  for (std::size_t i = 0; i < pack.appearances.size(); ++i)
    addTables(section, "material " + std::to_string(i) + " ", pack.appearances[i].reflection);
  if (pack.neighborhood) addTables(section, "neighborhood ", *pack.neighborhood);
  return section;
}

}  // namespace

std::vector<Section> describePack(const formats::Pack& pack, std::span<const std::byte> bytes,
                                  const std::string& file) {
  std::vector<Section> sections = {packSection(pack, bytes, file), fileSections(pack, bytes, file),
                                   partSection("transfer", pack.transfer)};
  for (std::size_t i = 0; i < pack.appearances.size(); ++i)
    sections.push_back(materialSection(i, pack.appearances[i]));
  if (pack.neighborhood) sections.push_back(partSection("neighborhood", *pack.neighborhood));
  sections.push_back(tableSection(pack));
  if (const auto* transfer = pack.transfer.as<formats::ShTransfer>()) {
    sections.push_back(bandSection("energy_per_sh_band", transfer->vectors.decode(), transfer->order));
    if (transfer->near_field)
      sections.push_back(
          bandSection("near_energy_per_sh_band", transfer->near_field->vectors.decode(), transfer->order));
  }
  for (Section& section : describeMesh(pack.mesh, {})) sections.push_back(std::move(section));
  return sections;
}

}  // namespace bakelight::inspect
