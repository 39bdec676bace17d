#include "tools/report/storage.h"

#include <algorithm>
#include <stdexcept>

#include "compression/clustered_rows.h"
#include "compression/coded_sums.h"
#include "compression/errors.h"
#include "compression/haar_rows.h"
#include "compression/harmonics.h"
#include "compression/shared_sums.h"
#include "compression/wavelets_4d.h"
#include "tools/report/text.h"
#include "transport/all_frequency_shading.h"
#include "transport/morton.h"

namespace bakelight::report {
namespace {

using compression::CompressedTransfer;
using compression::Radiance4;

constexpr int kOrder = 5;  // of harmonics, as the recipe biscale bakes
constexpr int kProducts = 7;
// What errs least at the bytes of the sums of bunnies, and at half of them; half the rounds of assigning rows take a few per cent more.
constexpr int kComponents = 12, kComponentsOfFewBytes = 4, kRounds = 4;

const formats::PixelTransfer& transferOf(const formats::Pack& pack) {
  const auto* transfer = pack.transfer.as<formats::PixelTransfer>();
  if (transfer == nullptr) throw std::invalid_argument("the pack's transfer is not in a pixel basis");
  return *transfer;
}

formats::PixelRows rowsOf(const formats::PixelTransfer& transfer) {
  if (transfer.sums) return compression::decode(*transfer.sums->grammar);
  const formats::PixelTransferRows rows(transfer);
  const formats::PixelCodes codes = rows.view();
  return {codes.cube_side,
          codes.local_side,
          codes.subsamples,
          {codes.row_offsets.begin(), codes.row_offsets.end()},
          {codes.columns.begin(), codes.columns.end()},
          {codes.codes.begin(), codes.codes.end()}};
}

// Of blocks of rows, by the first vertex that has each.
std::vector<std::uint32_t> orderOf(const formats::Pack& pack) {
  const formats::PixelTransfer& transfer = transferOf(pack);
  std::vector<formats::Float3> positions(transfer.blockCount());
  std::vector<std::uint8_t> known(positions.size(), 0);
  for (std::size_t v = 0; v < transfer.blocks.size(); ++v)
    if (const std::uint32_t block = transfer.blocks[v]; known[block] == 0) {
      positions[block] = pack.mesh.positions[v];
      known[block] = 1;
    }
  return transport::mortonOrder(positions);
}

class Measuring {
 public:
  Measuring(const formats::Pack& pack, const Plan& plan, Renderer& renderer,
            const std::vector<Reference>& truth)
      : pack_(pack), renderer_(renderer), truth_(truth), rows_(rowsOf(transferOf(pack))) {
    const formats::PixelCodes codes = rows_.view();
    const transport::LightNeeds needs = transport::makePackShading(pack)->needs();
    for (std::size_t view = 0; view < plan.views.size(); ++view) {
      energies_.push_back(
          compression::texelEnergies(renderer.conditions(pack.mesh, needs, view).cube, codes.cube_side));
      exact_.emplace_back(codes.rowCount());
      transport::multiply(codes, energies_.back(), exact_.back());
    }
    figures_.rows = codes.rowCount();
    figures_.entries = codes.columns.size();
    figures_.dense_bytes = codes.rowCount() * codes.columnCount();
  }

  formats::PixelCodes codes() const { return rows_.view(); }

  void add(double share, const CompressedTransfer& transfer) {
    StorageMethod method{.name = transfer.name,
                         .parameters = transfer.parameters,
                         .share = share,
                         .bytes = transfer.bytes,
                         .operations = transfer.operations};
    std::vector<double> times, errors;
    std::vector<Radiance4> values(transfer.value_count);
    for (int i = 0; i < kProducts; ++i)
      times.push_back(millisecondsOf([&] { transfer.multiply(energies_.front(), values); }));
    method.product_ms = spreadOf(times);
    std::vector<std::vector<Radiance4>> incident;
    for (std::size_t view = 0; view < energies_.size(); ++view) {
      incident.push_back(transfer.incident(energies_[view]));
      method.incident_errors.push_back(compression::relativeRms(incident.back(), exact_[view]));
    }
    const std::vector<Picture> pictures = renderer_.picturesOf(
        pack_, [&](std::size_t view, const Renderer::Conditions&, transport::PackShading& shading) {
          dynamic_cast<transport::AllFrequencyShading&>(shading).setIncident(incident[view]);
        });
    for (std::size_t view = 0; view < pictures.size(); ++view)
      method.picture_errors.push_back(
          viewErrors(truth_[view], {pictures[view], {}}, truth_[view].picture).relativeRmse());
    figures_.methods.push_back(std::move(method));
  }

  StorageFigures figures() { return std::move(figures_); }

 private:
  const formats::Pack& pack_;
  Renderer& renderer_;
  const std::vector<Reference>& truth_;
  formats::PixelRows rows_;
  std::vector<std::vector<Radiance4>> energies_, exact_;  // a view
  StorageFigures figures_;
};

}  // namespace

bool hasStorage(const formats::Pack& pack) {
  const auto* transfer = pack.transfer.as<formats::PixelTransfer>();
  return transfer != nullptr && !transfer->changes && transport::AllFrequencyShading::shades(pack);
}

StorageFigures measureStorage(const formats::Pack& pack, const Plan& plan, Renderer& renderer,
                              const std::vector<Reference>& truth, const std::function<void()>& advanced) {
  Measuring measuring(pack, plan, renderer, truth);
  const formats::PixelCodes codes = measuring.codes();
  const auto add = [&](double share, const CompressedTransfer& transfer) {
    measuring.add(share, transfer);
    advanced();
  };
  add(0, compression::plainRows(codes));
  const CompressedTransfer sums = compression::exactSums(codes);
  add(1, sums);
  compression::WaveletRows haar;
  const bool has_haar = compression::hasHaar(codes.cube_side);
  if (has_haar) haar = compression::haarRows(codes);
  const std::vector<std::uint32_t> order = orderOf(pack);
  for (const double share : kStorageShares) {
    const auto budget = static_cast<std::uint64_t>(share * static_cast<double>(sums.bytes));
    // A method that has no such small size is left out.
    const auto attempt = [&](const std::function<CompressedTransfer()>& make) {
      try {
        add(share, make());
      } catch (const std::invalid_argument&) {
        advanced();
      }
    };
    if (share < 1) attempt([&] { return compression::sumsWithin(budget, codes); });
    attempt([&] {
      const int components[] = {share < 1 ? kComponentsOfFewBytes : kComponents};
      return compression::clusteredWithin(budget, codes, components, kRounds);
    });
    if (has_haar) {
      attempt([&] { return compression::haarWithin(budget, haar, compression::Selection::kAreaWeighted); });
      attempt([&] { return compression::wavelets4dWithin(budget, haar, codes.local_side, order); });
    }
    attempt([&] { return compression::harmonicsWithin(budget, codes, kOrder); });
  }
  return measuring.figures();
}

}  // namespace bakelight::report
