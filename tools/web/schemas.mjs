// JSON Schemas of the project, in ajv's strictest mode.
import assert from 'node:assert/strict';
import path from 'node:path';

import Ajv from 'ajv/dist/2020.js';

import { readJson, root } from './t4d.mjs';

/** The schema FILE of the project, as checkerOf gives it. */
export function schemaOf(file) {
  return checkerOf(readJson(path.join(root, file)));
}

/** The schemas of the reports of all verbs below a command, by their words with hyphens between. */
export function reportSchemas({ verbs }, words = []) {
  return new Map(verbs.flatMap((verb) => {
    const all = [...words, verb.name];
    return [...(verb.report ? [[all.join('-'), checkerOf(verb.report)]] : []), ...reportSchemas(verb, all)];
  }));
}

/** A schema as {schema, check(value, what), accepts(value)}. */
export function checkerOf(schema) {
  const fits = new Ajv({
    strict: true,
    strictTypes: true,
    strictTuples: true,
    strictRequired: true,
    allowUnionTypes: true,
    allErrors: true,
  }).compile(schema);
  return {
    schema,
    accepts: (value) => fits(value),
    check: (value, what) =>
      assert.ok(fits(value), `${what}: ${JSON.stringify(fits.errors, null, 1)}`),
  };
}

/** Calls visit(subschema, where) for a schema and all schemas within it. */
export function walkSchema(schema, visit, where = '#') {
  if (typeof schema !== 'object' || schema === null) return;
  if (!Array.isArray(schema)) visit(schema, where);
  for (const [key, value] of Object.entries(schema)) walkSchema(value, visit, `${where}/${key}`);
}

/** Every object in a JSON value, with its path; skips members named in `except`. */
export function* objectsIn(value, except = [], where = '') {
  if (typeof value !== 'object' || value === null) return;
  if (!Array.isArray(value)) yield { object: value, where };
  for (const [key, member] of Object.entries(value)) {
    if (!except.includes(key)) yield* objectsIn(member, except, `${where}/${key}`);
  }
}
