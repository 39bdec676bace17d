// bicluster: compresses transfer in a pixel basis, exactly or within a bound.
#include <array>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <string>
#include <utility>

#include "compression/shared_sums.h"
#include "compression/tolerance.h"
#include "formats/error.h"
#include "formats/sum_grammar_file.h"
#include "tools/bicluster/greedy.h"
#include "tools/bicluster/transfer_rows.h"
#include "tools/stage/stage.h"

using namespace bakelight;

namespace {

enum class Method { kSums, kGreedy, kCsr };
constexpr formats::Word<Method> kMethods[] = {
    {"sums", Method::kSums}, {"greedy", Method::kGreedy}, {"csr", Method::kCsr}};

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void reportSizes(stage::Run& run, const formats::PixelCodes& codes, double operations, double bytes) {
  const double dense = static_cast<double>(codes.rowCount()) * static_cast<double>(codes.columnCount());
  const double entries = static_cast<double>(codes.columns.size());
  run.stat("bytes", bytes);
  run.stat("bytes_percent", dense > 0 ? 100 * bytes / dense : 0);
  run.stat("operations", operations);
  run.stat("flops_percent", entries > 0 ? 100 * operations / (2 * entries) : 0);
}

// What pack asks of transfer beside the matrix.
void takeFrames(const formats::TensorFile& transfer, formats::TensorFile& file) {
  for (const char* frame : {"normals", "tangents"})
    if (const auto found = transfer.tensors.find(frame); found != transfer.tensors.end())
      file.tensors.insert(*found);
  for (const char* key : {"mesh_hash", "transport", "cosine"})
    if (const auto found = transfer.metadata.find(key); found != transfer.metadata.end())
      file.metadata.insert(*found);
}

std::string textOf(double value) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), static_cast<float>(value)).ptr};
}

void takeFigures(double tolerance, const compression::ToleranceFigures& figures, formats::TensorFile& file) {
  if (tolerance == 0) return;
  file.metadata["tolerance"] = textOf(tolerance);
  file.metadata["largest_error"] = textOf(figures.largest_error);
  file.metadata["rms_error"] = textOf(figures.rms_error);
}

// As transfer writes them.
void writeRows(const formats::PixelCodes& codes, formats::TensorFile file,
               const std::filesystem::path& path) {
  using formats::ElementType;
  file.tensors["row_offsets"] = formats::Tensor::from<std::uint64_t>(
      ElementType::kInt64, {codes.row_offsets.size()}, codes.row_offsets);
  file.tensors["columns"] =
      formats::Tensor::from<std::uint16_t>(ElementType::kUint16, {codes.columns.size()}, codes.columns);
  file.tensors["codes"] =
      formats::Tensor::from<std::uint8_t>(ElementType::kUint8, {codes.codes.size()}, codes.codes);
  formats::writeSafetensors(path, file);
}

// Read back and compared, entry by entry.
void writeSums(stage::Run& run, const formats::PixelCodes& codes, const formats::TensorFile& transfer,
               const compression::SumOptions& options, double tolerance,
               const compression::ToleranceFigures& figures, const std::filesystem::path& path) {
  const double start = seconds();
  const formats::SumGrammar grammar = compression::compress(codes, options);
  run.stat("compress_s", seconds() - start);
  formats::TensorFile file = formats::encodeSumGrammar(grammar);
  reportSizes(run, codes, static_cast<double>(compression::operationsOf(grammar).counted),
              static_cast<double>(formats::encodedBytes(file)));
  run.stat("operations_executed", compression::operationsOf(grammar).executed);
  run.stat("bytes_in_memory", compression::bytesInMemory(grammar));
  run.stat("tiles", grammar.tileCount());
  takeFrames(transfer, file);
  takeFigures(tolerance, figures, file);
  formats::writeSafetensors(path, file);
  const double loading = seconds();
  const formats::SumGrammar loaded = formats::decodeSumGrammar(formats::readSafetensors(path), path.string());
  run.stat("load_s", seconds() - loading);
  const std::uint64_t errors = compression::reconstructionErrors(loaded, codes);
  run.stat("reconstruction_errors", errors);
  if (errors != 0) throw std::logic_error("rows differ after they were read back");
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path transfer_path, out_path;
  Method method = Method::kSums;
  double tolerance = 0;
  int least_uses = 2, rows_per_tile = 24576;

  stage::Tool tool(
      "bicluster",
      "Compresses transfer in a pixel basis into sums that its rows share, exactly or within a bound.");
  tool.input("transfer", "tensors", transfer_path, "safetensors file that transfer wrote with basis pixel")
      .output("out", "tensors", out_path,
              "safetensors file for pack, see docs/FORMATS.md; of method greedy there is none", false)
      .parameter("method", method, kMethods,
                 "sums, or for comparison the published greedy biclusters or no compression, of which "
                 "figures are told")
      .parameter("tolerance", tolerance, {0, 1}, "of a cell's light",
                 "Largest error of a row under light of at most 1, as a share of an open cell under a white "
                 "sky; 0: exact")
      .parameter("least_uses", least_uses, {2, 1000}, "uses",
                 "Of a sum, at least: more makes tables smaller and rows longer")
      .parameter("rows_per_tile", rows_per_tile, {64, 1048576}, "rows", "That share tables, at most");

  return tool.run(argc, argv, [&](stage::Run& run) {
    const bicluster::TransferRows transfer = bicluster::readTransferRows(transfer_path);
    compression::TolerantRows changed;
    formats::PixelCodes codes = transfer.codes;
    if (tolerance > 0) {
      changed = compression::withinTolerance(codes, tolerance);
      codes = changed.rows.view();
    }
    run.stat("rows", codes.rowCount());
    run.stat("entries", codes.columns.size());
    run.stat("largest_error", changed.figures.largest_error);
    run.stat("rms_error", changed.figures.rms_error);
    run.stat("white_sky_largest_error", changed.figures.white_sky_error);
    run.stat("white_sky_rms_error", changed.figures.white_sky_rms);
    run.stat("changed_rows", changed.figures.changed_rows);
    if (method == Method::kGreedy && !out_path.empty())
      throw Error(ExitStatus::kUsage, {}, "of method greedy there are figures, but no file", "sums or csr",
                  "leave --out out, or take another method");
    const double start = seconds();
    if (method == Method::kCsr) {
      const double entries = static_cast<double>(codes.columns.size());
      reportSizes(run, codes, 2 * entries, 3 * entries + 4 * static_cast<double>(codes.rowCount() + 1));
      if (!out_path.empty()) {
        formats::TensorFile file = transfer.file;
        takeFigures(tolerance, changed.figures, file);
        writeRows(codes, std::move(file), out_path);
      }
    } else if (method == Method::kGreedy) {
      const bicluster::Biclusters biclusters = bicluster::greedyBiclusters(codes);
      run.stat("compress_s", seconds() - start);
      reportSizes(run, codes, static_cast<double>(biclusters.operations()),
                  static_cast<double>(biclusters.bytes()));
      run.stat("biclusters", biclusters.clusters.size());
    } else {
      if (out_path.empty())
        throw Error(ExitStatus::kUsage, {}, "--out is missing", "a file for the sums", "add --out FILE");
      writeSums(run, codes, transfer.file,
                {static_cast<std::uint32_t>(rows_per_tile), static_cast<std::uint32_t>(least_uses)},
                tolerance, changed.figures, out_path);
    }
  });
}
