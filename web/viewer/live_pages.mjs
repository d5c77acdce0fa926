// node live_pages.mjs SITE: checks that each <t4d-view> in the pages of a site shows its mesh, opened from the folder.
import { readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

import { launch } from './browser.mjs';

const site = path.resolve(process.argv[2]);
const pages = readdirSync(site, { recursive: true })
  .filter((name) => name.endsWith('.html') && readFileSync(path.join(site, name), 'utf8').includes('<t4d-view '));

/** The faults of the views of a page. */
async function wrongWith(browser, name) {
  const page = await browser.newPage({ viewport: { width: 1000, height: 700 } });
  await page.goto(pathToFileURL(path.join(site, name)).href);
  const wrong = await page.evaluate(() => Promise.all([...document.querySelectorAll('t4d-view')].map(async (view) => {
    if (!view.viewer) return 'the script of the element has not run';
    await view.drawn();
    const message = view.viewer.find('message');
    if (!message.hidden) return message.textContent;
    return (await view.measure()).triangles > 0 ? null : 'the slice is empty';
  })));
  await page.close();
  return wrong.filter(Boolean);
}

const browser = await launch();
const wrong = [];
for (const name of pages) wrong.push(...(await wrongWith(browser, name)).map((each) => `${name}: ${each}`));
await browser.close();
if (pages.length === 0) wrong.push(`${site}: no page has a <t4d-view>`);
for (const each of wrong) console.error(each);
console.log(`live views on ${pages.length} pages: ${pages.sort().join(', ')}`);
process.exitCode = wrong.length > 0 ? 1 : 0;
