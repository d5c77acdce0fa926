// node picture.mjs OUT.png: renders picture.html with headless Chromium.
import { createReadStream, existsSync } from 'node:fs';
import http from 'node:http';
import path from 'node:path';

import { chromium } from 'playwright-core';

import { chromiumOptions } from './chromium.mjs';
import { root } from './t4d.mjs';

const web = path.join(root, 'tools/web');
const folders = {
  '/three/': path.join(web, 'node_modules/three'),
  '/demo/': path.join(root, 'build/demo'),
  '/': web,
};
const types = { '.html': 'text/html', '.js': 'text/javascript' };

const server = http.createServer((request, response) => {
  const url = new URL(request.url, 'http://localhost').pathname;
  const mount = Object.keys(folders).find((prefix) => url.startsWith(prefix));
  const file = path.join(folders[mount], url.slice(mount.length));
  if (!file.startsWith(folders[mount]) || !existsSync(file)) {
    response.writeHead(404).end();
    return;
  }
  response.setHeader('Content-Type', types[path.extname(file)] ?? 'application/octet-stream');
  createReadStream(file).pipe(response);
});
await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));

const browser = await chromium.launch(chromiumOptions);
try {
  const page = await browser.newPage({ viewport: { width: 1600, height: 700 } });
  page.setDefaultTimeout(300_000);
  page.on('console', (message) => message.type() === 'error' && console.error(message.text()));
  page.on('pageerror', (error) => console.error(error));
  await page.goto(`http://127.0.0.1:${server.address().port}/picture.html`);
  await page.waitForFunction('window.outcome !== undefined');
  const outcome = await page.evaluate('window.outcome');
  if (outcome !== 'done') throw new Error(outcome);
  await page.screenshot({ path: process.argv[2] });
  console.log(`wrote ${process.argv[2]}`);
} finally {
  await browser.close();
  server.close();
}
