// node picture.mjs FILE.t4d OUT.png: the moving picture of the README, an animated PNG of the page playing.
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { launch, openPage, serve } from './browser.mjs';
import { wholePage } from './build.mjs';

const frames = 24;
const milliseconds = 120;

const [file, out] = process.argv.slice(2);
const here = path.dirname(fileURLToPath(import.meta.url));

/** [{ type, data }] of a PNG. */
function chunksOf(png) {
  const chunks = [];
  for (let at = 8; at < png.length;) {
    const length = png.readUInt32BE(at);
    chunks.push({ type: png.toString('latin1', at + 4, at + 8), data: png.subarray(at + 8, at + 8 + length) });
    at += 12 + length;
  }
  return chunks;
}

const crcTable = Uint32Array.from({ length: 256 }, (_, value) => {
  for (let bit = 0; bit < 8; ++bit) value = (value >>> 1) ^ (value & 1 ? 0xedb88320 : 0);
  return value;
});

function chunk(type, data) {
  const bytes = Buffer.alloc(12 + data.length);
  bytes.writeUInt32BE(data.length, 0);
  bytes.write(type, 4, 'latin1');
  data.copy(bytes, 8);
  let crc = 0xffffffff;
  for (const byte of bytes.subarray(4, 8 + data.length)) crc = (crc >>> 8) ^ crcTable[(crc ^ byte) & 0xff];
  bytes.writeUInt32BE((crc ^ 0xffffffff) >>> 0, 8 + data.length);
  return bytes;
}

/** Pictures of one size as one that moves, without end. */
function animated(pngs) {
  const header = chunksOf(pngs[0]).find(({ type }) => type === 'IHDR').data;
  const control = Buffer.alloc(8);
  control.writeUInt32BE(pngs.length, 0);
  const parts = [Buffer.from('89504e470d0a1a0a', 'hex'), chunk('IHDR', header), chunk('acTL', control)];
  let sequence = 0;
  pngs.forEach((png, i) => {
    const frame = Buffer.alloc(26);
    frame.writeUInt32BE(sequence++, 0);
    header.copy(frame, 4, 0, 8); // width and height
    frame.writeUInt16BE(milliseconds, 20);
    frame.writeUInt16BE(1000, 22);
    parts.push(chunk('fcTL', frame));
    for (const { data } of chunksOf(png).filter(({ type }) => type === 'IDAT')) {
      if (i === 0) {
        parts.push(chunk('IDAT', data));
        continue;
      }
      const number = Buffer.alloc(4);
      number.writeUInt32BE(sequence++, 0);
      parts.push(chunk('fdAT', Buffer.concat([number, data])));
    }
  });
  return Buffer.concat([...parts, chunk('IEND', Buffer.alloc(0))]);
}

const parts = ['viewer.html', 't4d-view.js'].map((name) => readFileSync(path.join(here, 'dist', name), 'utf8'));
const site = await serve({ 'index.html': Buffer.from(wholePage(...parts)), 'mesh.t4d': file });
const browser = await launch();
try {
  const { page } = await openPage(browser, `${site.url}?file=mesh.t4d`, { viewport: { width: 480, height: 380 }, colorScheme: 'light' });
  await page.addStyleTag({ content: '#panel { display: none }' });
  const [begin, end] = await page.evaluate(() => {
    const { min, max } = window.t4dViewer.panes[0].bounds();
    return [min[3], max[3]];
  });
  const pngs = [];
  for (let i = 0; i < frames; ++i) {
    const t = begin + (end - begin) * i / (frames - 1);
    await page.evaluate(async (time) => {
      window.t4dViewer.set({ t: time });
      await window.t4dViewer.whole();
    }, t);
    pngs.push(await page.screenshot());
  }
  writeFileSync(out, animated(pngs));
} finally {
  await browser.close();
  site.close();
}
