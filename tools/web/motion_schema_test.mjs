// The JSON Schemas of motion files and mechanisms accept and reject the same files as the program.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import Ajv from 'ajv';

import { fixturesIn, makeFolder, readJson, root, t4dRaw } from './t4d.mjs';

const folder = makeFolder('motion');
const schemaOf = (name) => new Ajv({ strict: true, strictTypes: false, strictRequired: false })
  .compile(readJson(path.join(root, `formats/motion/${name}.schema.json`)));
const isMotion = schemaOf('motion');
const isMechanism = schemaOf('mechanism');

const sweeps = (...words) =>
  t4dRaw('sweep', ...words, '--steps', 1, '--caps', 'cone', '-o', path.join(folder, 'out.t4d'))
    .status === 0;
const programAccepts = (motionFile) =>
  sweeps(path.join(folder, 'fixtures/cube.obj'), '--motion', motionFile);

for (const file of fixturesIn(folder, '.json')) {
  const mechanism = 'bodies' in readJson(file);
  const schema = mechanism ? isMechanism : isMotion;
  test(`accepted: ${path.basename(file)}`, () => {
    assert.ok(schema(readJson(file)), JSON.stringify(schema.errors));
    assert.ok(mechanism ? sweeps(file) : programAccepts(file));
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

const axis = [0, 0, 1];
const turning = {
  name: 'a',
  solid: { box: [1, 1, 1] },
  joint: { type: 'revolute', axis },
  motion: { times: [0, 1], values: [0, 1] },
};
const mechanism = (...bodies) => ({ angle_unit: 'deg', bodies });
const withJoint = (joint) => mechanism({ ...turning, joint: { ...turning.joint, ...joint } });
const withMotion = (motion) => mechanism({ ...turning, motion });
const refusedMechanisms = {
  'no body': mechanism(),
  'no bodies': { angle_unit: 'deg' },
  'a body without name': mechanism({ ...turning, name: undefined }),
  'an unknown member': mechanism({ ...turning, mass: 1 }),
  'an unknown unit of angles': { ...mechanism(turning), angle_unit: 'gon' },
  'two basic solids': mechanism({ ...turning, solid: { box: [1, 1, 1], sphere: 1 } }),
  'a box of two sides': mechanism({ ...turning, solid: { box: [1, 1] } }),
  'a sphere of radius 0': mechanism({ ...turning, solid: { sphere: 0 } }),
  'a cylinder without length': mechanism({ ...turning, solid: { cylinder: { radius: 1 } } }),
  'an unknown joint': withJoint({ type: 'hinge' }),
  'a joint without axis': withJoint({ axis: undefined }),
  'a fixed joint with an axis': withJoint({ type: 'fixed' }),
  'a screw without pitch': withJoint({ type: 'screw' }),
  'a pitch of another joint': withJoint({ pitch: 1 }),
  'one limit': withJoint({ limits: [1] }),
  'values without times': withMotion({ values: [0, 1] }),
  'one value': withMotion({ times: [0], values: [0] }),
  'a column without file': withMotion({ column: 'a' }),
  'a ratio without follows': withMotion({ ratio: 2 }),
};
test('accepted: the mechanism that the others are made of', () => {
  assert.ok(isMechanism(mechanism(turning)), JSON.stringify(isMechanism.errors));
});
for (const [name, value] of Object.entries(refusedMechanisms)) {
  test(`refused: ${name}`, () => {
    const file = path.join(folder, 'refused.json');
    writeFileSync(file, JSON.stringify(value));
    assert.equal(isMechanism(readJson(file)), false);
    assert.equal(sweeps(file), false);
  });
}
