// Principal components of many samples of many numbers.
#pragma once

#include <Eigen/Core>

namespace bakelight::mesomesh {

// A row a sample.
using Samples = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The score of a sample is (sample − mean) · axes.
struct PrincipalComponents {
  Eigen::RowVectorXf mean;
  Eigen::MatrixXf axes;          // dimensions × components, orthonormal, by falling variance
  double retained_variance = 1;  // share of the samples' variance that the scores hold; 1 where there is none

  Samples scores(const Samples& samples) const { return (samples.rowwise() - mean) * axes; }
};

// At most `count` components and at least one; fewer where the samples vary in fewer dimensions. Exact up to 160
// dimensions; above, subspace iteration from a fixed start until the retained variance stands still (Halko,
// Martinsson, Tropp 2011, "Finding structure with randomness"). The same bytes on every run.
PrincipalComponents principalComponents(Samples samples, int count);

}  // namespace bakelight::mesomesh
