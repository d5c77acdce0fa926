// The JSON Schema of motion files accepts and rejects the same files as the program.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import Ajv from 'ajv';

import { fixturesIn, makeFolder, readJson, root, t4dRaw } from './t4d.mjs';

const folder = makeFolder('motion');
const isMotion = new Ajv({ strict: true, strictTypes: false, strictRequired: false })
  .compile(readJson(path.join(root, 't4d/formats/motion.schema.json')));

const programAccepts = (motionFile) =>
  t4dRaw('sweep', path.join(folder, 'fixtures/cube.obj'), '--motion', motionFile, '--steps', 1,
    '-o', path.join(folder, 'out.t4d')).status === 0;

for (const file of fixturesIn(folder, '.json')) {
  test(`accepted: ${path.basename(file)}`, () => {
    assert.ok(isMotion(readJson(file)), JSON.stringify(isMotion.errors));
    assert.ok(programAccepts(file));
  });
}

const rest = { duration: 1 };
const refused = {
  'not an object': [],
  'neither segments nor poses': { length_unit: 'mm' },
  'segments and poses': { segments: [rest], poses: [{ time: 0 }, { time: 1 }] },
  'no segment': { segments: [] },
  'one pose': { poses: [{ time: 0 }] },
  'start time with poses': { start_time: 1, poses: [{ time: 0 }, { time: 1 }] },
  'a segment without duration': { segments: [{ translation: [0, 0, 1] }] },
  'duration of zero': { segments: [{ duration: 0 }] },
  'duration as text': { segments: [{ duration: '1' }] },
  'an angle without axis': { segments: [{ duration: 1, angle_degrees: 90 }] },
  'two coordinates': { segments: [{ duration: 1, translation: [0, 1] }] },
  'half a repetition': { segments: [{ duration: 1, repeat: 0.5 }] },
  'no repetition': { segments: [{ duration: 1, repeat: 0 }] },
  'an unknown member': { segments: [{ duration: 1, angle: 90 }] },
  'an unknown member at the top': { segments: [rest], unit: 'mm' },
  'a quaternion of three': { poses: [{ time: 0 }, { time: 1, quaternion: [0, 0, 1] }] },
  'a pose without time': { poses: [{ time: 0 }, { position: [0, 0, 1] }] },
};
for (const [name, motion] of Object.entries(refused)) {
  test(`refused: ${name}`, () => {
    assert.equal(isMotion(motion), false);
    const file = path.join(folder, 'refused.json');
    writeFileSync(file, JSON.stringify(motion));
    assert.equal(programAccepts(file), false);
  });
}
