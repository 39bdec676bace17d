#include "formats/module.h"

#include <dlfcn.h>

#include "formats/error.h"

namespace bakelight::formats {
namespace fs = std::filesystem;
namespace {

fs::path moduleOf(const fs::path& tools, const std::string& name) {
  return (tools / ".." / "lib" / "bakelight" / (name + ".so")).lexically_normal();
}

Error notAvailable(const fs::path& module, const std::string& what) {
  return Error(ExitStatus::kNotAvailable, {module.string(), "", ""}, what,
               "this library beside the tools, of the same build", "build or install it again");
}

}  // namespace

std::vector<fs::path> modulesOf(const fs::path& tools) {
  return {moduleOf(tools, "meshes"), moduleOf(tools, "pictures")};
}

const void* moduleEntry(const std::string& name, const std::string& entry) {
  const fs::path path = moduleOf(fs::read_symlink("/proc/self/exe").parent_path(), name);
  void* module = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) {
    const char* reason = dlerror();
    throw notAvailable(path, "it cannot be loaded (" + std::string(reason != nullptr ? reason : "") + ")");
  }
  void* symbol = dlsym(module, entry.c_str());
  if (symbol == nullptr) throw notAvailable(path, "it has no " + entry);
  return reinterpret_cast<const void* (*)()>(symbol)();
}

}  // namespace bakelight::formats
