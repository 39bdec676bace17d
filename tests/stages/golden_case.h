// A golden case: a folder with case.json, which says what to run, and golden/, which holds what came of it
// when a person last looked.
//
//   {
//     "about": "what the case holds still",
//     "inputs": [{"file": "mesh.ply", "scene": "two_spheres", "subdivisions": 2}],
//     "commands": [["transfer", "--mesh", "mesh.ply", "--transfer", "transfer.safetensors"]],
//     "scratch": ["between.ply"],
//     "outputs": [{"file": "transfer.safetensors", "kind": "tensors",
//                  "limits": {"relative": 1e-5}, "reason": "why not equal to the bit"}]
//   }
// Inputs with "copy" instead of "scene" are files of the case folder. Limits are those of formats/compare.h;
// any limit needs a reason. Scratch files lie between commands: they must appear, and are not compared.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/compare.h"

namespace bakelight::stages {

struct CaseInput {
  std::string file;
  std::string scene, copy;  // one of the two
  int subdivisions = 0;
};

struct CaseOutput {
  std::string file, kind;
  formats::CompareLimits limits;
  std::string reason;
};

struct GoldenCase {
  std::filesystem::path folder;
  std::vector<CaseInput> inputs;
  std::vector<std::vector<std::string>> commands;  // tool, then its arguments
  std::vector<std::string> scratch;
  std::vector<CaseOutput> outputs;

  std::filesystem::path goldenFolder() const { return folder / "golden"; }
};

// Throws Error(kBadInput) with a pointer: an unknown key, no command, no output, limits without a reason.
GoldenCase readCase(const std::filesystem::path& folder);

// Makes the inputs in the empty folder `work` and runs the tools of `tools_folder` there. Throws
// Error(kBadInput) if a command fails, an output is missing or something else was left behind;
// Error(kNotAvailable) if a tool says that this machine lacks something.
void runCase(const GoldenCase& golden_case, const std::filesystem::path& tools_folder,
             const std::filesystem::path& work, int threads);

struct OutputComparison {
  std::string file;
  formats::Comparison comparison;
};

// Outputs in `work` against the golden ones. Throws Error(kBadInput) if golden/ does not hold exactly the
// case's outputs.
std::vector<OutputComparison> compareWithGolden(const GoldenCase& golden_case,
                                                const std::filesystem::path& work);

// The names of files that differ between two runs: by bytes, but JSON by value without its ignored keys.
std::vector<std::string> differingFiles(const GoldenCase& golden_case, const std::filesystem::path& a,
                                        const std::filesystem::path& b);

// "transfer.safetensors: same" and its differences, one a line.
std::string asText(const OutputComparison& output);

}  // namespace bakelight::stages
