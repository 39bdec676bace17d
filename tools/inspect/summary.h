// What inspect says of a file: figures and tables in sections, printed for people or as JSON from one source.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/json.h"

namespace bakelight::inspect {

struct Figure {
  std::string
      name;  // snake_case, with the unit at its end where JSON needs it: "mean_edge", "smallest_angle_deg"
  formats::Json value;  // boolean, number, text, a list of these, or null: does not apply
  std::string unit;     // "deg", "bytes"; "" if dimensionless
};

// Either figures or a table.
struct Section {
  std::string name;  // snake_case
  std::vector<Figure> figures;
  std::vector<std::string> columns;              // of the table, named like figures
  std::vector<std::vector<formats::Json>> rows;  // as long as `columns`
};

struct Summary {
  std::string file, kind;
  std::uint64_t file_bytes = 0;
  std::vector<Section> sections;
};

// Aligned columns, thousands grouped, six significant digits.
std::string asText(const Summary& summary);

// {"file", "kind", "file_bytes", <section>: {<figure>: value} or [{<column>: value}]}. Numbers in full.
formats::Json asJson(const Summary& summary);

}  // namespace bakelight::inspect
