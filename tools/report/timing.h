// Run times of several candidates, measured so that whatever else the machine does falls on all of them
// alike.
#pragma once

#include <functional>
#include <vector>

namespace bakelight::report {

struct Spread {
  double median = 0, low = 0, high = 0;  // low and high: quartiles
};

// Quantiles are linear between the two nearest values. Throws std::invalid_argument for no values.
Spread spreadOf(std::vector<double> values);

// Called with the number of the round; returns the milliseconds of what it measured, always as many.
using Measurement = std::function<std::vector<double>(int round)>;

// Runs all measurements once a round, in turn, `rounds` times after kWarmUpRounds that do not count.
// result[candidate][i] is the spread of its i-th time.
inline constexpr int kWarmUpRounds = 2;
std::vector<std::vector<Spread>> measureInTurn(const std::vector<Measurement>& measurements, int rounds);

// Of one call, by the steady clock.
double millisecondsOf(const std::function<void()>& work);

}  // namespace bakelight::report
