// Gives a PLY mesh, as simplify writes it, texture coordinates by xatlas (WebAssembly, one thread). Prints one line of JSON.
//   node xatlas.js MODULES IN.ply OUT.ply RESOLUTION GUTTER
'use strict';
const fs = require('fs');
const path = require('path');
const { createRequire } = require('module');

const [modules, input, output, resolution, gutter] = process.argv.slice(2);

// Positions, normals if there are any, and indices.
function readMesh(file) {
  const bytes = fs.readFileSync(file);
  const begin = bytes.indexOf('end_header\n') + 'end_header\n'.length;
  const header = bytes.toString('latin1', 0, begin);
  const count = (element) => Number(new RegExp(`^element ${element} (\\d+)$`, 'm').exec(header)?.[1]);
  const vertexCount = count('vertex'), faceCount = count('face');
  const names = [...header.matchAll(/^property float (\w+)$/gm)].map((match) => match[1]);
  const indicesBegin = begin + 4 * names.length * vertexCount;
  if (!header.startsWith('ply\nformat binary_little_endian 1.0\n') || !header.includes('property list uchar uint vertex_indices') ||
      bytes.length !== indicesBegin + 13 * faceCount)
    throw new Error('not a PLY mesh as simplify writes it');

  const vectors = (first) => {
    const offset = names.indexOf(first);
    const result = new Float32Array(3 * vertexCount);
    for (let i = 0; i < result.length; ++i)
      result[i] = bytes.readFloatLE(begin + 4 * (names.length * Math.floor(i / 3) + offset + (i % 3)));
    return result;
  };
  const indices = new Uint32Array(3 * faceCount);
  for (let i = 0; i < indices.length; ++i) indices[i] = bytes.readUInt32LE(indicesBegin + 13 * Math.floor(i / 3) + 1 + 4 * (i % 3));
  return { vertexCount, faceCount, positions: vectors('x'), normals: names.includes('nx') ? vectors('nx') : null, indices };
}

// xatlas copies vertices along its seams: `result` says of which vertex each is one. Its square may be any rectangle;
// the longer side becomes 1, so that nothing is stretched.
function writeMesh(file, mesh, result, side) {
  const names = ['x', 'y', 'z', ...(mesh.normals ? ['nx', 'ny', 'nz'] : []), 's', 't'];
  const header = 'ply\nformat binary_little_endian 1.0\n' + `element vertex ${result.vertexCount}\n` +
      names.map((name) => `property float ${name}\n`).join('') +
      `element face ${mesh.faceCount}\nproperty list uchar uint vertex_indices\nend_header\n`;
  const vertices = Buffer.alloc(4 * names.length * result.vertexCount);
  let at = 0;
  for (let i = 0; i < result.vertexCount; ++i) {
    const { xref, uv } = result.getVertex(i);
    const values = [mesh.positions, mesh.normals].flatMap((array) => (array ? [...array.subarray(3 * xref, 3 * xref + 3)] : []));
    for (const value of [...values, uv[0] / side, uv[1] / side]) at = vertices.writeFloatLE(value, at);
  }
  const indices = new Uint32Array(result.indexCount);
  result.getIndexArray(indices);
  const faces = Buffer.alloc(13 * mesh.faceCount);
  for (let face = 0; face < mesh.faceCount; ++face) {
    faces[13 * face] = 3;
    for (let k = 0; k < 3; ++k) faces.writeUInt32LE(indices[3 * face + k], 13 * face + 1 + 4 * k);
  }
  fs.writeFileSync(file, Buffer.concat([Buffer.from(header), vertices, faces]));
}

async function main() {
  const watlas = createRequire(path.join(modules, 'package.json'))('watlas');
  const mesh = readMesh(input);
  await watlas.Initialize();
  const atlas = new watlas.Atlas();
  const start = process.hrtime.bigint();
  atlas.addMesh({
    vertexPositionData: mesh.positions, vertexCount: mesh.vertexCount, vertexPositionStride: 12,
    ...(mesh.normals && { vertexNormalData: mesh.normals, vertexNormalStride: 12 }),
    indexData: mesh.indices, indexCount: mesh.indices.length,
  });
  // Its padding is around each chart, so that gutters are twice as wide; texels for bilinear filtering would come on top.
  atlas.generate({}, { resolution: Number(resolution), padding: Math.ceil(Number(gutter) / 2), bilinear: false });
  const seconds = Number(process.hrtime.bigint() - start) / 1e9;
  if (atlas.atlasCount !== 1) throw new Error(`xatlas made ${atlas.atlasCount} atlases of it, where one is to be judged`);

  const utilisation = new Float32Array(1);
  atlas.getUtilization(utilisation);
  writeMesh(output, mesh, atlas.getMesh(0), Math.max(atlas.width, atlas.height));
  console.log(JSON.stringify({ seconds, charts: atlas.chartCount, width: atlas.width, height: atlas.height, utilisation: utilisation[0] }));
}

main().catch((error) => {
  console.error(`${input}: ${error.message}`);
  process.exitCode = 2;
});
