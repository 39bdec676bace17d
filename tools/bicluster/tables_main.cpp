// transfer_tables: what a transfer matrix in a pixel basis costs as rows, as the published biclusters and as sums, to store and to run; the columns are those
// of Tables I and II of all-frequency bi-scale radiance transfer.
#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "compression/shared_sums.h"
#include "formats/file.h"
#include "formats/frame_settings.h"
#include "formats/json.h"
#include "formats/pack.h"
#include "formats/sum_grammar_code.h"
#include "tools/bicluster/greedy.h"
#include "tools/bicluster/transfer_rows.h"
#include "tools/stage/stage.h"
#include "transport/all_frequency_shading.h"
#include "transport/cpu_renderer.h"
#include "transport/frame.h"
#include "transport/ray_scene.h"
#include "transport/sum_product.h"

using namespace bakelight;
using formats::Json;

namespace {

constexpr int kRounds = 9;

double secondsOf(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double medianMilliseconds(const std::function<void()>& work) {
  std::vector<double> times;
  for (int i = 0; i < kRounds; ++i) times.push_back(1e3 * secondsOf(work));
  std::nth_element(times.begin(), times.begin() + kRounds / 2, times.end());
  return times[kRounds / 2];
}

std::vector<transport::Radiance4> whiteLight(std::size_t texels) {
  return std::vector<transport::Radiance4>(texels, transport::Radiance4(1e-3F, 1e-3F, 1e-3F, 0));
}

struct Method {
  std::string name;
  double operations = 0, bytes = 0, compress_s = 0, product_ms = 0;
  std::uint64_t parts = 0;  // biclusters, sums
};

Method plain(const formats::PixelCodes& codes) {
  const double entries = static_cast<double>(codes.columns.size());
  std::vector<transport::Radiance4> values(codes.rowCount());
  const auto light = whiteLight(codes.columnCount());
  return {"rows",
          2 * entries,
          3 * entries + 4 * static_cast<double>(codes.rowCount() + 1),
          0,
          medianMilliseconds([&] { transport::multiply(codes, light, values); }),
          codes.columns.size()};
}

Method sums(const formats::PixelCodes& codes) {
  Method method{"sums"};
  formats::SumGrammar grammar;
  method.compress_s = secondsOf([&] { grammar = compression::compress(codes); });
  method.operations = static_cast<double>(compression::operationsOf(grammar).counted);
  method.bytes = static_cast<double>(formats::encodeSums(grammar).byteCount());
  method.parts = grammar.sum_parts.size() / 2;
  std::vector<transport::Radiance4> values(grammar.row_places.size());
  const auto light = whiteLight(codes.columnCount());
  method.product_ms = medianMilliseconds([&] { transport::multiply(grammar, light, values); });
  return method;
}

Method greedy(const formats::PixelCodes& codes) {
  Method method{"published greedy"};
  bicluster::Biclusters biclusters;
  method.compress_s = secondsOf([&] { biclusters = bicluster::greedyBiclusters(codes); });
  method.operations = static_cast<double>(biclusters.operations());
  method.bytes = static_cast<double>(biclusters.bytes());
  method.parts = biclusters.clusters.size();
  std::vector<transport::Radiance4> values(codes.rowCount());
  const auto light = whiteLight(codes.columnCount());
  method.product_ms = medianMilliseconds([&] { bicluster::multiply(biclusters, light, values); });
  return method;
}

Json jsonOf(const Method& method, double entries, double dense) {
  return {{"method", method.name},
          {"operations", method.operations},
          {"operations_percent", entries > 0 ? 50 * method.operations / entries : 0},
          {"bytes", method.bytes},
          {"bytes_percent", dense > 0 ? 100 * method.bytes / dense : 0},
          {"compress_s", method.compress_s},
          {"parts", method.parts},
          {"product_ms", method.product_ms}};
}

// Light change and view change of a pack, as the CPU shades it.
Json shadingOf(const formats::Pack& pack, int width_px, int height_px) {
  transport::AllFrequencyShading shading(pack);
  const int side = shading.needs().cube_side;
  const std::vector<formats::Float3> light(6 * static_cast<std::size_t>(side) * side, {1, 1, 1});
  const double light_ms = medianMilliseconds([&] { shading.setCubeLight(light); });
  const std::size_t rows = pack.transfer.as<formats::PixelTransfer>()->blockCount() *
                           pack.transfer.as<formats::PixelTransfer>()->cells();
  const std::vector<transport::Radiance4> incident(rows, transport::Radiance4(1, 1, 1, 0));
  const double projection_ms = medianMilliseconds([&] { shading.setIncident(incident); });
  const transport::RayScene scene(pack.mesh);
  const transport::OrbitCamera camera =
      transport::frameCamera(formats::FrameSettings(), transport::boundingSphere(pack.mesh));
  shading.setView({camera.eye(), camera.pixelAngle(height_px)});
  const double frame_ms = medianMilliseconds([&] {
    transport::renderOnCpu(scene, transport::radianceOf(shading), camera, {width_px, height_px, 1},
                           [](const transport::Vec3&) {
                             return formats::Float4{0, 0, 0, 0};
                           });
  });
  return {{"width", width_px},
          {"height", height_px},
          {"light_change_ms", light_ms},
          {"projection_ms", projection_ms},
          {"frame_ms", frame_ms},
          {"fps_view", 1e3 / frame_ms},
          {"fps_light", 1e3 / (frame_ms + light_ms)}};
}

std::string textOf(const Json& tables) {
  std::string text = fmt::format(
      "Table I: the matrix\n  vertices {}, entries {:.1f} M, operations {:.1f} M, dense {:.0f} MB\n"
      "  {:<18}{:>12}{:>10}{:>12}{:>10}{:>12}{:>12}\n",
      tables["vertices"].get<std::uint64_t>(), tables["entries"].get<double>() / 1e6,
      tables["entries"].get<double>() / 5e5, tables["dense_bytes"].get<double>() / 1e6, "method",
      "M operations", "%", "MB", "% dense", "compress s", "parts");
  for (const Json& method : tables["methods"])
    text += fmt::format("  {:<18}{:>12.2f}{:>10.2f}{:>12.2f}{:>10.3f}{:>12.2f}{:>12}\n",
                        method["method"].get<std::string>(), method["operations"].get<double>() / 1e6,
                        method["operations_percent"].get<double>(), method["bytes"].get<double>() / 1e6,
                        method["bytes_percent"].get<double>(), method["compress_s"].get<double>(),
                        method["parts"].get<std::uint64_t>());
  text += "Table II: run time on this CPU, all cores\n";
  for (const Json& method : tables["methods"])
    text += fmt::format("  product, {:<18}{:>10.2f} ms\n", method["method"].get<std::string>(),
                        method["product_ms"].get<double>());
  if (!tables.contains("shading")) return text;
  const Json& shading = tables["shading"];
  text += fmt::format(
      "  projection on patches       {:>9.2f} ms\n  light change, both          {:>9.2f} ms\n"
      "  a frame of {} x {}        {:>9.2f} ms: {:.1f} / {:.1f} frames a second (view / light changes)\n",
      shading["projection_ms"].get<double>(), shading["light_change_ms"].get<double>(),
      shading["width"].get<int>(), shading["height"].get<int>(), shading["frame_ms"].get<double>(),
      shading["fps_view"].get<double>(), shading["fps_light"].get<double>());
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path transfer_path, pack_path, tables_path;
  bool with_greedy = false;
  int width_px = 640, height_px = 480;

  stage::Tool tool("transfer_tables",
                   "Tells what transfer in a pixel basis costs to store and to run, by several methods.");
  tool.input("transfer", "tensors", transfer_path, "safetensors file that transfer wrote with basis pixel")
      .input("pack", "pack", pack_path, "the pack of it, for the times of shading", false)
      .output("tables", "tables", tables_path, "JSON of all figures", false)
      .parameter("greedy", with_greedy, "Also the published greedy biclusters: a minute for 3,300 vertices")
      .parameter("width", width_px, {1, 16384}, "px", "Of the frame that is timed")
      .parameter("height", height_px, {1, 16384}, "px", "Of the frame that is timed")
      .executionPath(transport::RayScene::executionPath);

  return tool.run(argc, argv, [&](stage::Run& run) {
    const bicluster::TransferRows transfer = bicluster::readTransferRows(transfer_path);
    const formats::PixelCodes& codes = transfer.codes;
    const double entries = static_cast<double>(codes.columns.size()),
                 dense = static_cast<double>(codes.rowCount()) * static_cast<double>(codes.columnCount());
    Json tables = {
        {"vertices", codes.rowCount() / static_cast<std::size_t>(codes.local_side * codes.local_side)},
        {"entries", codes.columns.size()},
        {"dense_bytes", dense},
        {"methods", Json::array()}};
    const auto add = [&](const Method& method) {
      tables["methods"].push_back(jsonOf(method, entries, dense));
    };
    add(plain(codes));
    if (with_greedy) add(greedy(codes));
    add(sums(codes));
    if (!pack_path.empty()) {
      const formats::Pack pack = formats::readPack(pack_path);
      if (!transport::AllFrequencyShading::shades(pack))
        throw badInput({pack_path.string(), "", ""}, "it is no pack with transfer in a pixel basis",
                       "the pack of this transfer");
      tables["shading"] = shadingOf(pack, width_px, height_px);
    }
    std::cout << textOf(tables);
    if (!tables_path.empty()) formats::writeJson(tables_path, tables);
    run.stat("vertices", tables["vertices"].get<std::uint64_t>());
  });
}
