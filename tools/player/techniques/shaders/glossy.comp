// Exit radiance towards the eye, in every frame: what the material reflects of each vertex's transferred radiance
// (transport/glossy.h), on top of the diffuse part. Definitions: ROW_ORDER, OBJECT_FRAME if transferred radiance is in
// the object's frame rather than the surface's, and for a BRDF table BRDF_ANGLES and BRDF_COEFFICIENTS.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Transferred { float transferred[]; };  // n × ROW_ORDER² × RGB
layout(std430, binding = 1) readonly buffer Positions { float positions[]; };      // XYZ, XYZ, ...
layout(std430, binding = 2) writeonly buffer ExitRadiance { float radiance[]; };   // RGB, RGB, ...
layout(std430, binding = 3) readonly buffer Normals { float normals[]; };          // XYZ, XYZ, ...
layout(std430, binding = 4) readonly buffer Tangents { vec4 tangents[]; };         // w: sign of the bitangent
layout(std430, binding = 5) readonly buffer Diffuse { float diffuse[]; };          // RGB, RGB, ...
#ifdef BRDF_ANGLES
layout(std430, binding = 6) readonly buffer Brdf { float brdf[]; };  // angles × RGB × BRDF_COEFFICIENTS
#endif

layout(location = 0) uniform uint vertex_end;    // in the bound range
layout(location = 1) uniform vec3 eye;           // where positions are
#ifndef BRDF_ANGLES
layout(location = 2) uniform vec3 specular_color;
layout(location = 3) uniform float kernel[10];  // a band
#endif
layout(location = 13) uniform uint vertex_first;

vec3 transferredAt(uint vertex, uint l, int m) {
  uint at = 3u * (vertex * uint(ROW_ORDER * ROW_ORDER) + uint(int(l * (l + 1u)) + m));
  return vec3(transferred[at], transferred[at + 1u], transferred[at + 2u]);
}

#ifdef BRDF_ANGLES

float brdfAt(uint angle, uint channel, uint i) {
  return brdf[(angle * 3u + channel) * BRDF_COEFFICIENTS + i];
}

// transport::tableRows: linear between the two nearest angles, turned about z by the eye's azimuth.
vec3 reflected(uint vertex, vec3 local_eye) {
  float position = clamp(abs(local_eye.z), 0.0, 1.0) * float(BRDF_ANGLES - 1u);
  uint below = min(uint(position), uint(max(int(BRDF_ANGLES) - 2, 0)));
  uint above = min(below + 1u, BRDF_ANGLES - 1u);
  float share = position - float(below);
  float radius = length(local_eye.xy);
  vec2 azimuth = radius > 0.0 ? local_eye.xy / radius : vec2(1.0, 0.0);
  vec3 sum = vec3(0.0);
  float cosine = 1.0, sine = 0.0;  // of m times the azimuth
  for (uint m = 0u; m < ROW_ORDER; ++m) {
    for (uint l = m; l < ROW_ORDER; ++l) {
      uint i = l * (l + 1u) + m;
      vec3 low = vec3(brdfAt(below, 0u, i), brdfAt(below, 1u, i), brdfAt(below, 2u, i));
      vec3 high = vec3(brdfAt(above, 0u, i), brdfAt(above, 1u, i), brdfAt(above, 2u, i));
      vec3 wave = cosine * transferredAt(vertex, l, int(m));
      if (m > 0u) wave += sine * transferredAt(vertex, l, -int(m));
      sum += mix(low, high, share) * wave;
    }
    float next_cosine = azimuth.x * cosine - azimuth.y * sine;
    sine = azimuth.x * sine + azimuth.y * cosine;
    cosine = next_cosine;
  }
  return sum;
}

#else

// Σ_lm kernel_l y_lm(direction) transferred_lm, by the recurrences of transport/sh.cpp: Cartesian, so the poles need no
// special case.
vec3 lobeAround(uint vertex, vec3 direction) {
  vec3 sum = vec3(0.0);
  float cosine = 1.0, sine = 0.0;      // (x + iy)^m
  float diagonal = 0.28209479177387814;  // √(1/4π)
  for (uint m = 0u; m < ROW_ORDER; ++m) {
    float m2 = float(m * m);
    float below = 0.0, here = diagonal;
    for (uint l = m; l < ROW_ORDER; ++l) {
      if (l > m) {
        float l2 = float(l * l), below2 = float((l - 1u) * (l - 1u));
        float rise = sqrt((4.0 * l2 - 1.0) / (l2 - m2));
        float fall = l >= 2u ? sqrt((below2 - m2) / (4.0 * below2 - 1.0)) : 0.0;
        float above = rise * (direction.z * here - fall * below);
        below = here;
        here = above;
      }
      vec3 wave = cosine * transferredAt(vertex, l, int(m));
      if (m > 0u) wave = 1.4142135623730951 * (wave + sine * transferredAt(vertex, l, -int(m)));
      sum += kernel[l] * here * wave;
    }
    diagonal *= sqrt(float(2u * m + 3u) / float(2u * m + 2u));
    float next_cosine = direction.x * cosine - direction.y * sine;
    sine = direction.x * sine + direction.y * cosine;
    cosine = next_cosine;
  }
  return sum;
}

#endif

void main() {
  uint vertex = vertex_first + gl_GlobalInvocationID.x;
  if (vertex >= vertex_end) return;
  uint first = 3u * vertex;
  vec3 normal = vec3(normals[first], normals[first + 1u], normals[first + 2u]);
  vec3 tangent = tangents[vertex].xyz;
  vec3 bitangent = tangents[vertex].w * cross(normal, tangent);
  vec3 to_eye = normalize(eye - vec3(positions[first], positions[first + 1u], positions[first + 2u]));
  vec3 local_eye = vec3(dot(to_eye, tangent), dot(to_eye, bitangent), dot(to_eye, normal));
#ifdef BRDF_ANGLES
  vec3 sum = reflected(vertex, local_eye);
#else
  vec3 reflection = vec3(-local_eye.xy, abs(local_eye.z));
#ifdef OBJECT_FRAME
  reflection = reflection.x * tangent + reflection.y * bitangent + reflection.z * normal;
#endif
  vec3 sum = specular_color * lobeAround(vertex, reflection);
#endif
  radiance[first] = diffuse[first] + sum.r;
  radiance[first + 1u] = diffuse[first + 1u] + sum.g;
  radiance[first + 2u] = diffuse[first + 2u] + sum.b;
}
