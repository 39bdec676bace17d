// Projection of a cube map into spherical harmonics, first half: each row of texels of each face for itself, so that the
// order of the sum is fixed. One work item a row and coefficient.
layout(local_size_x = 64) in;

layout(std430, binding = 2) writeonly buffer RowSums { vec4 row_sums[]; };            // rows of all faces × coefficients
layout(std430, binding = 3) readonly buffer WeightedBasis { float weighted_basis[]; };  // coefficients × texels of all faces
layout(binding = 0) uniform sampler2DArray faces;

layout(location = 0) uniform uint coefficient_count;

void main() {
  uint size = uint(textureSize(faces, 0).x);
  uint row_count = 6u * size;
  uint item = gl_GlobalInvocationID.x;
  if (item >= row_count * coefficient_count) return;
  uint row = item / coefficient_count, coefficient = item % coefficient_count;
  uint first = (coefficient * row_count + row) * size;
  vec3 sum = vec3(0.0);
  for (uint x = 0u; x < size; ++x)
    sum += texelFetch(faces, ivec3(x, row % size, row / size), 0).rgb * weighted_basis[first + x];
  row_sums[item] = vec4(sum, 0.0);
}
