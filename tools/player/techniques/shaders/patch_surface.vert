// Definitions: GROUPS of four components that this draw adds up; CREASES if some triangles are not interpolated across.
layout(location = 0) in vec3 position;  // from the mesh's origin
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 tangent;  // w: sign of the bitangent
layout(location = 3) in vec2 texcoord;
layout(location = 4) in vec4 projected[3 * GROUPS];  // RGB of four components each

layout(location = 0) uniform mat4 clip_from_position;

out vec3 surface_position, surface_normal;
out vec4 surface_tangent;
out vec2 surface_texcoord;
out vec4 incident[3 * GROUPS];
#ifdef CREASES
// Of triangles that are there three times: whose corner this one shows, −1 for others, and barycentric coordinates.
layout(location = 33) uniform int first_creased;
flat out int shown_corner;
out vec2 corner_weights;
#endif

invariant gl_Position;

void main() {
  surface_position = position;
  surface_normal = normal;
  surface_tangent = tangent;
  surface_texcoord = texcoord;
  incident = projected;
#ifdef CREASES
  int creased = gl_VertexID - first_creased;
  shown_corner = creased < 0 ? -1 : creased / 3 % 3;
  corner_weights = vec2(creased % 3 == 0, creased % 3 == 1);
#endif
  gl_Position = clip_from_position * vec4(position, 1.0);
}
