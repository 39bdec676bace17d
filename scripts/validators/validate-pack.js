// Checks one pack with the Khronos glTF validator and against docs/schema. Prints counts by severity and each finding;
// exits 1 if there is an error.
'use strict';
const fs = require('fs');
const path = require('path');
const { createRequire } = require('module');

const [modules, file] = process.argv.slice(2);
const load = createRequire(path.join(modules, 'package.json'));
const validator = load('gltf-validator');
const Ajv2020 = load('ajv/dist/2020');

const schemaPath = path.join(__dirname, '../../docs/schema/BAKELIGHT_radiance_transfer.schema.json');

function jsonChunk(bytes) {
  if (bytes.length < 20 || bytes.toString('latin1', 0, 4) !== 'glTF') throw new Error('not a binary glTF file');
  return JSON.parse(bytes.toString('utf8', 20, 20 + bytes.readUInt32LE(12)));
}

async function main() {
  const bytes = fs.readFileSync(file);
  const { issues } = await validator.validateBytes(new Uint8Array(bytes), { uri: path.basename(file) });
  const check = new Ajv2020({ allErrors: true }).compile(JSON.parse(fs.readFileSync(schemaPath, 'utf8')));
  const conforms = check(jsonChunk(bytes));

  for (const issue of issues.messages) console.log(`  ${issue.code} ${issue.pointer || ''}: ${issue.message}`);
  for (const error of check.errors || []) console.log(`  schema ${error.instancePath}: ${error.message}`);
  console.log(`${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} infos, ` +
              `${issues.numHints} hints; ${conforms ? 'conforms' : 'does not conform'} to the schema`);
  process.exitCode = issues.numErrors === 0 && conforms ? 0 : 1;
}

main().catch((error) => {
  console.error(`${file}: ${error.message}`);
  process.exitCode = 2;
});
