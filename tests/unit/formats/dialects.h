// Scaffolding of the suites that read one format as different programs write it.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "formats/error.h"
#include "formats/mesh_import.h"
#include "tests/unit/formats/test_meshes.h"

namespace bakelight::formats {

class DialectTest : public testing::Test {
 protected:
  explicit DialectTest(std::string ending) : ending_(std::move(ending)) {}

  MeshImport import(const std::string& bytes) const { return import(bytes, "a" + ending_); }
  MeshImport import(const std::string& bytes, const std::string& name) const {
    write(name, bytes);
    return importMesh(folder_ / name);
  }
  // "no error" where there is none.
  std::string errorOf(const std::string& bytes) const {
    try {
      import(bytes);
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
      return error.what();
    }
    return "no error";
  }
  void write(const std::string& name, const std::string& bytes) const { writeQuickly(folder_ / name, bytes); }

  ScratchFolder folder_;

 private:
  std::string ending_;
};

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

// "3 1 0", for coordinates that are integers.
inline std::string integersText(const Float3& p) {
  std::string text;
  for (const float x : p) text += (text.empty() ? "" : " ") + std::to_string(static_cast<int>(x));
  return text;
}

// As the machine holds it.
template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace bakelight::formats
