// golden: runs, renews and checks the determinism of golden cases.
//   golden CASE                 compare with golden/
//   golden --update CASE        show how far the new outputs are from the old ones, then put them into
//   golden/ golden --determinism CASE   the same bytes with 1 thread and with 4
// Exit status 77: this machine lacks what the case needs (ctest shows it as skipped).
#include <unistd.h>

#include <algorithm>
#include <CLI/CLI.hpp>
#include <cstdio>

#include "formats/error.h"
#include "formats/file.h"
#include "tests/stages/golden_case.h"

using namespace bakelight;
namespace fs = std::filesystem;

namespace {

constexpr int kDiffers = 1, kSkipped = 77;
const fs::path kCasesFolder = fs::path(BAKELIGHT_SOURCE_DIR) / "tests/stages";
const fs::path kToolsFolder = BAKELIGHT_BIN_DIR;

class WorkFolder {
 public:
  WorkFolder() {
    std::string name = (fs::temp_directory_path() / "bakelight-golden-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw cannotWrite(name, "a temporary folder cannot be made");
    path_ = name;
  }
  ~WorkFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

int check(const stages::GoldenCase& golden_case) {
  const WorkFolder work;
  stages::runCase(golden_case, kToolsFolder, work.path(), 4);
  bool passes = true;
  for (const auto& output : stages::compareWithGolden(golden_case, work.path())) {
    std::fputs(stages::asText(output).c_str(), stdout);
    passes &= output.comparison.passes();
  }
  return passes ? 0 : kDiffers;
}

int update(const stages::GoldenCase& golden_case) {
  const WorkFolder work;
  stages::runCase(golden_case, kToolsFolder, work.path(), 4);
  for (const stages::CaseOutput& output : golden_case.outputs) {
    const fs::path made = work.path() / output.file, golden = golden_case.goldenFolder() / output.file;
    if (fs::exists(golden))
      std::fputs(stages::asText({output.file + ", before and after",
                                 formats::compareFiles(output.kind, made, golden, output.limits)})
                     .c_str(),
                 stdout);
    else
      std::printf("%s: new, %ju bytes\n", output.file.c_str(), fs::file_size(made));
  }
  fs::remove_all(golden_case.goldenFolder());
  for (const stages::CaseOutput& output : golden_case.outputs)
    formats::writeFileAtomically(golden_case.goldenFolder() / output.file,
                                 formats::readFile(work.path() / output.file));
  return 0;
}

int checkDeterminism(const stages::GoldenCase& golden_case) {
  const WorkFolder one, four;
  stages::runCase(golden_case, kToolsFolder, one.path(), 1);
  stages::runCase(golden_case, kToolsFolder, four.path(), 4);
  const auto differing = stages::differingFiles(golden_case, one.path(), four.path());
  for (const std::string& file : differing)
    std::printf("%s: 1 thread and 4 threads give different bytes\n", file.c_str());
  return differing.empty() ? 0 : kDiffers;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Golden tests of the stages", "golden");
  std::string name;
  bool updates = false, determinism = false;
  app.add_option("case", name, "Folder of tests/stages")->required();
  app.add_flag("--update", updates, "Show before and after, then renew golden/");
  app.add_flag("--determinism", determinism, "Compare 1 thread with 4 instead")->excludes("--update");
  CLI11_PARSE(app, argc, argv);
  try {
    const stages::GoldenCase golden_case = stages::readCase(kCasesFolder / name);
    if (updates) return update(golden_case);
    return determinism ? checkDeterminism(golden_case) : check(golden_case);
  } catch (const Error& error) {
    std::fprintf(stderr, "golden: %s\n", error.what());
    return error.status() == ExitStatus::kNotAvailable ? kSkipped : kDiffers;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "golden: %s\n", error.what());
    return kDiffers;
  }
}
