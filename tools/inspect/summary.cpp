#include "tools/inspect/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace bakelight::inspect {

using formats::Json;

namespace {

// Letters, not bytes: "µ" and "×" take two bytes and one column.
std::size_t displayWidth(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t width, bool right_aligned) {
  const std::string space(width - std::min(width, displayWidth(text)), ' ');
  return right_aligned ? space + text : text + space;
}

std::string grouped(const std::string& digits) {
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    const bool starts_group = (digits.size() - i) % 3 == 0;
    if (starts_group && !text.empty() && text.back() != '-') text += ',';
    text += digits[i];
  }
  return text;
}

std::string realText(double value) {
  return fmt::format("{:.6g}", value);
}

std::string valueText(const Json& value) {
  if (value.is_null()) return "-";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return realText(value.get<double>());
  if (value.is_number()) return grouped(value.dump());
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const Json& element : value) text.append(text.empty() ? "" : "  ").append(valueText(element));
  return text.empty() ? "none" : text;
}

std::string spaced(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

// "smallest_angle_deg" in degrees is "smallest angle": the unit follows the value.
std::string labelOf(const Figure& figure) {
  const std::string suffix = std::string("_").append(figure.unit);
  const bool repeats = !figure.unit.empty() && figure.name.ends_with(suffix);
  return spaced(repeats ? figure.name.substr(0, figure.name.size() - suffix.size()) : figure.name);
}

std::string figuresText(const Section& section) {
  std::size_t width = 0;
  for (const Figure& figure : section.figures) width = std::max(width, displayWidth(labelOf(figure)));
  std::string text;
  for (const Figure& figure : section.figures) {
    text.append("  ")
        .append(padded(labelOf(figure), width, false))
        .append("  ")
        .append(valueText(figure.value));
    if (!figure.unit.empty() && !figure.value.is_null()) text.append(" ").append(figure.unit);
    text += "\n";
  }
  return text;
}

std::string tableText(const Section& section) {
  std::vector<std::vector<std::string>> cells = {{}};
  for (const std::string& column : section.columns) cells.front().push_back(spaced(column));
  for (const auto& row : section.rows) {
    cells.emplace_back();
    for (const Json& value : row) cells.back().push_back(valueText(value));
  }
  std::string text;
  for (const auto& row : cells) {
    std::string line = " ";
    for (std::size_t c = 0; c < row.size(); ++c) {
      std::size_t width = 0;
      for (const auto& other : cells) width = std::max(width, displayWidth(other[c]));
      const bool right_aligned = !section.rows.empty() && section.rows.front()[c].is_number();
      line.append(1, ' ').append(padded(row[c], width, right_aligned)).append(1, ' ');
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

Json sectionJson(const Section& section) {
  if (section.columns.empty()) {
    Json figures = Json::object();
    for (const Figure& figure : section.figures) figures[figure.name] = figure.value;
    return figures;
  }
  Json rows = Json::array();
  for (const auto& row : section.rows) {
    Json object = Json::object();
    for (std::size_t c = 0; c < row.size(); ++c) object[section.columns[c]] = row[c];
    rows.push_back(std::move(object));
  }
  return rows;
}

}  // namespace

std::string asText(const Summary& summary) {
  std::string text =
      summary.file + ": " + summary.kind + ", " + grouped(std::to_string(summary.file_bytes)) + " bytes\n";
  for (const Section& section : summary.sections) {
    text.append("\n").append(spaced(section.name)).append("\n");
    text += section.columns.empty() ? figuresText(section) : tableText(section);
  }
  return text;
}

Json asJson(const Summary& summary) {
  Json json = {{"file", summary.file}, {"kind", summary.kind}, {"file_bytes", summary.file_bytes}};
  for (const Section& section : summary.sections) json[section.name] = sectionJson(section);
  return json;
}

}  // namespace bakelight::inspect
