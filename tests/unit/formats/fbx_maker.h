// Trees of FBX nodes, and how they are written: as text and in both binary layouts.
#pragma once

#include <cstdint>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "tests/unit/formats/dialects.h"

namespace bakelight::formats {

// A name with its class, which texts write as "Class::name" and binary files the other way round.
struct FbxName {
  std::string kind, name;
};

using FbxValue = std::variant<std::int32_t, std::int64_t, double, std::string, FbxName,
                              std::vector<std::int32_t>, std::vector<double>>;

struct FbxNode {
  std::string name;
  std::vector<FbxValue> values;
  std::vector<FbxNode> children = {};
};

enum class FbxEncoding { kText, kBinary7400, kBinary7500 };

namespace fbx_detail {

template <class T>
void writeNumbers(const std::vector<T>& numbers, std::ostringstream& out) {
  out << "*" << numbers.size() << " {\na: ";
  for (std::size_t i = 0; i < numbers.size(); ++i) out << (i == 0 ? "" : ",") << numbers[i];
  out << "\n}";
}

inline void writeText(const FbxNode& node, std::ostringstream& out) {
  out << node.name << ": ";
  bool is_array = false;
  for (std::size_t i = 0; i < node.values.size(); ++i) {
    if (i > 0) out << ", ";
    std::visit(
        [&](const auto& value) {
          using T = std::decay_t<decltype(value)>;
          if constexpr (std::is_same_v<T, std::string>)
            out << '"' << value << '"';
          else if constexpr (std::is_same_v<T, FbxName>)
            out << '"' << value.kind << "::" << value.name << '"';
          else if constexpr (std::is_arithmetic_v<T>)
            out << value;
          else
            writeNumbers(value, out), is_array = true;
        },
        node.values[i]);
  }
  if (!is_array && !node.children.empty()) {
    out << " {\n";
    for (const FbxNode& child : node.children) writeText(child, out);
    out << "}";
  }
  out << "\n";
}

inline std::string binaryValue(const FbxValue& value) {
  std::string bytes;
  const auto text = [&](const std::string& letters) {
    bytes += 'S';
    append(bytes, static_cast<std::uint32_t>(letters.size()));
    bytes += letters;
  };
  const auto numbers = [&](char type, const auto& values) {
    bytes += type;
    append(bytes, static_cast<std::uint32_t>(values.size()));
    append(bytes, std::uint32_t{0});  // not compressed
    append(bytes, static_cast<std::uint32_t>(values.size() * sizeof values[0]));
    for (const auto number : values) append(bytes, number);
  };
  std::visit(
      [&](const auto& v) {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, std::string>)
          text(v);
        else if constexpr (std::is_same_v<T, FbxName>)
          text(v.name + std::string("\0\1", 2) + v.kind);
        else if constexpr (std::is_same_v<T, std::int32_t>)
          bytes += 'I', append(bytes, v);
        else if constexpr (std::is_same_v<T, std::int64_t>)
          bytes += 'L', append(bytes, v);
        else if constexpr (std::is_same_v<T, double>)
          bytes += 'D', append(bytes, v);
        else if constexpr (std::is_same_v<T, std::vector<double>>)
          numbers('d', v);
        else
          numbers('i', v);
      },
      value);
  return bytes;
}

// Appends the node to a file whose lengths and places are of type `Size`.
template <class Size>
void writeBinary(const FbxNode& node, std::string& file) {
  std::string values;
  for (const FbxValue& value : node.values) values += binaryValue(value);
  const std::size_t begin = file.size();
  append(file, Size{0});  // where the node ends, known below
  append(file, static_cast<Size>(node.values.size()));
  append(file, static_cast<Size>(values.size()));
  file += static_cast<char>(node.name.size());
  file += node.name + values;
  for (const FbxNode& child : node.children) writeBinary<Size>(child, file);
  if (!node.children.empty()) file.append(3 * sizeof(Size) + 1, '\0');
  std::string end;
  append(end, static_cast<Size>(file.size()));
  file.replace(begin, sizeof(Size), end);
}

}  // namespace fbx_detail

inline std::string fbxFile(const std::vector<FbxNode>& nodes, FbxEncoding encoding) {
  if (encoding == FbxEncoding::kText) {
    std::ostringstream out;
    out.precision(17);
    out << "; FBX 7.4.0 project file\n";
    for (const FbxNode& node : nodes) fbx_detail::writeText(node, out);
    return out.str();
  }
  const bool wide = encoding == FbxEncoding::kBinary7500;
  std::string file("Kaydara FBX Binary  \0\x1a\0", 23);
  append(file, std::uint32_t{wide ? 7500u : 7400u});
  for (const FbxNode& node : nodes) {
    if (wide)
      fbx_detail::writeBinary<std::uint64_t>(node, file);
    else
      fbx_detail::writeBinary<std::uint32_t>(node, file);
  }
  return file.append(wide ? 25 : 13, '\0');
}

}  // namespace bakelight::formats
