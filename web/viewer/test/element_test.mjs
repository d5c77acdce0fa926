// The element <t4d-view> in Chromium: what authors of pages rely on.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { build as bundle } from 'esbuild';
import { answering, measure, open } from 't4d-reader';

import { makeElement } from '../build.mjs';
import { launch, serve } from '../browser.mjs';

const here = path.dirname(fileURLToPath(import.meta.url));
const root = path.resolve(here, '../../..');
const build = process.env.T4D_BUILD ?? path.join(root, 'build/release');
const folder = path.join(root, 'build/web-test/element');
const at = (name) => path.join(folder, name);
const run = (program, ...args) => execFileSync(path.join(build, program), args.map(String), { encoding: 'utf8' });
const corpus = (name) => path.join(root, 'conformance/corpus/files/valid', name);
const fileOf = (name) => open(new Uint8Array(readFileSync(name)));

const files = {
  'grows.t4d': corpus('cube-that-grows.t4d'), 'ring.t4d': corpus('ring.t4d'), 'forty.t4d': corpus('forty-bodies.t4d'),
  'large.t4d': at('large.t4d'),
};
let browser;
let site;
before(async () => {
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  run('t4d-fixtures', at('fx'));
  run('t4d', 'sweep', at('fx/torus.obj'), '--motion', at('fx/several-segments.json'), '--backend', 'voxel4d',
    '--voxel-size', 0.5, '--frames', 12, '--compression', 0, '-o', at('large.t4d'));
  writeFileSync(at('t4d-view.js'), await makeElement());
  const damaged = readFileSync(files['large.t4d']);
  const [{ slabs, begin }] = (await fileOf(files['large.t4d'])).bodies;
  damaged[slabs[answering(slabs, begin)].at + 40] ^= 1;
  site = await serve({
    ...files, 't4d-view.js': at('t4d-view.js'), 'damaged.t4d': damaged, 'cut-off.t4d': damaged.subarray(0, 5000),
    'empty.html': Buffer.from('<!doctype html><body>'),
    'page.html': Buffer.from('<!doctype html><link rel="icon" href="data:,"><body><script src="t4d-view.js"></script>'),
    'module.html': Buffer.from('<!doctype html><link rel="icon" href="data:,"><body><script type="module" src="t4d-view.js"></script>'),
  });
  browser = await launch();
});
after(async () => {
  await browser?.close();
  site?.close();
});

/** A page with the element, and errors of its console; `events` of the page has those of the element. */
async function openWith(html, name = 'page.html') {
  const page = await browser.newPage({ viewport: { width: 800, height: 600 } });
  const errors = [];
  page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(site.url + name);
  await page.evaluate(async (text) => {
    window.events = [];
    for (const type of ['load', 'draw', 'time', 'hyperplane', 'camera', 'error']) {
      document.addEventListener(`t4d-${type}`, ({ detail }) => window.events.push([type, detail]));
    }
    document.body.insertAdjacentHTML('beforeend', text);
    await customElements.whenDefined('t4d-view');
    for (const view of document.querySelectorAll('t4d-view')) await view.drawn();
  }, html);
  return { page, errors };
}

/** The number of workers of a page, once there are `most` or fewer: the browser tells of the end of one a little later. */
async function workersLeft(page, most) {
  for (let i = 0; i < 50 && page.workers().length > most; ++i) await page.waitForTimeout(100);
  return page.workers().length;
}
const eventsOf = (page, ...types) => page.evaluate((wanted) =>
  window.events.filter(([type]) => wanted.includes(type)).map(([type, { error, ...detail }]) => [type, detail]), types);
const messageOf = (page) => page.locator('#message:visible').innerText();

test('attributes say what to show, and properties what is shown', async () => {
  const { page, errors } = await openWith(
    '<t4d-view id="view" src="grows.t4d" time="0.5" color="speed" camera="1,2,3 0.1,0,0" controls></t4d-view>');
  const shown = () => page.evaluate(() => {
    const { src, time, color, camera, controls, hyperplane, bodies, begin, end } = document.getElementById('view');
    return { src, time, color, camera, controls, hyperplane, bodies, begin, end };
  });
  const expected = {
    src: 'grows.t4d', time: 0.5, color: 'speed', camera: [1, 2, 3, 0.1, 0, 0], controls: true, hyperplane: 't',
    bodies: ['cube'], begin: -1, end: 1,
  };
  assert.deepEqual(await shown(), expected);
  // Properties are attributes, too, and text changes what is shown.
  const attributes = await page.evaluate(() => {
    const view = document.getElementById('view');
    Object.assign(view, { time: -0.25, color: 'age', controls: false, camera: [3, 2, 1, 0, 0, 0] });
    return Object.fromEntries([...view.attributes].map(({ name, value }) => [name, value]));
  });
  assert.deepEqual(attributes, { id: 'view', src: 'grows.t4d', time: '-0.25', color: 'age', camera: '3,2,1,0,0,0' });
  const { camera, ...rest } = await shown();
  assert.deepEqual({ ...rest, camera: camera.map((value) => Number(value.toFixed(12))) },
    { ...expected, time: -0.25, color: 'age', controls: false, camera: [3, 2, 1, 0, 0, 0] });
  for (const [text, cut] of [['x=0.25', 'x'], ['1,0.5,0,2,0.125', 'any'], ['motion', 'solid'], ['t', 't']]) {
    const found = await page.evaluate((value) => {
      const view = document.getElementById('view');
      view.setAttribute('hyperplane', value);
      return [view.hyperplane, view.viewer.model.state.cut];
    }, text);
    assert.deepEqual(found, [text, cut]);
  }
  // Without attributes it shows what it shows at first, at the time that it has.
  await page.evaluate(() => ['color', 'time'].forEach((name) => document.getElementById('view').removeAttribute(name)));
  const { color, time } = await shown();
  assert.deepEqual([color, time], ['body', -0.25]);
  assert.deepEqual(errors, []);
  await page.close();
});

test('a link of the page of t4d view is an attribute', async () => {
  const { page } = await openWith('<t4d-view id="view" src="grows.t4d" view="cut=x&x=0.5&wire=true&color=time"></t4d-view>');
  const found = await page.evaluate(() => [document.getElementById('view').view.replace(/&camera=.*/, ''),
    document.getElementById('view').hyperplane]);
  assert.deepEqual(found, ['cut=x&x=0.5&color=time&wire=true', 'x=0.5']);
  const next = await page.evaluate(() => {
    document.getElementById('view').view = 'cut=y';
    return document.getElementById('view').viewer.model.state;
  });
  assert.deepEqual([next.cut, next.wire, next.color], ['y', false, 'body']);
  await page.close();
});

test('bodies are shown by their names', async () => {
  const { page } = await openWith('<t4d-view id="view" src="forty.t4d"></t4d-view>');
  const { bodies } = await fileOf(files['forty.t4d']);
  const names = bodies.map(({ name }) => name);
  const [all, whole] = await page.evaluate(async () => [view.bodies, await view.measure(0.75)]);
  assert.deepEqual(all, names);
  const [some, part, attribute] = await page.evaluate(async (two) => {
    view.bodies = two;
    return [view.bodies, await view.measure(0.75), view.getAttribute('bodies')];
  }, names.slice(0, 2));
  assert.deepEqual(some, names.slice(0, 2));
  assert.deepEqual(JSON.parse(attribute), names.slice(0, 2));
  assert.equal(part.triangles, whole.triangles);
  const [one, single] = await page.evaluate(async (name) => {
    view.setAttribute('bodies', ` ${name} `);
    return [view.bodies, await view.measure(0.75)];
  }, names[1]);
  assert.deepEqual(one, [names[1]]);
  assert.equal(2 * single.triangles, whole.triangles);
  assert.deepEqual(await page.evaluate(() => {
    view.bodies = null;
    return view.bodies;
  }), names);
  await page.close();
});

test('events tell what the person does, and no more', async () => {
  const { page, errors } = await openWith('<t4d-view id="view" src="grows.t4d" controls></t4d-view>');
  assert.deepEqual(await eventsOf(page, 'load', 'time', 'camera', 'hyperplane', 'error'),
    [['load', { names: ['grows.t4d'], bodies: ['cube'], begin: -1, end: 1 }]]);
  assert.ok((await eventsOf(page, 'draw')).length > 0);
  await page.evaluate(async () => {
    Object.assign(view, { time: 0.5, hyperplane: 'x=0', camera: [1, 2, 3, 0, 0, 0] });
    view.hyperplane = 't';
    await view.drawn();
  });
  assert.equal((await eventsOf(page, 'time', 'camera', 'hyperplane')).length, 0);
  await page.locator('#slider').fill('0.25');
  assert.deepEqual(await eventsOf(page, 'time'), [['time', { time: 0.25 }]]);
  assert.equal(await page.evaluate(() => view.time), 0.25);
  const { x, y } = await page.locator('#canvas').boundingBox();
  await page.mouse.move(x + 200, y + 150);
  await page.mouse.down();
  await page.mouse.move(x + 260, y + 150, { steps: 3 });
  await page.mouse.up();
  const moves = await eventsOf(page, 'camera');
  assert.ok(moves.length > 0);
  assert.deepEqual(moves.at(-1)[1].camera, await page.evaluate(() => view.camera));
  await page.evaluate(() => { view.hyperplane = 'x=0'; });
  await page.locator('#slider').fill('0.125');
  assert.deepEqual(await eventsOf(page, 'hyperplane'), [['hyperplane', { hyperplane: 'x=0.125' }]]);
  await page.evaluate(() => {
    view.hyperplane = 't';
    view.play();
  });
  await page.waitForFunction(() => window.events.filter(([type]) => type === 'time').length > 3);
  await page.evaluate(() => view.pause());
  assert.equal(await page.evaluate(() => view.paused), true);
  assert.deepEqual(errors, []);
  await page.close();
});

test('slices and measures are those of the reader', async () => {
  const { page } = await openWith('<t4d-view id="view" src="ring.t4d" time="0.25"></t4d-view>');
  const file = await fileOf(files['ring.t4d']);
  const [section] = await file.slice(0.25);
  const { volume, area, numTriangles, numPoints } = measure(section);
  const expected = { triangles: numTriangles, vertices: numPoints, volume, area };
  const [shown, timed, across, points, glb, png] = await page.evaluate(async () => {
    const [slice] = await view.slice();
    const kind = async (blob) => [blob.type, (await blob.slice(0, 4).text()).slice(1)];
    return [await view.measure(), await view.measure(0.5), await view.measure('x=0'), [...slice.points],
      await kind(await view.toGlb()), await kind(await view.toBlob())];
  });
  assert.deepEqual(shown, expected);
  assert.deepEqual(points, [...section.points]);
  assert.equal(timed.volume, measure((await file.slice(0.5))[0]).volume);
  assert.ok(across.triangles > 0);
  assert.deepEqual([glb, png], [['model/gltf-binary', 'lTF'], ['image/png', 'PNG']]);
  await assert.rejects(page.evaluate(() => view.measure('nonsense')),
    /'nonsense': expected a time, or t, x=V/);
  await page.close();
});

test('views of one file share one reader and its slabs', async () => {
  const count = async (html) => {
    const first = site.requests.length;
    const { page, errors } = await openWith(html);
    await page.evaluate(async () => {
      for (const time of [3, 5, 8]) {
        for (const each of document.querySelectorAll('t4d-view')) each.time = time;
        for (const each of document.querySelectorAll('t4d-view')) await each.drawn();
      }
    });
    await page.waitForTimeout(500); // what is fetched ahead
    const workers = page.workers().length;
    const numbers = await page.evaluate(() => Promise.all([...document.querySelectorAll('t4d-view')].map((each) => each.measure())));
    assert.deepEqual(errors, []);
    await page.close();
    return { requests: site.requests.length - first, workers, numbers };
  };
  const view = '<t4d-view src="large.t4d" style="height: 150px"></t4d-view>';
  const one = await count(view);
  const four = await count(view.repeat(4));
  assert.ok(one.requests > 3, one.requests);
  assert.equal(four.requests, one.requests);
  assert.deepEqual([one.workers, four.workers], [1, 1]);
  assert.deepEqual(four.numbers, Array(4).fill(one.numbers[0]));
});

test('a view that is removed frees what it had', async () => {
  const { page, errors } = await openWith('<t4d-view id="view" src="large.t4d"></t4d-view>');
  // More than a browser has pictures for at a time.
  const [lost, kept] = await page.evaluate(async () => {
    const contexts = [];
    for (let i = 0; i < 30; ++i) {
      const other = document.createElement('t4d-view');
      other.src = 'large.t4d';
      document.body.append(other);
      await other.drawn();
      contexts.push(other.viewer.view.renderer.getContext());
      other.remove();
      await Promise.resolve();
    }
    await view.drawn();
    return [contexts.every((gl) => gl.isContextLost()), view.viewer.view.renderer.getContext().isContextLost()];
  });
  assert.deepEqual([lost, kept], [true, false]);
  assert.equal(await workersLeft(page, 1), 1);
  // The slabs of one that is left are those that it shows.
  const [users, shown] = await page.evaluate(() => {
    const [{ file, slabs }] = view.viewer.model.panes;
    return [[...file.slabs.values()].map((slab) => slab.users), slabs.size];
  });
  assert.deepEqual(users, Array(shown).fill(1));
  await page.evaluate(async () => {
    window.removed = view;
    view.remove();
    await Promise.resolve();
  });
  assert.equal(await workersLeft(page, 0), 0);
  // The element begins anew where it is put back.
  const triangles = await page.evaluate(async () => {
    document.body.append(window.removed);
    await window.removed.drawn();
    return (await window.removed.measure()).triangles;
  });
  assert.ok(triangles > 0);
  assert.deepEqual(errors, []);
  await page.close();
});

test('a view whose picture the browser takes away says so, and comes back', async () => {
  const { page, errors } = await openWith('<t4d-view id="view" src="grows.t4d"></t4d-view>');
  const lose = (how) => page.evaluate(async (name) => {
    const canvas = view.viewer.find('canvas');
    const event = name === 'forceContextLoss' ? 'webglcontextlost' : 'webglcontextrestored';
    const happened = new Promise((resolve) => { canvas.addEventListener(event, resolve, { once: true }); });
    view.viewer.view.renderer[name]();
    await happened;
  }, how);
  const picture = () => page.evaluate(async () => [...new Uint8Array(await (await view.toBlob()).arrayBuffer())]);
  const before = await picture();
  await lose('forceContextLoss');
  assert.match(await messageOf(page), /The browser took this picture away/);
  await lose('forceContextRestore');
  assert.deepEqual(await picture(), before);
  assert.equal(await page.locator('#message:visible').count(), 0);
  assert.deepEqual(errors, []);
  await page.close();
});

test('a view that is moved in its page stays as it is', async () => {
  const { page } = await openWith('<div id="place"></div><t4d-view id="view" src="grows.t4d"></t4d-view>');
  const first = site.requests.length;
  const [same, time] = await page.evaluate(async () => {
    const { viewer } = view;
    viewer.model.set({ t: 0.75 });
    document.getElementById('place').append(view);
    await view.drawn();
    return [view.viewer === viewer, view.time];
  });
  assert.deepEqual([same, time, site.requests.length], [true, 0.75, first]);
  await page.close();
});

test('colours of speed are those of the cells', async () => {
  // From one side the faces of the cube are seen that move outward, from the other those that rest.
  const { page, errors } = await openWith('<t4d-view id="view" src="grows.t4d" color="speed"></t4d-view>');
  for (const [side, isColor] of [[1, ([r, g, b]) => g > 2 * b && r > 2 * b], [-1, ([r, g, b]) => b > 2 * g]]) {
    const colors = await page.evaluate(async (sign) => {
      view.camera = [6 * sign, 5 * sign, 8 * sign, 0, 0, 0];
      const bitmap = await createImageBitmap(await view.toBlob());
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
      context.drawImage(bitmap, 0, 0);
      const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
      const pixels = Array.from({ length: data.length / 4 }, (_, i) => [...data.subarray(4 * i, 4 * i + 3)]);
      return pixels.filter(([r, g, b]) => Math.max(r, g, b) - Math.min(r, g, b) > 20);
    }, side);
    assert.ok(colors.length > 1000, colors.length);
    const right = colors.filter(isColor).length;
    assert.ok(right > 0.95 * colors.length, `${right} of ${colors.length}`);
  }
  assert.equal(await page.locator('#range').innerText(), 'speed along the normal: 0 to 1');
  assert.deepEqual(errors, []);
  await page.close();
});

test('what is wrong with a file is shown, and told', async () => {
  for (const [name, expected] of [
    ['missing', /missing.t4d: the server answers 404/], ['cut-off', /cut-off.t4d: byte \d+: F1: .*\n+The file is damaged/],
    ['damaged', /damaged.t4d: byte \d+: C5: front checksum/],
  ]) {
    const { page } = await openWith(`<t4d-view id="view" src="${name}.t4d"></t4d-view>`);
    assert.match(await messageOf(page), expected);
    const [[, { message }], ...others] = await eventsOf(page, 'error');
    assert.match(`${message}\nThe file is damaged`, new RegExp(expected.source.replace('\\n+', '\\n')));
    assert.deepEqual(others, []);
    // Another file can be shown instead.
    await page.evaluate(async () => {
      view.src = 'grows.t4d';
      await view.drawn();
    });
    assert.equal((await page.evaluate(() => view.measure())).triangles, 12);
    assert.equal(await page.locator('#message:visible').count(), 0);
    await page.close();
  }
});

test('load() shows files that have no address, and is rejected where it cannot', async () => {
  const { page } = await openWith('<t4d-view id="view"></t4d-view>');
  const bytes = [...readFileSync(files['grows.t4d'])];
  const [names, data] = await page.evaluate(async (all) => {
    const array = Uint8Array.from(all);
    await view.load(new File([array], 'mine.t4d'), array);
    await view.load(array.buffer);
    const text = `data:model/vnd.t4d;name=text.t4d;base64,${btoa(String.fromCharCode(...array))}`;
    view.src = text;
    await view.drawn();
    return [window.events.filter(([type]) => type === 'load').map(([, detail]) => detail.names), await view.measure()];
  }, bytes);
  assert.deepEqual(names, [['mine.t4d', 'mesh.t4d'], ['mesh.t4d'], ['text.t4d']]);
  assert.equal(data.triangles, 12);
  const wrong = await page.evaluate(() => view.load(new Blob(['This is no mesh.'])).catch(({ message }) => message));
  assert.match(wrong, /mesh.t4d: byte 0: /);
  assert.match(await messageOf(page), /mesh.t4d: byte 0: /);
  await page.close();
});

test('what makes no sense is told, and changes nothing', async () => {
  const { page } = await openWith('<t4d-view id="view" src="grows.t4d" time="soon"></t4d-view>');
  assert.match(await messageOf(page), /time="soon": expected a number/);
  for (const [name, value, expected] of [
    ['hyperplane', '0,0,0,0,1', /hyperplane="0,0,0,0,1": expected t, x=V/], ['color', 'blue', /color="blue": expected body/],
    ['camera', '1,2,3', /camera="1,2,3": expected six numbers/], ['bodies', 'nut', /there is no body 'nut', but 'cube'/],
    ['bodies', '[', /bodies="\[": expected names/],
  ]) {
    const before = await page.evaluate(() => JSON.stringify(view.viewer.model.state));
    await page.evaluate(([key, text]) => view.setAttribute(key, text), [name, value]);
    assert.match(await messageOf(page), expected);
    assert.match((await eventsOf(page, 'error')).at(-1)[1].message, expected);
    assert.equal(await page.evaluate(() => JSON.stringify(view.viewer.model.state)), before);
  }
  await page.close();
});

test('of two files that are named one after the other, the last is shown', async () => {
  const { page, errors } = await openWith('<t4d-view id="view" src="large.t4d"></t4d-view>');
  const [names, open] = await page.evaluate(async () => {
    for (const name of ['ring', 'forty', 'large', 'grows']) view.src = `${name}.t4d`;
    await view.drawn();
    return [view.viewer.model.panes.map(({ info }) => info.name), window.events.filter(([type]) => type === 'load').length];
  });
  assert.deepEqual([names, open], [['grows.t4d'], 2]);
  // Two beside each other, and none.
  const [both, none] = await page.evaluate(async () => {
    Object.assign(view, { src: 'ring.t4d', compare: 'grows.t4d' });
    await view.drawn();
    const shown = view.viewer.model.panes.map(({ info }) => info.name);
    Object.assign(view, { src: null, compare: null });
    await view.drawn();
    return [shown, view.viewer.model.panes.length];
  });
  assert.deepEqual([both, none], [['ring.t4d', 'grows.t4d'], 0]);
  assert.equal(await workersLeft(page, 0), 0);
  assert.deepEqual(errors, []);
  await page.close();
});

test('the wheel is the page\'s until the view is clicked', async () => {
  const { page } = await openWith('<t4d-view id="view" src="grows.t4d"></t4d-view><div style="height: 3000px"></div>');
  const state = () => page.evaluate(() => [view.camera.map((each) => each.toFixed(6)).join(), scrollY]);
  const [camera] = await state();
  await page.mouse.move(300, 100);
  await page.mouse.wheel(0, 50);
  await page.waitForFunction(() => scrollY > 0);
  assert.equal((await state())[0], camera);
  await page.mouse.click(300, 100);
  const [, scrolled] = await state();
  await page.mouse.wheel(0, 50);
  await page.waitForFunction((before) => view.camera.map((each) => each.toFixed(6)).join() !== before, camera);
  assert.equal((await state())[1], scrolled);
  await page.close();
});

test('without WebGL 2 it says so', async () => {
  const { page } = await openWith('');
  const text = await page.evaluate(() => {
    HTMLCanvasElement.prototype.getContext = () => null;
    document.body.insertAdjacentHTML('beforeend', '<t4d-view id="view" src="grows.t4d"></t4d-view>');
    return [view.shadowRoot.textContent, window.events[0][1].message];
  });
  assert.match(text[0], /^This browser has no WebGL 2/);
  assert.equal(text[1], text[0]);
  await page.close();
});

test('the script is a module as well, and properties may come before it', async () => {
  const { page, errors } = await openWith('<t4d-view id="view" src="grows.t4d"></t4d-view>', 'module.html');
  assert.equal((await page.evaluate(() => view.measure())).triangles, 12);
  const late = await browser.newPage();
  await late.goto(`${site.url}empty.html`);
  const time = await late.evaluate(async () => {
    const other = document.createElement('t4d-view');
    Object.assign(other, { src: '/grows.t4d', time: 0.5 });
    document.body.append(other);
    await new Promise((resolve) => {
      document.head.append(Object.assign(document.createElement('script'), { src: '/t4d-view.js', onload: resolve }));
    });
    await other.drawn();
    return other.time;
  });
  assert.equal(time, 0.5);
  assert.deepEqual(errors, []);
  await late.close();
  await page.close();
});

/** The files that npm would publish: [{ path, size }] and sizes. */
const packed = () => {
  const [pack] = JSON.parse(execFileSync('npm', ['pack', '--dry-run', '--json'], { cwd: path.join(here, '..'), encoding: 'utf8' }));
  return pack;
};

test('the npm package is the element, its types and no more, for bundlers, too', async () => {
  assert.deepEqual(packed().files.map((file) => file.path).sort(), ['README.md', 'dist/t4d-view.js', 'package.json', 't4d-view.d.ts']);
  const project = mkdtempSync(path.join(tmpdir(), 'project-'));
  mkdirSync(path.join(project, 'node_modules'));
  symlinkSync(path.join(here, '..'), path.join(project, 'node_modules/t4d-viewer'));
  writeFileSync(path.join(project, 'main.js'), "import 't4d-viewer';");
  const { outputFiles: [{ text }] } = await bundle({
    entryPoints: [path.join(project, 'main.js')], bundle: true, write: false, format: 'esm', logLevel: 'error',
  });
  assert.ok(text.includes('t4d-view'));
  rmSync(project, { recursive: true });
});
