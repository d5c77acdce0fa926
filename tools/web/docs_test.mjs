// The pages: their links resolve, and the output they show is what the program prints.
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import { existsSync, readFileSync, readdirSync, symlinkSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import { build, makeFolder, root, t4dRaw } from './t4d.mjs';

const folder = makeFolder('docs');
// Examples run the project's readers and writers by their place in it.
symlinkSync(path.join(root, 'conformance'), path.join(folder, 'fixtures', 'conformance'));
const foreign = (name) => name.startsWith('.') || ['build', 'node_modules'].includes(name);
const pagesBelow = (below) => readdirSync(path.join(root, below), { withFileTypes: true })
  .flatMap((entry) => {
    const name = path.join(below, entry.name);
    if (entry.isDirectory()) return foreign(entry.name) ? [] : pagesBelow(name);
    return name.endsWith('.md') ? [name] : [];
  });
const pages = pagesBelow('');
const read = (page) => readFileSync(path.join(root, page), 'utf8');
const withoutCode = (text) => text.replaceAll(/^ *```[^]*?^ *```$/gm, '');

/** The anchors that GitHub generates from a page's headings. */
const anchorsOf = (text) => [...withoutCode(text).matchAll(/^#+ (.*)$/gm)].map(([, heading]) =>
  heading.toLowerCase().replaceAll(/[^\p{L}\p{N} _-]/gu, '').replaceAll(' ', '-'));

for (const page of pages) {
  test(`links of ${page}`, () => {
    for (const [, link] of withoutCode(read(page)).matchAll(/\]\(([^)\s]+)\)/g)) {
      if (/^https?:/.test(link)) continue;
      const [file, anchor] = link.split('#');
      const target = file ? path.join(path.dirname(page), file) : page;
      assert.ok(existsSync(path.join(root, target)), link);
      if (anchor) assert.ok(anchorsOf(read(target)).includes(anchor), link);
    }
  });
}

/** The commands in the blocks of a page, with their output: [{command, output}]. */
function examplesOf(page) {
  const blocks = [...read(page).matchAll(/^( *)```(\w*)\n([^]*?)^\1```$/gm)]
    .filter(([, , language]) => language === '')
    .map(([, indent, , text]) => text.replaceAll(new RegExp(`^${indent}`, 'gm'), ''));
  return blocks.flatMap((text) => [...text.matchAll(/^\$ ((?:.*\\\n)*.*\n)((?:(?!\$ ).*\n)*)/gm)])
    .map(([, command, output]) => ({ command: command.trim(), output }));
}

// Times and memory vary between runs, file sizes and checksums between versions of zstd.
const varying = [
  [/ *\b[\d.]+ (bytes|kB|MB|GB|s)\b(?! long)/g, ' N $1'],
  [/"(seconds|peak_bytes|bytes|bytes_read)": [\d.e-]+/g, '"$1": N'],
  [/\b[0-9a-f]{8}\b/g, 'CHECKSUM'],
  [/( at byte|"offset":) \d+/g, '$1 N'],
  [/^(size of the file|construction|peak memory) .*$/gm, '$1'],
];
// Long jobs show progress. A terminal shows both streams, in an order that pipes do not preserve.
const comparable = (text) => varying
  .reduce((rest, [pattern, by]) => rest.replaceAll(pattern, by), text)
  .split('\n').map((line) => line.trimEnd())
  .filter((line) => line !== '' && !/^t4d: .*: \d+ %/.test(line)).sort();

// Numbers that depend on the version of a library: bytes of zstd, triangles of meshoptimizer.
const isOfLibraries = /^t4d du |--simplify /;

/** The expected lines in place of those whose numbers are within 1 % of theirs. */
function nearest(lines, expected) {
  const numbers = (line) => (line.match(/[\d.,e-]*\d/g) ?? []).map((word) => Number(word.replaceAll(',', '')));
  const words = (line) => line.replace(/[\d.,e-]*\d/g, '#').replace(/ +/g, ' ');
  return lines.map((line) => expected.find((other) => words(other) === words(line) &&
    numbers(line).every((number, i) => Math.abs(number - numbers(other)[i]) <= 0.01 * Math.abs(number))) ?? line);
}

/** Serves the files of a folder; returns the URL before their names. */
function serve(t, files) {
  const script = path.join(root, 'tests/web_server.py');
  const server = spawn('python3', [script, files], { stdio: ['ignore', 'pipe', 'inherit'] });
  t.after(() => server.kill());
  return new Promise((resolve) => {
    server.stdout.once('data', (port) => resolve(`http://127.0.0.1:${String(port).trim()}/plain/`));
  });
}

// The Python of the system has the packages that tools/setup installs.
const shell = (command, cwd, env = {}) => spawnSync('sh', ['-c', command], {
  cwd,
  encoding: 'utf8',
  env: { ...process.env, PATH: `${build}:/usr/bin:${process.env.PATH}`, ...env },
});

// The table of verbs: [{verb, page, command}].
const program = read('docs/README.md').match(/^## The program$[^]*?(?=^## )/m)[0];
const rows = [...program.matchAll(/^\| \[?(\w+)(?:\]\((.*?)\))? \|.*\| `(t4d .*)` \|$/gm)]
  .map(([, verb, link, command]) => ({ verb, page: link && `docs/${link.split('#')[0]}`, command }));

test('docs/README.md has the verbs of --help in its order, and their commands run', async (t) => {
  const verbs = t4dRaw('--help').stdout.match(/^Subcommands:\n((?: .*\n)*)/m)[1];
  assert.deepEqual(rows.map(({ verb }) => verb),
    [...verbs.matchAll(/^ {2}(\w+)/gm)].map(([, verb]) => verb));

  const inputs = path.join(makeFolder('readme'), 'inputs');
  shell(`t4d-fixtures --bolt-segments 12 ${inputs}`);
  for (const { verb, command } of rows) {
    // The checks of `conform backends` take minutes; docs/conform.md has examples of them.
    await t.test(command, { skip: verb === 'conform' }, () => {
      if (verb === 'recover') shell(program.match(/`(head -c .*?)`/)[1], inputs);
      if (verb === 'collide') shell(program.match(/`(t4d sweep torus.*?)`/)[1], inputs);
      if (verb === 'join') {
        const first = program.match(/`(t4d sweep\nbolt.obj .* first.t4d)`/)[1].replace('\n', ' ');
        shell(first, inputs);
        shell(first.replace('1/2 -o first', '2/2 -o second'), inputs);
      }
      if (verb === 'resolve') {
        const made = program.match(/For `resolve`, [^]*?\.\n/)[0];
        for (const [, step] of made.matchAll(/`(t4d [^`]*)`/g)) shell(step.replace('\n', ' '), inputs);
      }
      const quick = command.replace(/--voxel-size [\d.]+/, '--voxel-size 2')
        .replace(/--frames \d+/, '--frames 6');
      const done = shell(quick, inputs);
      assert.equal(done.status, verb === 'recover' ? 3 : 0, done.stderr);
    });
  }
});

/** Saves the Python blocks that begin with a comment `# NAME.py`, and scripts of bash likewise. */
function saveScripts(page, to) {
  for (const [, text, name] of read(page).matchAll(/^```bash\n(#!.*\n# (\w+\.\w+)\n[^]*?)^```$/gm)) {
    writeFileSync(path.join(to, name), text);
  }
  for (const [, text, name] of read(page).matchAll(/^```python\n(# (\w+\.py)\n[^]*?)^```$/gm)) {
    writeFileSync(path.join(to, name), text);
  }
}

// Pages are in the order of the table: later pages use the files of earlier ones.
for (const page of ['README.md', ...new Set(rows.map((row) => row.page).filter(Boolean)), 'docs/usd.md',
  'docs/motion.md', 'docs/mechanism.md']) {
  test(`examples of ${page}`, async (t) => {
    saveScripts(page, path.join(folder, 'fixtures'));
    const examples = examplesOf(page);
    assert.ok(examples.length > 0);
    const site = await serve(t, path.join(folder, 'fixtures'));
    for (const { command, output } of examples) {
      // Meshes that the project does not have.
      const missing = command.split(' ').find((word) => word.endsWith('.obj') && !word.includes('*') &&
        !existsSync(path.join(folder, 'fixtures', word)));
      await t.test(command, { skip: missing && `no ${missing}` }, () => {
        const done = shell(command.replace('https://example.com/', site),
          path.join(folder, 'fixtures'));
        const expected = comparable(output);
        const actual = comparable(done.stdout + done.stderr);
        assert.deepEqual(isOfLibraries.test(command) ? nearest(actual, expected) : actual, expected);
      });
    }
  });
}

for (const page of ['docs/tutorials/scientists.md', 'docs/tutorials/cells.md', 'docs/tutorials/artists.md',
  'docs/tutorials/machining.md', 'docs/tutorials/robots.md', 'docs/tutorials/many-machines.md']) {
  test(`examples of ${page}`, async (t) => {
    const place = path.join(makeFolder(path.basename(page, '.md')), 'fixtures');
    saveScripts(page, place);
    const examples = examplesOf(page);
    assert.ok(examples.length > 5);
    for (const { command, output } of examples) {
      await t.test(command, () => {
        const done = shell(command, place, { PYTHONPATH: path.join(build, 'python') });
        assert.deepEqual(comparable(done.stdout + done.stderr), comparable(output));
      });
    }
  });
}

test('docs/formats.md has a row for each format of the program, and no other', () => {
  const code = (words) => words.map((word) => `\`${word}\``).join(' ');
  const { formats } = JSON.parse(t4dRaw('formats', '--json').stdout);
  const expected = formats.map((format) => [
    format.name,
    format.id && code([format.id]),
    code(format.extensions),
    [format.reads && 'read', format.writes && 'written'].filter(Boolean).join(', '),
    format.recognised_by,
    format.keeps.join(', '),
  ]).map((cells) => `| ${cells.join(' | ')} |`);
  const table = read('docs/formats.md').match(/^\| format \|.*\n\|[-|]*\n((?:\|.*\n)*)/m)[1];
  assert.deepEqual(table.trimEnd().split('\n'), expected);
});
