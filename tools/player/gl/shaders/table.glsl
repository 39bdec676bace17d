// A formats::EncodedTable at its precision (tools/player/gl/gpu_table.h); rows of the bound range.
layout(std430, binding = 0) readonly buffer TableWords { uint table_words[]; };
#ifdef TABLE_UINT8
layout(std430, binding = 1) readonly buffer Quantization { vec2 scale_and_offset[]; };  // a column
#endif

float tableValue(uint row, uint column) {
  uint element = row * TABLE_COLUMNS + column;
#if defined(TABLE_FLOAT16)
  vec2 pair = unpackHalf2x16(table_words[element >> 1u]);
  return (element & 1u) == 0u ? pair.x : pair.y;
#elif defined(TABLE_UINT8)
  uint code = (table_words[element >> 2u] >> (8u * (element & 3u))) & 255u;
  vec2 column_range = scale_and_offset[column];
  return column_range.y + column_range.x * float(code);
#else
  return uintBitsToFloat(table_words[element]);
#endif
}
