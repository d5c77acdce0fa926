// The tracks of a report of `t4d track --json`: colours of components, and the list of events.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { makeElement, makePage, wholePage } from '../build.mjs';
import { launch, openPage, serve } from '../browser.mjs';
import { componentsOf } from '../src/components.js';
import { trackColor, Tracks } from '../src/tracks.js';

const here = path.dirname(fileURLToPath(import.meta.url));
const root = path.resolve(here, '../../..');
const build = process.env.T4D_BUILD ?? path.join(root, 'build/release');
const folder = path.join(root, 'build/web-test/tracks');
const at = (name) => path.join(folder, name);
const run = (program, ...args) => execFileSync(path.join(build, program), args.map(String), { encoding: 'utf8' });

let browser;
let site;
let report;
before(async () => {
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  run('t4d-fixtures', at('fx'));
  run('t4d', 'mill', at('fx/cube.obj'), '--tool', 'flat:d=4,l=30', '--gcode', at('fx/parting.nc'), '--voxel-size', 1,
    '--frames', 12, '--up', 'z', '-q', '-o', at('parted.t4d'));
  writeFileSync(at('parted.json'), run('t4d', 'track', at('parted.t4d'), '--json'));
  report = JSON.parse(readFileSync(at('parted.json')));
  run('t4d', 'view', at('parted.t4d'), '--tracks', at('parted.json'), '-o', at('parted.html'));
  const element = await makeElement();
  const withTracks = (tracks) => Buffer.from('<!doctype html><link rel="icon" href="data:,"><body><script src="t4d-view.js"></script>'
    + `<t4d-view src="parted.t4d" tracks="${tracks}" controls></t4d-view>`);
  site = await serve({
    'parted.t4d': at('parted.t4d'), 'parted.json': at('parted.json'), 't4d-view.js': Buffer.from(element),
    'page.html': withTracks('parted.json'), 'none.html': withTracks('none.json'), 'other.html': withTracks('parted.t4d'),
    'program.html': at('parted.html'), 'index.html': Buffer.from(wholePage(await makePage(), element)),
  });
  browser = await launch();
});
after(async () => {
  await browser?.close();
  site?.close();
});

async function openElement(name) {
  const page = await browser.newPage({ viewport: { width: 640, height: 480 } });
  page.setDefaultTimeout(60_000);
  await page.goto(site.url + name);
  await page.evaluate(() => document.querySelector('t4d-view').drawn());
  return page;
}

/** The colours of the triangles at a time, as the GPU has them. */
const colorsAt = (page, time) => page.evaluate(async (t) => {
  const view = document.querySelector('t4d-view');
  view.time = t;
  await view.drawn();
  const [mesh] = [...view.viewer.model.panes[0].sections.values()];
  const { colorMode, values } = mesh.material.uniforms;
  const rows = Array.from({ length: mesh.numTriangles }, (_, i) => [...values.value.image.data.slice(4 * i, 4 * i + 3)].join());
  return { mode: colorMode.value, colors: [...new Set(rows)].sort() };
}, time);

test('each component has the colour of its track, as long as this lives', async () => {
  const page = await openElement('page.html');
  const { tracks, events: [{ time: split }] } = report;
  assert.deepEqual(tracks.map(({ into }) => into), [[2, 3], [], []]);
  for (const time of [0.3, 1, split - 1e-3, split + 1e-3, 5.2, 6]) {
    const alive = tracks.filter(({ begin, end }) => begin <= time && time <= end).map(({ id }) => id);
    const { mode, colors } = await colorsAt(page, time);
    assert.equal(mode, 7);
    assert.deepEqual(colors, alive.map((id) => [...new Float32Array(trackColor(id))].join()).sort(), `at ${time}`);
  }
  await page.close();
});

test('an event of the list shows its time and its place, by the pointer and by the keyboard', async () => {
  const page = await openElement('page.html');
  const [event] = report.events;
  const state = () => page.evaluate(() => {
    const view = document.querySelector('t4d-view');
    const at = view.shadowRoot.activeElement?.textContent;
    return { time: view.time, target: view.camera.slice(3), at, center: view.viewer.model.center };
  });
  await page.evaluate(() => { document.querySelector('t4d-view').viewer.model.set({ cut: 'x' }); });
  await page.locator('#eventCount').focus();
  await page.keyboard.press('Enter');
  await page.keyboard.press('Tab');
  await page.keyboard.press('Enter');
  const { time, target, at: text, center } = await state();
  assert.equal(time, event.time);
  assert.match(text, /splits {2}1 → 2 3$/);
  // z is up: the picture has x, z, -y.
  const [x, y, z] = event.place.map((value, i) => value - center[i]);
  [x, z, -y].forEach((value, i) => assert.ok(Math.abs(value - target[i]) < 1e-9, `${target}`));
  assert.equal(await page.locator('#eventList [aria-current]').count(), 1);
  await page.evaluate(() => { document.querySelector('t4d-view').time = 0; });
  assert.equal(await page.locator('#eventList [aria-current]').count(), 0);
  await page.locator('#eventList button').click();
  assert.equal((await state()).time, event.time);
  await page.close();
});

test('a page of the program has the tracks, and a file that is opened instead has none', async () => {
  const { page, errors } = await openPage(browser, `${site.url}program.html`);
  await page.evaluate(() => window.t4dViewer.whole());
  assert.equal(await page.locator('#color').inputValue(), 'track');
  assert.equal(await page.locator('#eventList button').count(), 1);
  await page.evaluate(async (url) => {
    await window.t4dViewer.open(url);
    await window.t4dViewer.whole();
  }, `${site.url}parted.t4d`);
  assert.equal(await page.locator('#color').inputValue(), 'body');
  assert.equal(await page.locator('#events').isVisible(), false);
  assert.deepEqual(errors, []);
  await page.close();
});

test('what is no report is told, and the mesh is shown', async () => {
  for (const [name, expected] of [['none.html', /none\.json: the server answers 404/], ['other.html', /parted\.t4d: /]]) {
    const page = await openElement(name);
    assert.match(await page.locator('#message:visible').innerText(), expected);
    assert.equal(await page.evaluate(() => document.querySelector('t4d-view').viewer.model.panes.length), 1);
    assert.equal(await page.locator('#events').isVisible(), false);
    await page.close();
  }
  assert.throws(() => new Tracks({ tracks: [] }), /no report/);
});

test('surfaces that touch at a vertex are two components, and a cavity is of the solid around it', () => {
  // Corners on vertices of height 0: two tetrahedra with one vertex in common, the second within a third.
  const place = (x, y, z) => [x, y, z, 0];
  const tetrahedron = ([x, y, z], size) => [place(x, y, z), place(x + size, y, z), place(x, y + size, z), place(x, y, z + size)];
  const faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
  const vertices = [...tetrahedron([0, 0, 0], 1), ...tetrahedron([-1, -1, -1], 9), place(-0.5, 0, 0), place(0, -0.5, 0), place(0, 0, -0.5)].flat();
  const solid = (numbers, turned) => faces.map((face) => (turned ? [...face].reverse() : face).map((i) => [numbers[i], numbers[i]]));
  const triangles = [...solid([0, 1, 2, 3], false), ...solid([4, 5, 6, 7], false), ...solid([0, 8, 9, 10], false)];
  const { components, ofTriangle } = componentsOf(Float64Array.from(vertices), triangles, new Float64Array(11));
  assert.deepEqual([...ofTriangle], [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2]);
  assert.ok(Math.abs(components[1].volume - 9 ** 3 / 6) < 1e-9, `${components[1].volume}`);
  assert.ok(components[2].volume < 0);
  const sample = { time: 0, min: [-1, -1, -1], max: [8, 8, 8] };
  const tracks = new Tracks({ events: [], tracks: [{ id: 7, body: 'b', kind: 'solid', begin: 0, end: 1, samples: [sample] }] });
  assert.deepEqual(tracks.idsOf('b', components, 0.5), [0, 7, 7]);
});
