// The page of examples, from a web server and from its folder.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';

import { measure, open } from 't4d-reader';

import { makeElement } from '../build.mjs';
import { launch, serve } from '../browser.mjs';

const web = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const at = (name) => path.join(web, 'examples', name);

let browser;
let site;
before(async () => {
  const names = ['index.html', 'heart.js', 'heart.t4d'];
  site = await serve({
    ...Object.fromEntries(names.map((name) => [`examples/${name}`, at(name)])),
    'viewer/dist/t4d-view.js': Buffer.from(await makeElement()),
  });
  browser = await launch();
});
after(async () => {
  await browser?.close();
  site?.close();
});

test('heart.js has the bytes of heart.t4d', () => {
  const [, base64] = /base64,([^']*)/.exec(readFileSync(at('heart.js'), 'utf8'));
  assert.ok(Buffer.from(base64, 'base64').equals(readFileSync(at('heart.t4d'))));
});

for (const place of ['server', 'folder']) {
  test(`from a ${place}, the examples do what they say`, async () => {
    const page = await browser.newPage({ viewport: { width: 1000, height: 1300 } });
    const errors = [];
    page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
    page.on('pageerror', (error) => errors.push(String(error)));
    await page.goto(place === 'server' ? `${site.url}examples/index.html` : pathToFileURL(at('index.html')).href);
    await page.evaluate(async () => {
      for (const view of document.querySelectorAll('t4d-view')) await view.drawn();
    });

    // The chart is the volume at 61 times, and the slider moves view, line and number.
    await page.waitForFunction(() => document.getElementById('volume').textContent !== '');
    const file = await open(new Uint8Array(readFileSync(at('heart.t4d'))));
    const volumeAt = async (time) => measure((await file.slice(time))[0]).volume;
    const volumes = await Promise.all(Array.from({ length: 61 }, (_, i) => volumeAt(i / 60)));
    const points = (await page.getAttribute('#chart polyline', 'points')).split(' ').map((pair) => pair.split(',').map(Number));
    assert.equal(points.length, 61);
    points.forEach(([x, y], i) => {
      assert.ok(Math.abs(x - i / 60) < 1e-12 && Math.abs(y - (1 - volumes[i] / Math.max(...volumes))) < 1e-12, `${x}, ${y}`);
    });
    await page.evaluate(() => {
      const slider = document.getElementById('slider');
      slider.value = 0.3;
      slider.dispatchEvent(new Event('input'));
    });
    const expected = `volume ${(await volumeAt(0.3)).toFixed(3)} at 0.30`;
    await page.waitForFunction((text) => document.getElementById('volume').textContent === text, expected);
    assert.deepEqual(await page.evaluate(() =>
      [document.getElementById('measured').time, Number(document.querySelector('#chart line').getAttribute('x1'))]), [0.3, 0.3]);

    // Either view moves the other.
    for (const [one, other] of [['left', 'right'], ['right', 'left']]) {
      const time = one === 'left' ? 0.25 : 0.75;
      await page.locator(`#${one} #slider`).fill(String(time));
      assert.equal(await page.evaluate((id) => document.getElementById(id).time, other), time);
      const { x, y } = await page.locator(`#${one} #canvas`).boundingBox();
      await page.mouse.move(x + 100, y + 60);
      await page.mouse.down();
      await page.mouse.move(x + 140, y + 80, { steps: 3 });
      await page.mouse.up();
      const [camera, followed] = await page.evaluate((ids) => ids.map((id) => document.getElementById(id).camera), [one, other]);
      followed.forEach((value, i) => assert.ok(Math.abs(value - camera[i]) < 1e-9, `${followed}, expected ${camera}`));
    }
    assert.deepEqual(errors, []);
    await page.close();
  });
}
