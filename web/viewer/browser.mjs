// A server of files by ranges, and Chromium to look at them.
import { readFileSync } from 'node:fs';
import http from 'node:http';
import path from 'node:path';

import { chromium } from 'playwright-core';

import { chromiumOptions } from '../../tools/web/chromium.mjs';

const types = { '.html': 'text/html', '.js': 'text/javascript' };

/**
 * Serves the page at / and files by their names, as any static server does.
 * @param {Record<string, string|Uint8Array>} files paths or bytes by name
 */
export async function serve(files) {
  const requests = [];
  const server = http.createServer((request, response) => {
    const name = decodeURIComponent(new URL(request.url, 'http://localhost').pathname.slice(1)) || 'index.html';
    if (files[name] === undefined) {
      response.writeHead(404).end();
      return;
    }
    const bytes = typeof files[name] === 'string' ? readFileSync(files[name]) : files[name];
    const type = types[path.extname(name)] ?? 'application/octet-stream';
    const [, begin, end] = /^bytes=(\d*)-(\d*)$/.exec(request.headers.range ?? '') ?? [];
    if (begin === undefined) {
      response.writeHead(200, { 'Content-Type': type, 'Content-Length': bytes.length }).end(bytes);
      return;
    }
    const from = begin ? Number(begin) : Math.max(0, bytes.length - Number(end));
    const to = begin && end ? Math.min(bytes.length, Number(end) + 1) : bytes.length;
    requests.push({ name, from, to });
    response.writeHead(206, {
      'Content-Type': type, 'Content-Range': `bytes ${from}-${to - 1}/${bytes.length}`, 'Content-Length': to - from,
      ETag: '"one"',
    }).end(bytes.subarray(from, to));
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { url: `http://127.0.0.1:${server.address().port}/`, requests, close: () => server.close() };
}

export const launch = () => chromium.launch(chromiumOptions);

/** A page whose console errors are collected. */
export async function openPage(browser, url, options = {}) {
  const page = await browser.newPage({ viewport: { width: 640, height: 420 }, ...options });
  page.setDefaultTimeout(60_000);
  const errors = [];
  page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(url);
  await page.waitForFunction('window.t4dViewer !== undefined');
  await page.evaluate('window.t4dViewer.started');
  return { page, errors };
}
