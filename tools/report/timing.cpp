#include "tools/report/timing.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

namespace bakelight::report {
namespace {

double quantile(const std::vector<double>& sorted, double rank) {
  const double position = rank * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], position - static_cast<double>(below));
}

}  // namespace

Spread spreadOf(std::vector<double> values) {
  if (values.empty()) throw std::invalid_argument("nothing was measured");
  std::sort(values.begin(), values.end());
  return {quantile(values, 0.5), quantile(values, 0.25), quantile(values, 0.75)};
}

std::vector<std::vector<Spread>> measureInTurn(const std::vector<Measurement>& measurements, int rounds) {
  std::vector<std::vector<std::vector<double>>> times(measurements.size());  // [candidate][i][round]
  for (int round = -kWarmUpRounds; round < rounds; ++round)
    for (std::size_t m = 0; m < measurements.size(); ++m) {
      const std::vector<double> measured = measurements[m](round);
      times[m].resize(measured.size());
      if (round < 0) continue;
      for (std::size_t i = 0; i < measured.size(); ++i) times[m][i].push_back(measured[i]);
    }
  std::vector<std::vector<Spread>> spreads(measurements.size());
  for (std::size_t m = 0; m < measurements.size(); ++m)
    for (const std::vector<double>& values : times[m]) spreads[m].push_back(spreadOf(values));
  return spreads;
}

double millisecondsOf(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace bakelight::report
