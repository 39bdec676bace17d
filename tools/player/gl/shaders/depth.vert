layout(location = 0) in vec3 position;  // from the centre of the object's bounding sphere

layout(location = 0) uniform mat4 clip_from_position;

invariant gl_Position;  // the same depth as that of whoever draws over it

void main() { gl_Position = clip_from_position * vec4(position, 1.0); }
