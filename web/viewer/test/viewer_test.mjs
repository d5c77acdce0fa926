// The page in Chromium: what it shows, what it reads, and what it says of damaged files.
import assert from 'node:assert/strict';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import net from 'node:net';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { measure, open } from 't4d-reader';

import { makeElement, makePage, wholePage } from '../build.mjs';
import { launch, openPage, serve } from '../browser.mjs';
import { colorsOf } from '../src/colors.js';
import { stateOf } from '../src/state.js';

const here = path.dirname(fileURLToPath(import.meta.url));
const root = path.resolve(here, '../../..');
const build = process.env.T4D_BUILD ?? path.join(root, 'build/release');
const folder = path.join(root, 'build/web-test/viewer');
const at = (name) => path.join(folder, name);
const run = (program, ...args) => execFileSync(path.join(build, program), args.map(String), { encoding: 'utf8' });
const t4d = (...args) => JSON.parse(run('t4d', ...args, '--json'));

let browser;
let site;
before(async () => {
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  run('t4d-fixtures', at('fx'));
  t4d('sweep', at('fx/cube.obj'), '--motion', at('fx/several-segments.json'), '-o', at('cube.t4d'));
  t4d('sweep', at('fx/torus.obj'), '--motion', at('fx/skew-axis.json'), '--up', 'z', '-o', at('torus.t4d'));
  t4d('sweep', at('fx/two-boxes.obj'), '--motion', at('fx/rest.json'), '--bodies', 'object', '-o', at('boxes.t4d'));
  t4d('sweep', at('fx/torus.obj'), '--motion', at('fx/several-segments.json'), '--backend', 'voxel4d', '--voxel-size', 0.5,
    '--frames', 12, '--compression', 0, '-o', at('large.t4d'));
  t4d('transform', at('cube.t4d'), '--move', 0.5, 0, 0, '-o', at('beside.t4d'));
  t4d('transform', at('cube.t4d'), '--time-shift', 2, '-o', at('late.t4d'));
  t4d('transform', at('torus.t4d'), '--move', 1e6, -1e6, 1e6, '-o', at('far.t4d'));
  writeFileSync(at('viewer.html'), wholePage(await makePage(), await makeElement()));
  const damaged = readFileSync(at('torus.t4d'));
  const { slabs } = (await open(new Uint8Array(damaged))).bodies[0];
  damaged[slabs[4].at + 40] ^= 1;
  const files = Object.fromEntries(['cube', 'torus', 'boxes', 'large', 'beside', 'late', 'far']
    .map((name) => [`${name}.t4d`, at(`${name}.t4d`)]));
  site = await serve({
    'index.html': at('viewer.html'), ...files, 'damaged.t4d': damaged, 'cut-off.t4d': damaged.subarray(0, 5000),
    'text.t4d': new TextEncoder().encode('This is no 4D mesh, but some other text.'),
  });
  browser = await launch();
});
after(async () => {
  await browser?.close();
  site?.close();
});

const openAt = (query, options) => openPage(browser, `${site.url}${query}`, options);
const shownMeasures = (page, state) => page.evaluate(async (changes) => {
  window.t4dViewer.set(changes);
  await window.t4dViewer.whole();
  return window.t4dViewer.measures();
}, state);

/** Compares numbers in float32, relative to the larger of 1 and the expected one. */
const isNear = (found, expected, what) =>
  assert.ok(Math.abs(found - expected) <= 2e-5 * Math.max(1, Math.abs(expected)), `${what}: ${found}, expected ${expected}`);

function sameAsProgram(found, expected, what) {
  assert.equal(found.numTriangles, expected.triangles, what);
  isNear(found.volume, expected.volume, `${what}: volume`);
  isNear(found.area, expected.area, `${what}: area`);
}

for (const name of ['cube', 'torus']) {
  test(`${name}: the GPU cuts at times what the program cuts`, async () => {
    const { page, errors } = await openAt(`?file=${name}.t4d`);
    const { slab_list: slabs, time_begin: begin, time_end: end } = t4d('info', at(`${name}.t4d`), '--slabs').bodies[0];
    // Layers, the first and the last time, and between.
    const times = [begin, end, slabs[3].begin, slabs.at(-3).end];
    for (let i = 0; i < 8; ++i) times.push(begin + (end - begin) * (i + 0.3) / 8);
    for (const t of times) {
      const [found] = await shownMeasures(page, { cut: 't', t });
      sameAsProgram(found, t4d('slice', at(`${name}.t4d`), '--time', t), `${name} at ${t}`);
    }
    assert.deepEqual(errors, []);
    await page.close();
  });

  test(`${name}: the GPU cuts by other hyperplanes what the program cuts`, async () => {
    const { page, errors } = await openAt(`?file=${name}.t4d#cut=x`);
    const bounds = await page.evaluate('window.t4dViewer.panes[0].bounds()');
    for (const [i, axis] of ['x', 'y', 'z'].entries()) {
      for (const share of [0.31, 0.5, 0.77]) {
        const value = bounds.min[i] + share * (bounds.max[i] - bounds.min[i]);
        const [found] = await shownMeasures(page, { cut: axis, [axis]: value });
        sameAsProgram(found, t4d('slice', at(`${name}.t4d`), `--${axis}`, value), `${name}, ${axis} = ${value}`);
      }
    }
    const middle = bounds.min.map((low, i) => (low + bounds.max[i]) / 2);
    for (const normal of [[1, 2, -1, 0.5], [0, 0, 1, 1.5], [-0.25, 0.5, 1, -3]]) {
      const offset = normal.reduce((sum, n, i) => sum + n * middle[i], 0.01);
      const [found] = await shownMeasures(page, { cut: 'any', normal, offset });
      sameAsProgram(found, t4d('slice', at(`${name}.t4d`), `--hyperplane=${[...normal, offset]}`), `${name}, ${normal}`);
    }
    assert.deepEqual(errors, []);
    await page.close();
  });
}

test('the measures on the page are those of the program', async () => {
  const { page } = await openAt('?file=torus.t4d#t=0.4');
  const { triangles, volume } = t4d('slice', at('torus.t4d'), '--time', 0.4);
  await page.waitForFunction((text) => document.getElementById('measures').innerText.includes(text),
    triangles.toLocaleString('en'));
  assert.ok((await page.innerText('#measures')).includes(String(Number(volume.toPrecision(6)))));
  await page.close();
});

test('measures of another slice are marked until those of this one are there', async () => {
  const { page } = await openAt('?file=large.t4d#t=0.4');
  await page.waitForFunction('document.getElementById("measures").ariaBusy === "false"');
  const before = await page.innerText('#measures');
  // This is done in one go, so that the measures cannot come in between.
  const { busy, text } = await page.evaluate(() => {
    window.t4dViewer.set({ t: 1.1 });
    const measures = document.getElementById('measures');
    return { busy: measures.ariaBusy, text: measures.innerText };
  });
  assert.equal(busy, 'true');
  assert.equal(text, before);
  await page.waitForFunction((text) => document.getElementById('measures').innerText !== text, before);
  assert.equal(await page.evaluate('document.getElementById("measures").ariaBusy'), 'false');
  await page.close();
});

test('a measure has its unit where it has one', async () => {
  const { page } = await openAt('?file=torus.t4d');
  const { length_unit: length, time_unit: time } = t4d('info', at('torus.t4d'));
  for (const [cut, unit] of Object.entries({
    t: `volume, ${length}³`, x: `volume, ${length}²·${time}`, z: `volume, ${length}²·${time}`, any: 'volume',
  })) {
    await page.evaluate((to) => window.t4dViewer.set({ cut: to }), cut);
    await page.waitForFunction('document.getElementById("measures").ariaBusy === "false"');
    const titles = await page.locator('#measures td:first-child').allInnerTexts();
    assert.ok(titles.includes(unit), `${cut}: ${titles}`);
  }
  await page.close();
});

test('two files with different units have numbers without one, and say so', async () => {
  const inMetres = at('metres.t4d');
  t4d('transform', at('beside.t4d'), '--length-unit', 'm', '--time-unit', 'min', '-o', inMetres);
  const served = await serve({ 'index.html': at('viewer.html'), 'cube.t4d': at('cube.t4d'), 'm.t4d': inMetres });
  const { page } = await openPage(browser, `${served.url}?file=cube.t4d&file=m.t4d`);
  await page.waitForFunction('document.getElementById("measures").ariaBusy === "false"');
  const titles = await page.locator('#measures td:first-child').allInnerTexts();
  assert.ok(titles.includes('volume') && titles.includes('area'), titles);
  assert.equal(await page.innerText('#unit'), '');
  const { length_unit: length, time_unit: time } = t4d('info', at('cube.t4d'));
  assert.match(await page.innerText('#facts'), new RegExp(`units\\s+${length ?? '\\?'}, ${time ?? '\\?'}\\s+m, min`));
  await page.close();
  served.close();
});

test('each cut says what it means', async () => {
  const { page } = await openAt('?file=cube.t4d');
  const meanings = new Set();
  for (const cut of ['t', 'x', 'y', 'z', 'any', 'solid']) {
    await page.evaluate((to) => window.t4dViewer.set({ cut: to }), cut);
    assert.ok(await page.isVisible('#meaning'));
    meanings.add(await page.innerText('#meaning'));
  }
  assert.equal(meanings.size, 6);
  const all = [...meanings].join(' ');
  for (const word of ['Marks', 'offset', 'hyperplane', 'motion']) assert.ok(all.includes(word), word);
  await page.close();
});

const devices = {
  desktop: { viewport: { width: 1280, height: 800 } },
  tablet: { viewport: { width: 820, height: 1180 }, hasTouch: true, isMobile: true },
  phone: { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true },
};
for (const [device, options] of Object.entries(devices)) {
  test(`on a ${device}, numbers keep to one line, and fingers find what they touch`, async () => {
    for (const query of ['?file=large.t4d', '?file=large.t4d&file=torus.t4d', '?file=far.t4d&file=large.t4d#cut=x']) {
      const { page, errors } = await openAt(query, options);
      await page.waitForFunction('document.getElementById("measures").ariaBusy === "false"');
      const { lines, small, width } = await page.evaluate(() => ({
        lines: [...document.querySelectorAll('td:not(:first-child)')].filter((cell) => cell.getClientRects().length > 0
          && cell.clientHeight >= 2 * parseFloat(getComputedStyle(cell).lineHeight)).map((cell) => cell.textContent),
        small: [document, document.querySelector('t4d-view').shadowRoot]
          .flatMap((root) => [...root.querySelectorAll('button, select, input:not([type="file"])')])
          .filter((each) => each.offsetParent)
          .map((each) => [each.id, (each.type === 'checkbox' ? each.closest('label') : each).getBoundingClientRect()])
          .filter(([, box]) => Math.min(box.width, box.height) < 40).map(([id]) => id),
        width: document.getElementById('panel').scrollWidth - document.getElementById('panel').clientWidth,
      }));
      assert.deepEqual(lines, []);
      assert.ok(width <= 0, `${width} pixels of the panel are cut off`);
      if (options.hasTouch) assert.deepEqual(small, []);
      assert.deepEqual(errors, []);
      await page.close();
    }
  });
}

test('the measures hold far from the origin', async () => {
  const expected = t4d('slice', at('far.t4d'), '--time', 0.4);
  const file = await open(new Uint8Array(readFileSync(at('far.t4d'))));
  const found = measure((await file.slice(0.4))[0]);
  for (const key of ['volume', 'area']) {
    assert.ok(Math.abs(found[key] / expected[key] - 1) < 1e-9, `${key}: ${found[key]}, expected ${expected[key]}`);
  }
  const { page, errors } = await openAt('?file=far.t4d#t=0.4');
  await page.waitForFunction((text) => document.getElementById('measures').innerText.includes(text),
    String(Number(expected.volume.toPrecision(6))));
  assert.deepEqual(errors, []);
  await page.close();
});

const sum = (numbers) => numbers.reduce((all, each) => all + each, 0);

test('a slice at a time takes at most twice the bytes of its slab and parts', async () => {
  const file = await open(`${site.url}large.t4d`);
  const [{ slabs }] = file.bodies;
  for (const number of [5, 2, 9]) {
    const before = file.bytesRead;
    const { begin, end } = slabs[number];
    await file.slabsAt((begin + end) / 2);
    const took = file.bytesRead - before;
    assert.ok(took > 0 && took <= 2 * file.sizeOf(slabs[number]), `${took}, not ${file.sizeOf(slabs[number])}`);
  }
  assert.ok(file.requests <= 1 + 3 * 3, `${file.requests} requests`);

  // The page reads the two next slabs ahead.
  const first = site.requests.length;
  const { page } = await openAt(`?file=large.t4d#t=${(slabs[3].begin + slabs[3].end) / 2}`);
  await page.evaluate('window.t4dViewer.whole()');
  await page.waitForTimeout(1000);
  const [opening, ...others] = site.requests.slice(first).map(({ from, to }) => to - from);
  assert.equal(opening, 256 * 1024);
  const most = 2 * sum(slabs.slice(3, 6).map((slab) => file.sizeOf(slab)));
  assert.ok(sum(others) > 0 && sum(others) <= most, `${sum(others)}, at most ${most}`);
  await page.close();
});

for (const color of ['body', 'time']) test(`a section that is too large for the GPU is cut by the worker, coloured by ${color}`, async () => {
  const { page, errors } = await openAt(`?file=torus.t4d#cut=x&color=${color}`);
  const [pixels, without, kinds] = await page.evaluate(async () => {
    const { panes, whole, set } = window.t4dViewer;
    const canvas = window.t4dViewer.find('canvas');
    const picture = async (budget) => {
      panes[0].budget = budget;
      set({});
      await whole();
      const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
      copy.drawImage(canvas, 0, 0);
      return copy.getImageData(0, 0, canvas.width, canvas.height).data;
    };
    const before = await picture(1e9);
    const after = await picture(1);
    let differ = 0;
    for (let i = 0; i < before.length; i += 4) if (Math.abs(before[i] - after[i]) > 30) ++differ;
    return [differ, before.length / 4, [...panes[0].sections.keys()]];
  });
  assert.deepEqual(kinds, ['cut/0']);
  assert.ok(pixels < without / 500, `${pixels} of ${without} pixels differ`);
  assert.deepEqual(errors, []);
  await page.close();
});

/** Has the worker cut a section, and notes what there is each time that there is more. */
const cutByWorker = (page, state) => page.evaluate(async (changes) => {
  const { panes: [pane], set, whole } = window.t4dViewer;
  const measures = document.getElementById('measures');
  const notes = [];
  const { onChange } = pane;
  pane.onChange = (what) => {
    const section = pane.cut?.sections[0];
    if (section) notes.push({ isSketch: Boolean(section.isSketch), busy: measures.ariaBusy, text: measures.innerText });
    onChange(what);
  };
  pane.budget = 1;
  set(changes);
  await whole();
  pane.onChange = onChange;
  return notes;
}, state);

test('a section of the worker is a sketch at first, with its numbers marked until they are right', async () => {
  const { page, errors } = await openAt('?file=torus.t4d#t=0.4');
  await page.waitForFunction('document.getElementById("measures").ariaBusy === "false"');
  const before = await page.innerText('#measures');
  const notes = await cutByWorker(page, { cut: 'x', x: 0.3 });
  assert.deepEqual(notes.map(({ isSketch }) => isSketch).filter((each, i, all) => each !== all[i - 1]), [true, false]);
  for (const { busy, text } of notes.filter(({ isSketch }) => isSketch)) assert.deepEqual([busy, text], ['true', before]);
  const { triangles, vertices, volume, area } = t4d('slice', at('torus.t4d'), '--x', 0.3);
  await page.waitForFunction('document.getElementById("measures").ariaBusy === "false"');
  const numbers = await page.locator('#measures td:last-child').allInnerTexts();
  assert.deepEqual(numbers, [
    ...[triangles, vertices].map((count) => count.toLocaleString('en')),
    ...[volume, area].map((value) => String(Number(value.toPrecision(6)))),
  ]);
  assert.deepEqual(errors, []);
  await page.close();
});

test('what was not swept is shown when it is cut, with the right numbers', async () => {
  const { page, errors } = await openAt('?file=large.t4d');
  const notes = await cutByWorker(page, { cut: 'y', y: 0.1 });
  assert.ok(notes.every(({ isSketch }) => !isSketch));
  const { triangles } = t4d('slice', at('large.t4d'), '--y', 0.1);
  await page.waitForFunction((text) => document.getElementById('measures').innerText.includes(text), triangles.toLocaleString('en'));
  assert.deepEqual(errors, []);
  await page.close();
});

test('a section of the worker that is left for another comes to nothing', async () => {
  const { page, errors } = await openAt('?file=torus.t4d');
  const { shown, isCutting } = await page.evaluate(async () => {
    const { panes: [pane], set, whole } = window.t4dViewer;
    pane.budget = 1;
    for (let i = 0; i < 40; ++i) {
      set({ cut: 'x', x: 0.1 + i / 100 });
      await new Promise((resolve) => { setTimeout(resolve, i % 4 * 10); });
    }
    await whole();
    return { shown: pane.cut.plane.offset, isCutting: !pane.cut.isWhole };
  });
  assert.deepEqual([shown, isCutting], [0.1 + 39 / 100, false]);
  const { triangles } = t4d('slice', at('torus.t4d'), '--x', shown);
  await page.waitForFunction((text) => document.getElementById('measures').innerText.includes(text), triangles.toLocaleString('en'));
  await page.evaluate(() => window.t4dViewer.set({ x: 0.2 }));
  await page.evaluate(() => { window.t4dViewer.panes[0].budget = 1e9; });
  const [found] = await shownMeasures(page, { cut: 't', t: 0.4 });
  sameAsProgram(found, t4d('slice', at('torus.t4d'), '--time', 0.4), 'after it');
  assert.equal(await page.evaluate('window.t4dViewer.panes[0].cut'), null);
  assert.deepEqual(errors, []);
  await page.close();
});

test('a section that is slow to draw is a sketch while the camera moves', async () => {
  const { page, errors } = await openAt('?file=torus.t4d');
  await cutByWorker(page, { cut: 'x', x: 0.3 });
  const { triangles } = t4d('slice', at('torus.t4d'), '--x', 0.3);
  const [rough, whole] = await page.evaluate(() => [true, false].map((isRough) => {
    const [pane] = window.t4dViewer.panes;
    pane.setRough(isRough);
    return pane.sections.get('cut/0').geometry.index.count / 3;
  }));
  assert.equal(whole, triangles);
  assert.ok(rough > 0 && rough < triangles / 2, `${rough} of ${triangles}`);
  assert.deepEqual(errors, []);
  await page.close();
});

test('edges are lines', async () => {
  const { page, errors } = await openAt('?file=cube.t4d#t=1.9', { viewport: { width: 1280, height: 800 } });
  const [edges, solid] = await page.evaluate(async () => {
    const { whole, set } = window.t4dViewer;
    const canvas = window.t4dViewer.find('canvas');
    const picture = async (wire) => {
      set({ wire });
      await whole();
      const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
      copy.drawImage(canvas, 0, 0);
      return copy.getImageData(0, 0, canvas.width, canvas.height).data;
    };
    const without = await picture(false);
    const wired = await picture(true);
    const differs = (a, i, b, k) => Math.abs(a[i] - b[k]) > 30;
    let numEdges = 0;
    let numSolid = 0;
    for (let i = 0; i < without.length; i += 4) {
      if (differs(without, i, without, 0)) ++numSolid;
      if (differs(without, i, wired, i)) ++numEdges;
    }
    return [numEdges, numSolid];
  });
  assert.ok(solid > 10_000 && edges > solid / 100 && edges < solid / 4, `${edges} of ${solid} pixels`);
  assert.deepEqual(errors, []);
  await page.close();
});

test('bodies, hidden and not, and their colours', async () => {
  const { page, errors } = await openAt('?file=boxes.t4d');
  const whole = t4d('slice', at('boxes.t4d'), '--time', 0.5);
  const [both] = await shownMeasures(page, { t: 0.5 });
  sameAsProgram(both, whole, 'both boxes');
  const [name] = await page.evaluate('window.t4dViewer.panes[0].info.bodies.map(({ name }) => name)');
  const [one] = await shownMeasures(page, { hidden: [name] });
  assert.ok(one.numTriangles < both.numTriangles);
  for (const color of ['time', 'attribute:triangle', 'attribute:kind', 'body']) {
    await shownMeasures(page, { color, onion: 2, onionStep: 0.1, wire: true });
  }
  await shownMeasures(page, { cut: 'solid', color: 'time' });
  assert.deepEqual(errors, []);
  await page.close();
});

test('a ramp stands where the colours of an attribute are', async () => {
  const { page, errors } = await openAt('?file=boxes.t4d#color=attribute:kind');
  for (const [cut, budget, isThere] of [['t', 1e9, true], ['solid', 1e9, false], ['x', 1e9, true], ['x', 1, false]]) {
    await page.evaluate(async ([state, bytes]) => {
      window.t4dViewer.panes[0].budget = bytes;
      window.t4dViewer.set(state);
      await window.t4dViewer.whole();
    }, [{ cut, t: 0.5 }, budget]);
    assert.equal(await page.isVisible('#ramp'), isThere, `${cut}, ${budget}`);
  }
  assert.deepEqual(errors, []);
  await page.close();
});

/** How far apart colours look: in OKLab, where black and white are 1 apart. */
function difference(a, b) {
  const lab = ({ r: red, g: green, b: blue }) => {
    const l = Math.cbrt(0.4122214708 * red + 0.5363325363 * green + 0.0514459929 * blue);
    const m = Math.cbrt(0.2119034982 * red + 0.6806995451 * green + 0.1073969566 * blue);
    const s = Math.cbrt(0.0883024619 * red + 0.2817188376 * green + 0.6299787005 * blue);
    return [
      0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s, 1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
      0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s,
    ];
  };
  const [first, second] = [lab(a), lab(b)];
  return Math.hypot(...first.map((part, i) => part - second[i]));
}

test('bodies have colours that differ', () => {
  const bodies = Array.from({ length: 20 }, (_, i) => ({ name: `body ${i}` }));
  const colors = colorsOf(bodies);
  colors.forEach((color, i) => colors.slice(0, i).forEach((other, k) =>
    assert.ok(difference(color, other) > 0.07, `${i} and ${k}: ${color.getHexString()}, ${other.getHexString()}`)));
  const many = colorsOf(Array.from({ length: 200 }, (_, i) => ({ name: String(i) })));
  assert.equal(new Set(many.map((color) => color.getHexString())).size, 200);

  // One of the palette is taken by a body of its own colour, and one by a file that is there.
  const [first, second, third] = colors;
  const { r, g, b } = first;
  const [shown, own, same, another] = colorsOf(
    [{ name: 'a' }, { name: 'b', color: [r, g, b] }, { name: 'there' }, { name: 'c' }], [['there', second]],
  );
  assert.deepEqual([shown, own, same], [third, first, second]);
  assert.ok([shown, own, same].every((color) => difference(color, another) > 0.07));
});

test('age is the time since a body began', async () => {
  const { page, errors } = await openAt('?file=cube.t4d&file=late.t4d#color=age&t=3');
  await page.evaluate('window.t4dViewer.whole()');
  const found = await page.evaluate(() => window.t4dViewer.panes.map(({ sections, info, center }) => {
    const { colorMode, colorRange } = [...sections.values()][0].material.uniforms;
    return { mode: colorMode.value, begin: info.bodies[0].begin, range: colorRange.value.toArray().map((t) => t + center[3]) };
  }));
  const { time_begin: begin, time_end: end, time_unit: unit } = t4d('info', at('cube.t4d'));
  assert.deepEqual(found, [{ mode: 6, begin, range: [begin, end] }, { mode: 6, begin: begin + 2, range: [begin + 2, end + 2] }]);
  assert.equal(await page.innerText('#range'), `0 to ${end - begin} ${unit}`);
  assert.deepEqual(errors, []);
  await page.close();
});

/** Turns the camera, and waits until the address says so. */
async function drag(page) {
  const camera = () => page.evaluate('window.t4dViewer.state.camera');
  const before = await camera();
  const { x, y, width, height } = await page.locator('#canvas').boundingBox();
  await page.mouse.move(x + width / 2, y + height / 2);
  await page.mouse.down();
  await page.mouse.move(x + width / 2 + 80, y + height / 2 + 30, { steps: 4 });
  await page.mouse.up();
  await page.waitForTimeout(600);
  assert.notDeepEqual(await camera(), before);
}

/** The states of two pages, whose cameras are rounded where they are placed. */
function sameStates({ camera: found, ...rest }, { camera: expected, ...restExpected }) {
  assert.deepEqual(rest, restExpected);
  found.forEach((value, i) => assert.ok(Math.abs(value - expected[i]) < 1e-9 * Math.hypot(...expected), `${found}, expected ${expected}`));
}

test('a link restores the view', async () => {
  const { page } = await openAt('?file=torus.t4d');
  await page.evaluate(async () => {
    window.t4dViewer.set({ cut: 'y', y: 0.25, wire: true, color: 'time' });
    await window.t4dViewer.whole();
  });
  await drag(page);
  const [hash, state] = await page.evaluate('[location.hash, window.t4dViewer.state]');
  await page.close();
  const { page: other, errors } = await openAt(`?file=torus.t4d${hash}`);
  sameStates(await other.evaluate('window.t4dViewer.state'), state);
  assert.deepEqual(errors, []);
  await other.close();
});

test('a link restores two files and their view', async () => {
  const { page } = await openAt('?file=torus.t4d');
  await page.evaluate((url) => window.t4dViewer.open(url, { beside: true }), `${site.url}cube.t4d`);
  await shownMeasures(page, { t: 0.4, wire: true });
  await drag(page);
  const [href, state] = await page.evaluate('[location.href, window.t4dViewer.state]');
  await page.close();
  assert.ok(href.startsWith(`${site.url}?file=torus.t4d&file=cube.t4d#`), href);
  const { page: other, errors } = await openPage(browser, href);
  assert.equal(await other.innerText('#title'), 'torus.t4d and cube.t4d');
  await other.waitForTimeout(600);
  sameStates(await other.evaluate('window.t4dViewer.state'), state);
  assert.equal(new URL(other.url()).search, new URL(href).search);
  assert.deepEqual(errors, []);
  await other.close();
});

/** The state of a page, once it shows it all. */
const stateAt = (page) => page.evaluate(async () => {
  await window.t4dViewer.whole();
  return window.t4dViewer.state;
});

test('a file that replaces another begins anew', async () => {
  const { page, errors } = await openAt('?file=torus.t4d#t=0.4&cut=x&wire=true&hidden=["cube"]');
  await drag(page);
  await page.evaluate((url) => window.t4dViewer.open(url), `${site.url}late.t4d`);
  const { page: other } = await openAt('?file=late.t4d');
  sameStates(await stateAt(page), await stateAt(other));
  assert.deepEqual(errors, []);
  await page.close();
  await other.close();
});

test('the first file that can be opened is the first', async () => {
  const { page } = await openAt('?file=missing.t4d&file=late.t4d#t=3&cut=x&color=distance');
  const { page: other } = await openAt('?file=late.t4d#t=3&cut=x');
  sameStates(await stateAt(page), await stateAt(other));
  assert.ok(await page.isVisible('#message'));
  assert.match(await page.innerText('#message'), /missing.t4d: the server answers 404/);
  const { page: empty, errors } = await openAt('#t=3&cut=x');
  await empty.evaluate(() => document.getElementById('other').dispatchEvent(new Event('change')));
  await empty.setInputFiles('#other', at('late.t4d'));
  await empty.waitForFunction('window.t4dViewer.panes.length === 1');
  sameStates(await stateAt(empty), await stateAt(other));
  // The same file can be chosen again.
  await empty.setInputFiles('#other', at('late.t4d'));
  await empty.waitForFunction('window.t4dViewer.panes.length === 2');
  assert.equal(await empty.inputValue('#other'), '');
  assert.deepEqual(errors, []);
  for (const each of [page, other, empty]) await each.close();
});

test('a link that changes shows what it shows on a new page', async () => {
  const { page } = await openAt('?file=cube.t4d');
  await drag(page);
  const { page: other } = await openAt('?file=cube.t4d#cut=x');
  await page.evaluate(() => { location.hash = 'cut=x'; });
  await page.waitForFunction('window.t4dViewer.state.cut === "x"');
  sameStates(await stateAt(page), await stateAt(other));
  await page.close();
  await other.close();
});

test('a link says no more than the page can show', async () => {
  const { page } = await openAt('?file=cube.t4d#t=99&x=1e300&offset=-1e308&speed=3&onion=3');
  const { bounds, state: { t, x, offset, speed, onion } } = await page.evaluate(
    '({ bounds: window.t4dViewer.panes[0].bounds(), state: window.t4dViewer.state })');
  assert.deepEqual([t, x, offset, speed, onion], [bounds.max[3], bounds.max[0], bounds.min[0], 1, 0]);
  for (const key of ['speed', 'onion']) {
    const values = await page.$$eval(`#${key} option`, (all) => all.map(({ value }) => Number(value)));
    for (const value of values) assert.equal(stateOf(`#${key}=${value}`)[key], value);
  }
  await page.close();
});

test('of files on this machine, a link says that it cannot open them', async () => {
  const { page } = await openAt('?file=torus.t4d');
  await page.evaluate(() => {
    Object.defineProperty(navigator, 'clipboard', { value: { writeText: async (text) => { window.copied = text; } } });
  });
  await page.click('#link');
  await page.waitForFunction('window.copied');
  assert.ok(!await page.isVisible('#message'));
  await page.setInputFiles('#other', at('cube.t4d'));
  await page.waitForFunction('window.t4dViewer.panes.length === 2');
  await page.click('#link');
  const box = await page.waitForSelector('#message:not([hidden])');
  assert.match(await box.innerText(), /^The link does not open cube.t4d: /);
  assert.match(await page.evaluate('window.copied'), /\?file=torus\.t4d(#|$)/);
  await page.close();
});

test('the theme is remembered', async () => {
  const context = await browser.newContext({ colorScheme: 'dark' });
  const { page } = await openPage({ newPage: () => context.newPage() }, `${site.url}?file=cube.t4d`);
  const background = () => page.evaluate('getComputedStyle(document.body).backgroundColor');
  const dark = await background();
  await page.click('#theme');
  const light = await background();
  assert.notEqual(light, dark);
  await page.reload();
  await page.waitForFunction('window.t4dViewer !== undefined');
  assert.equal(await background(), light);
  await context.close();
});

test('where the browser keeps nothing, the theme can be switched', async () => {
  const { page, errors } = await openAt('');
  await page.evaluate(() => {
    Object.defineProperty(window, 'localStorage', { get() { throw new DOMException('denied', 'SecurityError'); } });
  });
  await page.click('#theme');
  assert.ok(await page.getAttribute('html', 'data-theme'));
  assert.deepEqual(errors, []);
  await page.close();
});

test('of two files, the slice that is not empty is saved', async () => {
  const { page } = await openAt('?file=cube.t4d&file=torus.t4d');
  const bounds = await page.evaluate('window.t4dViewer.panes.map((pane) => pane.bounds())');
  const [cube, torus] = bounds.map(({ max }) => max[3]);
  assert.notEqual(cube, torus);
  // The one that begins or ends first is empty here.
  await shownMeasures(page, { t: (cube + torus) / 2 });
  const [empty, other] = cube < torus ? ['cube', 'torus'] : ['torus', 'cube'];
  const [saved] = await Promise.all([page.waitForEvent('download'), page.click('#save')]);
  assert.match(saved.suggestedFilename(), new RegExp(`^${other}-at-`));
  const box = await page.waitForSelector('#message:not([hidden])');
  assert.match(await box.innerText(), new RegExp(`^Nothing to save of ${empty}.t4d: the slice is empty`));
  await page.close();
});

test('a slice is saved as glTF', async () => {
  const { page } = await openAt('?file=torus.t4d#t=0.4');
  const bytes = Buffer.from(await page.evaluate('window.t4dViewer.sliceAsGlb().then((bytes) => [...bytes])'));
  writeFileSync(at('saved.glb'), bytes);
  assert.equal(bytes.readUInt32LE(8), bytes.length);
  const json = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)).toString());
  const { triangles, vertices } = t4d('slice', at('torus.t4d'), '--time', 0.4);
  assert.equal(json.accessors[json.meshes[0].primitives[0].indices].count, 3 * triangles);
  assert.equal(json.accessors[json.meshes[0].primitives[0].attributes.POSITION].count, vertices);
  await page.close();
});

test('a saved file has a name without commas', async () => {
  const { page } = await openAt('?file=far.t4d#cut=x&x=1000000');
  const [saved] = await Promise.all([page.waitForEvent('download'), page.click('#save')]);
  assert.equal(saved.suggestedFilename(), 'far-x1000000.glb');
  await page.close();
});

test('slabs that are not used are forgotten', async () => {
  const { page, errors } = await openAt('?file=large.t4d');
  const { slabs, most } = await page.evaluate(async () => {
    const { set, whole, panes } = window.t4dViewer;
    const [pane] = panes;
    const { slabs: records } = pane.info.bodies[0];
    pane.budget = 32 * Math.max(...records.map(({ numCells }) => numCells)); // one slab
    let largest = 0;
    for (const { begin, end } of records) {
      set({ t: (begin + end) / 2 });
      await whole();
      // What was fetched ahead has come, or comes to the next.
      largest = Math.max(largest, pane.slabs.size);
    }
    return { slabs: records.length, most: largest };
  });
  assert.ok(slabs > 8, slabs);
  assert.ok(most <= 4, `${most} slabs at once`);
  assert.deepEqual(errors, []);
  await page.close();
});

test('two files side by side', async () => {
  const { page, errors } = await openAt('?file=torus.t4d&file=cube.t4d');
  const found = await shownMeasures(page, { t: 0.4 });
  sameAsProgram(found[0], t4d('slice', at('torus.t4d'), '--time', 0.4), 'torus');
  sameAsProgram(found[1], t4d('slice', at('cube.t4d'), '--time', 0.4), 'cube');
  assert.deepEqual(errors, []);
  await page.close();
});

test('two files coloured by their distance', async () => {
  const { page, errors } = await openAt('?file=cube.t4d&file=beside.t4d');
  const largest = (state) => page.evaluate(async (changes) => {
    window.t4dViewer.set(changes);
    await window.t4dViewer.whole();
    return window.t4dViewer.largestDistance();
  }, state);
  // The cube stands along the axes at the start.
  isNear(await largest({ t: 0, color: 'distance' }), 0.5, 'at the start');
  const options = await page.$$eval('#color option', (all) => all.map(({ value }) => value));
  assert.ok(options.includes('distance'));
  assert.equal(await largest({ color: 'distance', hidden: ['cube'] }), 0);
  await shownMeasures(page, { color: 'body', hidden: [] });
  assert.deepEqual(errors, []);
  await page.close();
});

test('fingers turn and zoom', async () => {
  const { page, errors } = await openAt('?file=cube.t4d', { hasTouch: true });
  const session = await page.context().newCDPSession(page);
  const { x: left, y: top, width, height } = await page.locator('#canvas').boundingBox();
  // Places as parts of the canvas.
  const touch = (type, ...points) => session.send('Input.dispatchTouchEvent', {
    type, touchPoints: points.map(([x, y], id) => ({ x: left + x * width, y: top + y * height, id })),
  });
  const camera = () => page.evaluate('window.t4dViewer.state.camera');
  const distanceOf = ([x, y, z, tx, ty, tz]) => Math.hypot(x - tx, y - ty, z - tz);
  const before = await page.evaluate('window.t4dViewer.state.camera');
  await touch('touchStart', [0.4, 0.5]);
  for (let x = 0.42; x < 0.6; x += 0.02) await touch('touchMove', [x, 0.55]);
  await touch('touchEnd');
  await page.waitForFunction((seen) => JSON.stringify(window.t4dViewer.state.camera) !== seen, JSON.stringify(before));
  const turned = await camera();
  await touch('touchStart', [0.45, 0.5]);
  await touch('touchStart', [0.45, 0.5], [0.55, 0.5]);
  for (let d = 0; d < 0.2; d += 0.02) await touch('touchMove', [0.45 - d, 0.5], [0.55 + d, 0.5]);
  await touch('touchEnd');
  await page.waitForFunction((seen) => JSON.stringify(window.t4dViewer.state.camera) !== seen, JSON.stringify(turned));
  assert.ok(distanceOf(await camera()) < 0.9 * distanceOf(turned));
  assert.deepEqual(errors, []);
  await page.close();
});

test('keys and play', async () => {
  const { page, errors } = await openAt('?file=cube.t4d');
  const state = () => page.evaluate('window.t4dViewer.state');
  await page.focus('#canvas');
  await page.keyboard.press('x');
  assert.equal((await state()).cut, 'x');
  await page.keyboard.press('t');
  await page.keyboard.press('Home');
  const { t } = await state();
  await page.keyboard.press('Shift+ArrowRight');
  assert.ok((await state()).t > t);
  await page.keyboard.press('w');
  assert.ok((await state()).wire);
  await page.keyboard.press(' ');
  await page.waitForFunction('window.t4dViewer.state.t > 0.3');
  await page.keyboard.press(' ');
  await page.evaluate('window.t4dViewer.set({ loop: false })');
  await page.keyboard.press('ArrowLeft');
  await page.keyboard.press('End');
  await page.keyboard.press(' ');
  await page.waitForFunction('window.t4dViewer.state.t > 0.3 && window.t4dViewer.state.t < 9');
  await page.keyboard.press(' ');
  await page.keyboard.press('?');
  await page.click('#keys h2');
  await page.keyboard.press('x');
  assert.equal((await state()).cut, 't');
  await page.keyboard.press('Escape');
  await page.keyboard.press('h');
  await page.keyboard.down('Shift');
  const { x, y } = await page.locator('#canvas').boundingBox();
  await page.mouse.move(x + 100, y + 100);
  await page.mouse.down();
  await page.mouse.move(x + 120, y + 100);
  const { normal } = await state();
  assert.notDeepEqual(normal, [1, 0, 0, 0]);
  await page.evaluate(() => window.t4dViewer.find('canvas').dispatchEvent(new PointerEvent('pointercancel', { pointerId: 1 })));
  await page.mouse.move(x + 140, y + 100);
  assert.deepEqual((await state()).normal, normal);
  await page.mouse.up();
  assert.deepEqual(errors, []);
  await page.close();
});

test('what fits the picture stays in it when the window changes its shape', async () => {
  const { page, errors } = await openAt('?file=cube.t4d');
  for (const [width, height] of [[1280, 800], [390, 844], [844, 390]]) {
    await page.setViewportSize({ width, height });
    await page.waitForTimeout(300);
    // The degrees that the camera sees across and up.
    const seen = await page.evaluate(() => [0, 5].map((i) =>
      2 * Math.atan(1 / window.t4dViewer.camera.projectionMatrix.elements[i]) * 180 / Math.PI));
    isNear(Math.min(...seen), 35, `${width} x ${height}`);
  }
  assert.deepEqual(errors, []);
  await page.close();
});

test('what is wrong with a file is said', async () => {
  const message = (page) => page.waitForSelector('#message:not([hidden])').then((box) => box.innerText());
  for (const [name, expected] of [
    ['text', /text.t4d: byte 0: H1: not the signature of a .t4d file/],
    ['cut-off', /cut-off.t4d: byte \d+: F1: the end signature is missing; the file may have been cut off/],
    ['missing', /missing.t4d: the server answers 404/],
  ]) {
    const { page } = await openAt(`?file=${name}.t4d`);
    assert.match(await message(page), expected);
    await page.close();
  }
  const { page, errors } = await openAt('?file=http://[bad');
  assert.match(await message(page), /^http:\/\/\[bad: /);
  assert.deepEqual(errors, []);
  await page.close();
});

test('of a damaged file, what is whole is shown', async () => {
  const { page, errors } = await openAt('?file=damaged.t4d');
  const { slab_list: slabs } = t4d('info', at('torus.t4d'), '--slabs').bodies[0];
  const whole = (slabs[2].begin + slabs[2].end) / 2;
  const [found] = await shownMeasures(page, { t: whole });
  sameAsProgram(found, t4d('slice', at('torus.t4d'), '--time', whole), 'beside the damage');
  const [none] = await shownMeasures(page, { t: (slabs[4].begin + slabs[4].end) / 2 });
  assert.equal(none.numTriangles, 0);
  const message = await (await page.waitForSelector('#message:not([hidden])')).innerText();
  assert.match(message, /damaged.t4d: byte \d+: C5: front checksum/);
  assert.match(message, /cannot be shown; the rest can/);
  const said = () => page.waitForFunction(() => {
    const { hidden, innerText } = window.t4dViewer.find('message');
    return !hidden && /^damaged.t4d: byte/.test(innerText) && !innerText.includes('cannot be shown');
  });
  await page.click('#save');
  await said();
  await shownMeasures(page, { cut: 'x' });
  const before = await page.evaluate('window.t4dViewer.state.x');
  await page.click('#measureSpeed');
  await said();
  assert.equal(await page.evaluate('window.t4dViewer.state.x'), before);
  assert.deepEqual(errors, []);
  await page.close();
});

test('the element and the page in the repository are what their sources give', async () => {
  for (const [name, text] of [['t4d-view.js', await makeElement()], ['viewer.html', await makePage()]]) {
    assert.ok(readFileSync(path.join(here, '../dist', name), 'utf8') === text, `${name}: run \`npm run build --workspace viewer\` in web`);
  }
});

/** The program serving a file: its address, and how to end it. */
async function serveByProgram(file) {
  const server = spawn(path.join(build, 't4d'), ['view', file, '--no-open', '--json']);
  const { url } = JSON.parse(await new Promise((resolve) => { server.stdout.once('data', resolve); }));
  return { url, kill: () => server.kill() };
}

test('the program serves, and writes pages that need no server', async () => {
  const server = await serveByProgram(at('torus.t4d'));
  const { url } = server;
  t4d('view', at('torus.t4d'), '-o', at('torus.html'));
  try {
    const answer = async (name, headers = {}, method = 'GET') => (await fetch(url + name, { headers, method })).status;
    assert.equal(await answer('torus.t4d', { Range: 'bytes=0-9' }), 206);
    assert.equal(await answer('torus.t4d', { Range: 'bytes=0-9', 'If-Match': '"another"' }), 412);
    assert.equal(await answer('cube.t4d'), 404);
    assert.equal(await answer('%2e%2e/viewer/cube.t4d'), 404);
    assert.equal(await answer('torus.t4d', {}, 'PUT'), 404);
    const expected = t4d('slice', at('torus.t4d'), '--time', 0.4);
    for (const address of [url, `file://${at('torus.html')}`]) {
      const { page, errors } = await openPage(browser, address);
      const [found] = await shownMeasures(page, { t: 0.4 });
      sameAsProgram(found, expected, address);
      assert.deepEqual(errors, []);
      await page.close();
    }
  } finally {
    server.kill();
  }
});

test('connections that say nothing, or a byte now and then, hold up nobody', async () => {
  const server = await serveByProgram(at('torus.t4d'));
  const { port } = new URL(server.url);
  const sockets = [];
  const request = 'GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: ';
  const timer = setInterval(() => {
    for (const socket of sockets.filter((_, i) => i % 3 === 0)) socket.write('x');
  }, 100);
  try {
    for (let i = 0; i < 300; ++i) {
      const socket = net.connect(port, '127.0.0.1');
      socket.on('error', () => {});
      socket.resume();  // else its end is not noticed
      socket.isOpen = true;
      socket.on('close', () => { socket.isOpen = false; });
      await new Promise((resolve) => { socket.once('connect', resolve); });
      if (i % 3 < 2) socket.write(request);
      sockets.push(socket);
    }
    for (const range of [undefined, 'bytes=0-9']) {
      const begin = performance.now();
      const { status } = await fetch(range ? `${server.url}torus.t4d` : server.url, { headers: range ? { Range: range } : {} });
      assert.equal(status, range ? 206 : 200);
      const seconds = (performance.now() - begin) / 1000;
      assert.ok(seconds < 1, `${seconds} s`);
    }
    // A connection that says nothing is closed.
    const silent = sockets.filter((_, i) => i % 3 !== 0);
    const end = performance.now() + 20_000;
    while (silent.some(({ isOpen }) => isOpen) && performance.now() < end) {
      await new Promise((resolve) => { setTimeout(resolve, 50); });
    }
    assert.equal(silent.filter(({ isOpen }) => isOpen).length, 0);
  } finally {
    clearInterval(timer);
    for (const socket of sockets) socket.destroy();
    server.kill();
  }
});

test('a page or a folder is written, and nothing else is overwritten', () => {
  const made = at('made');
  mkdirSync(path.join(made, 'taken'), { recursive: true });
  mkdirSync(path.join(made, 'other'));
  mkdirSync(path.join(made, 'notes'));
  copyFileSync(at('cube.t4d'), path.join(made, 'A.t4d'));
  copyFileSync(at('torus.t4d'), path.join(made, 'other/A.t4d'));
  writeFileSync(path.join(made, 'taken/index.html'), 'mine');
  writeFileSync(path.join(made, 'notes/notes.txt'), 'mine');
  writeFileSync(path.join(made, 'text.txt'), 'mine');
  const view = (...args) => spawnSync(path.join(build, 't4d'), ['view', 'A.t4d', ...args], { cwd: made, maxBuffer: 1e8 });
  const writes = (name) => {
    const { status, stderr } = view('-o', name);
    assert.equal(status, 0, `${name}: ${stderr}`);
  };
  const refuses = (name, expected) => {
    const { status, stderr } = view('-o', name);
    assert.equal(status, 2, name);
    assert.match(stderr.toString(), expected);
  };
  for (const name of ['c.html', 'c.HTML', 'c.htm']) {
    writes(name);
    assert.match(readFileSync(path.join(made, name), 'latin1'), /"base64":/);
  }
  const { status, stdout } = view('-o', '-');
  assert.equal(status, 0);
  assert.ok(stdout.equals(readFileSync(path.join(made, 'c.html'))));
  assert.ok(!existsSync(path.join(made, '-')));

  // A new folder, one that was written before, and those whose files all stay.
  for (const name of ['site', 'site/', 'notes', '.']) writes(name);
  assert.deepEqual(readdirSync(path.join(made, 'notes')).sort(), ['A.t4d', 'index.html', 'notes.txt']);
  refuses('taken', /taken\/index.html: exists and was not written by t4d/);
  refuses('other', /other\/A.t4d: exists and was not written by t4d/);
  refuses('text.txt', /text.txt is a file; name a page that ends in .html, or a folder/);
  refuses('A.t4d', /A.t4d is a file; name a page that ends in .html, or a folder/);
  assert.equal(readFileSync(path.join(made, 'taken/index.html'), 'utf8'), 'mine');
  assert.deepEqual(readdirSync(path.join(made, 'taken')), ['index.html']);
  assert.ok(readFileSync(path.join(made, 'other/A.t4d')).equals(readFileSync(at('torus.t4d'))));
});

test('a page without a file asks for one', async () => {
  const { page, errors } = await openAt('');
  assert.ok(await page.isVisible('#welcome'));
  await page.setInputFiles('#chooser', at('cube.t4d'));
  await page.waitForFunction('window.t4dViewer.panes.length === 1');
  const [found] = await shownMeasures(page, { t: 0.4 });
  sameAsProgram(found, t4d('slice', at('cube.t4d'), '--time', 0.4), 'cube');
  assert.deepEqual(errors, []);
  await page.close();
});

test('where no file can be opened, another can, and the rest waits for it', async () => {
  const { page } = await openAt('?file=missing.t4d');
  assert.match(await page.innerText('#message'), /missing.t4d: the server answers 404/);
  const enabled = () => page.evaluate(() =>
    [document, document.querySelector('t4d-view').shadowRoot]
      .flatMap((root) => [...root.querySelectorAll('fieldset :is(button, input, select), #fit, #time :is(button, input, select)')])
      .filter((each) => !each.matches(':disabled')).map(({ id }) => id));
  assert.deepEqual(await enabled(), []);
  await page.click('#message button');
  assert.ok(await page.isVisible('#choose'));
  const chosen = page.waitForEvent('filechooser');
  await page.click('#choose');
  await (await chosen).setFiles(at('cube.t4d'));
  await page.waitForFunction('window.t4dViewer.panes.length === 1');
  assert.ok(!await page.isVisible('#welcome'));
  assert.ok((await enabled()).includes('slider'));
  // A file that cannot be opened replaces nothing.
  const next = page.waitForEvent('filechooser');
  await page.click('#open');
  await (await next).setFiles(at('viewer.html'));
  await page.waitForSelector('#message:not([hidden])');
  assert.ok(!await page.isVisible('#welcome'));
  assert.equal(await page.evaluate('window.t4dViewer.panes.length'), 1);
  await page.close();
});

test('form controls keep their keys, and wrong values go back', async () => {
  const { page, errors } = await openAt('?file=boxes.t4d&file=cube.t4d#onion=7&speed=-1&onionStep=0&color=attribute:none&t=1');
  const state = () => page.evaluate('window.t4dViewer.state');
  await page.evaluate('window.t4dViewer.whole()');
  await page.waitForFunction('window.t4dViewer.state.color === "body"');
  const { onion, speed, onionStep } = await state();
  assert.deepEqual([onion, speed], [0, 1]);
  assert.ok(onionStep > 0);
  await page.focus('#wire');
  await page.keyboard.press(' ');
  assert.ok((await state()).wire);
  assert.notEqual(await page.getAttribute('#play', 'aria-pressed'), 'true');
  await page.fill('#value', '1000');
  await page.keyboard.press('Enter');
  assert.equal((await state()).t, 10);
  assert.equal(await page.inputValue('#value'), '10');
  await page.fill('#value', '');
  await page.keyboard.press('Enter');
  assert.equal(await page.inputValue('#value'), '10');
  await page.evaluate('window.t4dViewer.set({ cut: "any" })');
  const sliders = page.locator('[data-normal]');
  await sliders.nth(1).focus();
  await page.keyboard.press('ArrowRight');
  assert.ok(Math.abs((await state()).normal[1] - 0.01) < 1e-9);
  await page.evaluate('window.t4dViewer.set({ normal: [1, 0, 0, 0] })');
  await sliders.nth(0).fill('0');
  assert.deepEqual((await state()).normal, [1, 0, 0, 0]);
  assert.equal(await sliders.nth(0).inputValue(), '1');
  await page.evaluate('window.t4dViewer.set({ cut: "solid" })');
  assert.ok(await page.isDisabled('#save'));
  const [name] = await page.evaluate('window.t4dViewer.panes[0].info.bodies.map(({ name }) => name)');
  await page.evaluate((hidden) => { location.hash = `hidden=${JSON.stringify([hidden])}`; }, name);
  await page.waitForFunction('!document.querySelector("[data-body]").checked');
  await page.evaluate('Object.defineProperty(navigator, "clipboard", { value: undefined })');
  await page.click('#link');
  assert.match(await page.innerText('#message'), /hidden=/);
  await page.setViewportSize({ width: 390, height: 844 });
  const height = () => page.locator('#canvas').boundingBox().then((box) => box.height);
  const before = await height();
  await page.click('#hide');
  assert.ok(await height() > before + 150);
  assert.deepEqual(errors, []);
  await page.close();
});
