// How far along the view's axis what a light sees is from it.
layout(location = 0) out float depth;

void main() { depth = 1.0 / gl_FragCoord.w; }
